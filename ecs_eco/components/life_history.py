"""When and how an organism reproduces, and how old it can get, where this is individual and not the species'."""

from ecs_eco.engine.schema import component, f32, u8


@component
class LifeHistory:
    """The timing of one organism's life (the hyperparameters of Definition 3
    that regulate reproduction and death)."""

    age_max: f32 = 3.0e38  # [s] it dies of old age at
    age_min: f32 = 0.0  # [s] fertile from
    energy_min: f32 = 0.0  # [energy] that it needs to reproduce
    energy_given: f32 = 0.0  # [energy] of each of its newborn
    litter: f32.within(0, 65_535) = 1.0  # newborn at a time, rounded
    choice: u8.within(0, 3) = 0  # of a mate: 0 nearest, 1 random, 2 richest, 3 oldest
