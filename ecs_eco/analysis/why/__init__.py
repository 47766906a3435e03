"""What happened in a recorded run, and why: `write_why("my-run")`.

`case` reads the run, `conduct` measures what animals did and how near they were to each other, `limits` what
limited each species in each phase; `diagnose` follows the causes to the first of them, `advice` names the
values of the world file that act on it; `words` and `figure` present it. Statistics of general use belong to
`ecs_eco.analysis`.
"""

from ecs_eco.analysis.why.case import Case, Food
from ecs_eco.analysis.why.diagnose import VERDICTS, diagnose
from ecs_eco.analysis.why.page import explain, write_why
from ecs_eco.analysis.why.words import sentences

__all__ = ["VERDICTS", "Case", "Food", "diagnose", "explain", "sentences", "write_why"]
