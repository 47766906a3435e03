"""Age, sex, reproduction and descent."""

from ecs_eco.engine.schema import component, f32, f64, i64, u8, u16, u64

NONE, FEMALE, MALE = 0, 1, 2


@component
class Biology:
    """Age, sex and fertility of an organism."""

    age: f32 = 0.0  # [s] time since birth
    # [s] age in addition to the ticks since birth, for founders and if `age` was set; written by Age
    head_start: f64 = 0.0
    sex: u8.within(0, 2) = 0  # 0 none, 1 female, 2 male
    fertility: f32 = 1.0  # fraction of the full probability of reproduction, from 0 to 1


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


@component
class Breeding:
    """The course of fertility over a life and over a year."""

    peak: f32.within(0, 1) = 1.0  # fertility at the prime, in season
    maturity: f32 = 0.0  # [s] age at which fertility begins
    prime: f32 = 0.0  # [s] age of peak fertility
    end: f32 = 1.0e30  # [s] age at which fertility ends; 1e30: never
    season: f32 = 0.0  # time of year of peak fertility, as a fraction of a year
    width: f32.within(0, 1e30) = 0.0  # standard deviation of the season, as a fraction of a year; 0: all year


@component
class Gestation:
    """The litter that a mother carries, and the time at which an organism can mate again."""

    carrying: u16 = 0  # number of young conceived; 0: not pregnant
    due: i64 = 0  # tick of the birth
    father: u64 = 0  # uid
    sperm: u8["loci"].within(0, "highest letter") = 0  # the father's genome
    energy: f32 = 0.0  # [energy] contributed to the litter by the father
    rest: i64 = 0  # first tick in which it can mate again


@component
class Incubation:
    """The development of an egg, as the equivalent time at its reference temperature."""

    developed: f64 = 0.0  # [s]


@component
class Parentage:
    """The parents, dead or alive; founders and immigrants have no recorded parents."""

    mother: u64 = 0  # uid of the mother; 0: none
    father: u64 = 0  # uid of the father; 0: none, or a single parent
