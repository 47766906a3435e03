"""What organisms and objects are made of: data without behaviour, a file per component.

A component declares fields with a type, a default and a unit. What changes them belongs to `ecs_eco.systems`.
"""

from ecs_eco.components.biology import Biology
from ecs_eco.components.body import Body
from ecs_eco.components.chemistry import Chemistry
from ecs_eco.components.genome import Genome
from ecs_eco.components.metabolism import Metabolism
from ecs_eco.components.nervous import Nervous
from ecs_eco.components.physical import Physical
from ecs_eco.components.position import Position
from ecs_eco.components.velocity import Velocity

__all__ = ["Biology", "Body", "Chemistry", "Genome", "Metabolism", "Nervous", "Physical", "Position", "Velocity"]
