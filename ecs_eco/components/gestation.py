"""Pregnancy."""

from ecs_eco.schema import boolean, component, f32, u8, u64


@component
class Gestation:
    """What a mother carries, and when she can mate again."""

    carrying: boolean = False
    due: f32 = 0.0  # [s] until birth
    father: u64 = 0  # uid
    sperm: u8["loci"] = 0  # the father's genome
    energy: f32 = 0.0  # [energy] that the father gave
    rest: f32 = 0.0  # [s] until it can mate again
