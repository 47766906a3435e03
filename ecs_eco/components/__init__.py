"""The components of organisms and objects: data without behavior, one component per file.

A component declares fields with a type, a default and a unit. `ecs_eco.systems` changes them. Values that all
members of a species share are not stored in components but in `ecs_eco.life.kind.Kind`.
"""

from ecs_eco._lazy import file_of, lazy
from ecs_eco.components.biology import Biology as Biology
from ecs_eco.components.body import Body as Body
from ecs_eco.components.breeding import Breeding as Breeding
from ecs_eco.components.carrier import Carrier as Carrier
from ecs_eco.components.chemistry import Chemistry as Chemistry
from ecs_eco.components.coat import Coat as Coat
from ecs_eco.components.defence import Defence as Defence
from ecs_eco.components.experience import Experience as Experience
from ecs_eco.components.genome import Genome as Genome
from ecs_eco.components.gestation import Gestation as Gestation
from ecs_eco.components.growth import Growth as Growth
from ecs_eco.components.happiness_weights import HappinessWeights as HappinessWeights
from ecs_eco.components.heat_exchange import HeatExchange as HeatExchange
from ecs_eco.components.incubation import Incubation as Incubation
from ecs_eco.components.instincts import Instincts as Instincts
from ecs_eco.components.learning_rates import LearningRates as LearningRates
from ecs_eco.components.life_history import LifeHistory as LifeHistory
from ecs_eco.components.load import Load as Load
from ecs_eco.components.matter import Matter as Matter
from ecs_eco.components.memory import Memory as Memory
from ecs_eco.components.metabolism import Metabolism as Metabolism
from ecs_eco.components.motor import Motor as Motor
from ecs_eco.components.nervous import Nervous as Nervous
from ecs_eco.components.parentage import Parentage as Parentage
from ecs_eco.components.physical import Physical as Physical
from ecs_eco.components.policy import Policy as Policy
from ecs_eco.components.position import Position as Position
from ecs_eco.components.reflexes import Reflexes as Reflexes
from ecs_eco.components.route import Route as Route
from ecs_eco.components.senses import Senses as Senses
from ecs_eco.components.sensor import Sensor as Sensor
from ecs_eco.components.shape import Shape as Shape
from ecs_eco.components.speed_scale import SpeedScale as SpeedScale
from ecs_eco.components.stature import Stature as Stature
from ecs_eco.components.traits import Traits as Traits
from ecs_eco.components.velocity import Velocity as Velocity

# the components imported above, and former names
__getattr__ = lazy(__name__, {f".{file_of(name)}": name for name in dir() if name[0].isupper()})
