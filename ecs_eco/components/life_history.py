"""Individual timing of reproduction and death."""

from ecs_eco.engine.schema import component, f32, u8


@component
class LifeHistory:
    """The timing of one organism's life (the hyperparameters of Definition 3 that regulate reproduction
    and death)."""

    age_max: f32 = 3.0e38  # [s] age at which it dies
    age_min: f32 = 0.0  # [s] age at which fertility begins
    energy_min: f32 = 0.0  # [energy] needed to reproduce
    energy_given: f32 = 0.0  # [energy] given to each newborn
    litter: f32.within(0, 65_535) = 1.0  # litter size, rounded
    choice: u8.within(0, 3) = 0  # choice of mate: 0 nearest, 1 random, 2 richest, 3 oldest
