"""Pregnancy."""

from ecs_eco.engine.schema import component, f32, i64, u8, u16, u64


@component
class Gestation:
    """The litter that a mother carries, and the time at which an organism can mate again."""

    carrying: u16 = 0  # number of young conceived; 0: not pregnant
    due: i64 = 0  # tick of the birth
    father: u64 = 0  # uid
    sperm: u8["loci"].within(0, "highest letter") = 0  # the father's genome
    energy: f32 = 0.0  # [energy] contributed to the litter by the father
    rest: i64 = 0  # first tick in which it can mate again
