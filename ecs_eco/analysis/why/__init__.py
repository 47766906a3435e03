"""Explain what happened in a recorded run: `write_why("my-run")`.

`case` reads the run, and `limits` finds the limiting factors of each species. `diagnose` traces extinctions
back to their first cause, `advice` selects values in the world file that affect it, and `page` and `figure`
present the results. General-purpose statistics belong in `ecs_eco.analysis`.
"""

from ecs_eco.analysis.why.case import Case, Food
from ecs_eco.analysis.why.diagnose import VERDICTS, diagnose
from ecs_eco.analysis.why.page import explain, sentences, write_why

__all__ = ["VERDICTS", "Case", "Food", "diagnose", "explain", "sentences", "write_why"]
