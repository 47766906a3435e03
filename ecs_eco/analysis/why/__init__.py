"""What happened in a recorded run, and why: `write_why("my-run")`.

`case` reads the run, `limits` finds what limited each species; `diagnose` follows causes to the first of them,
`advice` names values of the world file that act on it; `page` and `figure` present it. Statistics of general use
belong to `ecs_eco.analysis`.
"""

from ecs_eco.analysis.why.case import Case, Food
from ecs_eco.analysis.why.diagnose import VERDICTS, diagnose
from ecs_eco.analysis.why.page import explain, sentences, write_why

__all__ = ["VERDICTS", "Case", "Food", "diagnose", "explain", "sentences", "write_why"]
