"""Sensors, reflexes, happiness and decisions."""

from ecs_eco.engine.schema import boolean, component, f32, i8, u8


@component
class Sensor:
    """The sensors of one organism: the latest readings x, positions on the body and ranges, in the species'
    order.

    It is read-only and computed on access; genes write to `Senses` instead.
    """

    # in units of each sensor, in the order of `table.species.nerves.channels`; NaN until it first senses
    readings: f32["channels"] = 0.0
    radius: f32["sensors"] = 0.0  # [m] range of each sensor; 0: no range
    forward: f32["sensors"] = 0.0  # [radii of the body] position of each sensor
    left: f32["sensors"] = 0.0  # [radii of the body]


@component
class Senses:
    """The range and position of each sensor of one organism, in the order of the species' sensors."""

    radius: f32["sensors"] = 0.0  # [m]
    forward: f32["sensors"] = 0.0  # [radii of the body]
    left: f32["sensors"] = 0.0  # [radii of the body]


@component
class Reflexes:
    """Connection weights and thresholds of one organism's reflex network, in the order of the species'
    connections."""

    weight: i8["connections"] = 0  # -1 blocks the action, 0 leaves it to the policy, 1 forces it
    threshold: f32["connections"] = 0.0  # reading above which the connection is active


@component
class Instincts:
    """All weights of one organism's reflex network and happiness network, in one vector each; they do not
    change during life."""

    reflex: f32["reflex_weights"].heavy = 0.0
    happiness: f32["happiness_weights"].heavy = 0.0


@component
class HappinessWeights:
    """Weights of one organism's happiness network, in the order of the species' happiness weights."""

    weight: f32["desires"] = 0.0


@component
class Nervous:
    """The decision in this tick, and the happiness computed from its observations."""

    decision: u8["actions"] = 0  # the multi-hot vector H(y + z)
    happiness: f32 = 0.0  # computed from the observations in this tick
    reward: f32 = 0.0  # change in happiness in this tick; a system in the `feel` phase may write it
    awake: boolean = False  # whether it has sensed before; a newborn has no previous happiness


@component
class NeuralCost:
    """The energy that one organism's nervous system burned in this tick, which `Metabolism.burnt` includes."""

    brain: f32 = 0.0  # [energy] for hidden units
    learning: f32 = 0.0  # [energy] for transitions recorded to learn from
    senses: f32 = 0.0  # [energy] for receptors


@component
class Motor:
    """The values executed for continuous actions in this tick, in the actions' units."""

    command: f32["continuous"] = 0.0
    # the policy's draws in each tick of an individual learner's rollout
    drawn: f32["horizon", "continuous"].heavy = 0.0
