"""The experience of an individual learner since its last update."""

from ecs_eco.engine.schema import component, f32, i16, i32


@component
class Experience:
    """The rollout of one organism: `length` transitions, in chronological order."""

    observations: f32["horizon", "channels"].heavy = 0.0
    choices: i16["horizon", "groups"].heavy = 0
    log_probability: f32["horizon"].heavy = 0.0  # log-probability of the choice under the policy that made it
    value: f32["horizon"].heavy = 0.0  # value estimate at decision time
    reward: f32["horizon"].heavy = 0.0  # reward that followed
    length: i32.within(0, "horizon") = 0
