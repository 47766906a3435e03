"""Individual parameters of learning."""

from ecs_eco.engine.schema import component, f32


@component
class LearningRates:
    """Hyperparameters of one organism's learning (the paper: PPO with the animals' individual
    hyperparameters)."""

    learning_rate: f32 = 3e-4
    discount: f32 = 0.99  # weight of a reward one tick later
    entropy: f32 = 0.01  # weight of the entropy bonus
