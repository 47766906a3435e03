"""The biological properties in Definition 1."""

from ecs_eco.engine.schema import component, f32, f64, u8

NONE, FEMALE, MALE = 0, 1, 2


@component
class Biology:
    """Age, sex and fertility of an organism."""

    age: f32 = 0.0  # [s] time since birth
    # [s] age in addition to the ticks since birth, for founders and if `age` was set; written by Age
    head_start: f64 = 0.0
    sex: u8.within(0, 2) = 0  # 0 none, 1 female, 2 male
    fertility: f32 = 1.0  # fraction of the full probability of reproduction, from 0 to 1
