"""The components of organisms and objects: data without behavior, one component per file.

A component declares fields with a type, a default and a unit. `ecs_eco.systems` changes them. Values that all
members of a species share are not stored in components but in `ecs_eco.life.kind.Kind`.
"""

from ecs_eco._lazy import lazy
from ecs_eco.components.biology import Biology
from ecs_eco.components.body import Body
from ecs_eco.components.breeding import Breeding
from ecs_eco.components.carrier import Carrier
from ecs_eco.components.chemistry import Chemistry
from ecs_eco.components.coat import Coat
from ecs_eco.components.defence import Defence
from ecs_eco.components.experience import Experience
from ecs_eco.components.genome import Genome
from ecs_eco.components.gestation import Gestation
from ecs_eco.components.growth import Growth
from ecs_eco.components.happiness_weights import HappinessWeights
from ecs_eco.components.heat_exchange import HeatExchange
from ecs_eco.components.incubation import Incubation
from ecs_eco.components.instincts import Instincts
from ecs_eco.components.learning_rates import LearningRates
from ecs_eco.components.life_history import LifeHistory
from ecs_eco.components.load import Load
from ecs_eco.components.matter import Matter
from ecs_eco.components.memory import Memory
from ecs_eco.components.metabolism import Metabolism
from ecs_eco.components.motor import Motor
from ecs_eco.components.nervous import Nervous
from ecs_eco.components.parentage import Parentage
from ecs_eco.components.physical import Physical
from ecs_eco.components.policy import Policy
from ecs_eco.components.position import Position
from ecs_eco.components.reflexes import Reflexes
from ecs_eco.components.route import Route
from ecs_eco.components.senses import Senses
from ecs_eco.components.sensor import Sensor
from ecs_eco.components.shape import Shape
from ecs_eco.components.speed_scale import SpeedScale
from ecs_eco.components.stature import Stature
from ecs_eco.components.traits import Traits
from ecs_eco.components.velocity import Velocity

__getattr__ = lazy(__name__, {})  # former names

__all__ = [
    "Biology",
    "Body",
    "Breeding",
    "Carrier",
    "Chemistry",
    "Coat",
    "Defence",
    "Experience",
    "Genome",
    "Gestation",
    "Growth",
    "HappinessWeights",
    "HeatExchange",
    "Incubation",
    "Instincts",
    "LearningRates",
    "LifeHistory",
    "Load",
    "Matter",
    "Memory",
    "Metabolism",
    "Motor",
    "Nervous",
    "Parentage",
    "Physical",
    "Policy",
    "Position",
    "Reflexes",
    "Route",
    "Senses",
    "Sensor",
    "Shape",
    "SpeedScale",
    "Stature",
    "Traits",
    "Velocity",
]
