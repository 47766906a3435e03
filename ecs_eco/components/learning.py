"""The networks of organisms that each learn by themselves."""

from ecs_eco.engine.schema import component, f32, i16, i32


@component
class Policy:
    """Weights of one organism's policy and value networks in one vector, and the state of their optimizer."""

    weights: f32["weights"].heavy = 0.0
    moment_1: f32["weights"].heavy = 0.0  # Adam's running mean of gradients
    moment_2: f32["weights"].heavy = 0.0  # Adam's running mean of squared gradients
    steps: i32 = 0  # optimizer steps since birth
    updates: i32 = 0  # updates since birth, one per rollout


@component
class Memory:
    """The state of a policy network with a memory; zero at birth."""

    state: f32["memory"].heavy = 0.0
    began: f32["memory"].heavy = 0.0  # its value at the beginning of an individual learner's current rollout


@component
class Experience:
    """The rollout of one organism: `length` transitions, in chronological order."""

    observations: f32["horizon", "channels"].heavy = 0.0
    choices: i16["horizon", "groups"].heavy = 0
    log_probability: f32["horizon"].heavy = 0.0  # log-probability of the choice under the policy that made it
    value: f32["horizon"].heavy = 0.0  # value estimate at decision time
    reward: f32["horizon"].heavy = 0.0  # reward that followed
    length: i32.within(0, "horizon") = 0


@component
class LearningRates:
    """Hyperparameters of one organism's learning (the paper: PPO with the animals' individual
    hyperparameters)."""

    learning_rate: f32 = 3e-4
    discount: f32 = 0.99  # weight of a reward one tick later
    entropy: f32 = 0.01  # weight of the entropy bonus
