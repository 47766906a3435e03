"""The components of organisms and objects: data without behavior, one file per subject.

A component declares fields with a type, a default and a unit. `ecs_eco.systems` changes them. Values that all
members of a species share are not stored in components but in `ecs_eco.life.kind.Kind`.
"""

from ecs_eco._lazy import lazy
from ecs_eco.components.body import Body as Body, Shape as Shape, Stature as Stature
from ecs_eco.components.chemistry import Chemistry as Chemistry, Matter as Matter
from ecs_eco.components.energy import Defence as Defence, Growth as Growth, Metabolism as Metabolism
from ecs_eco.components.heredity import Genome as Genome, Traits as Traits
from ecs_eco.components.learning import (
    Experience as Experience,
    LearningRates as LearningRates,
    Memory as Memory,
    Policy as Policy,
)
from ecs_eco.components.motion import (
    Carrier as Carrier,
    Load as Load,
    Position as Position,
    Route as Route,
    SpeedScale as SpeedScale,
    Velocity as Velocity,
)
from ecs_eco.components.nerves import (
    HappinessWeights as HappinessWeights,
    Instincts as Instincts,
    Motor as Motor,
    Nervous as Nervous,
    NeuralCost as NeuralCost,
    Reflexes as Reflexes,
    Senses as Senses,
    Sensor as Sensor,
)
from ecs_eco.components.physics import Coat as Coat, HeatExchange as HeatExchange, Physical as Physical
from ecs_eco.components.reproduction import (
    Biology as Biology,
    Breeding as Breeding,
    Gestation as Gestation,
    Incubation as Incubation,
    LifeHistory as LifeHistory,
    Parentage as Parentage,
)

# the components imported above, and former names
__getattr__ = lazy(__name__, {".": " ".join(name for name in dir() if name[0].isupper())})
