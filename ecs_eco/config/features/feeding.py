"""Feeding: the diet of members, and their defense against being eaten."""

from collections.abc import Iterator
from typing import Any

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.config.rules import at_most
from ecs_eco.engine.errors import Problem, unknown
from ecs_eco.engine.submodel import Submodel
from ecs_eco.inputs.section import FREE, Column, NonNegative, Real, Section, Share, about, quantity, table


class Diet(Section, own=True):
    """One kind of food."""

    eats: str = about("a species or an object type")
    reach: NonNegative = quantity("maximum distance between the bodies' surfaces", "m", 0.0)
    chance: Share = quantity("probability of success per second of contact", "1", 1.0)
    gain: Real = quantity("energy gained per item, regardless of its energy", "energy", 0.0)
    efficiency: Share = quantity("proportion of the item's energy that is also gained", "1", 0.0)
    deadly: bool = about("whether its poison kills the eater", False)
    satiation: Real | None = quantity(
        "eats only below this energy; default: until it is full", "energy", None, former="until"
    )
    assimilation: Share | None = quantity(
        "proportion of the item's substances that the eater's body keeps, if both contain substances; the "
        "rest enters each substance's first field or, without a field, is lost; default: all of it",
        "1",
        omit=True,
    )
    confusion: str | None = about(
        "name of the nearest sensor with which it aims at this food: the probability of success is divided by "
        "the number of items in the sensor's range and field of view, and is 0 without any; default: the "
        "number has no effect",
        omit=True,
    )


class Defence(Section, change=FREE, own=Column("Defence")):
    """Defense against being eaten, and its cost."""

    submodel = Submodel(
        "Defence",
        where=("defence.toughness", "defence.poison", "Defence"),
        reads=("defence",),
        rules={
            "": "A bite fails with probability `toughness`; the eater loses the energy `poison`. Growth and "
            "the proportion of seeds that germinate are multiplied by `max(0, 1 − cost (toughness + poison))`."
        },
    )

    toughness: Share = quantity("proportion of bites that fail", "1", 0.0)
    poison: NonNegative = quantity("energy lost by its eater", "energy", 0.0)
    cost: NonNegative = quantity(
        "proportion of growth and of germinating seeds lost per unit of toughness and of poison",
        "1",
        0.0,
        own=True,
    )


class Defending(Feature, after="locomotion"):
    """Members are tough or poisonous: component `Defence`, read by system `Feed`."""

    defence: Defence = table("defense against being eaten", Defence)


class Feeding(Feature, after="emits"):
    """Members eat organisms and objects: system `Feed`."""

    diet: list[Diet] = table("its food", list, change=FREE)

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        food = [*config.species, *config.objects]
        eaten: set[str] = set()
        for i, diet in enumerate(species.diet):
            at = (*key, "diet", i)
            if diet.eats not in food:
                yield unknown((*at, "eats"), "species or object type", diet.eats, food)
            elif diet.eats in eaten:
                yield Problem((*at, "eats"), "named twice in this diet", diet.eats, "one entry per food")
            eaten.add(diet.eats)
            if diet.model_fields_set.isdisjoint(("gain", "efficiency")):
                yield Problem(
                    (*at, "gain"), "neither gain nor efficiency is given", allowed="gain, efficiency or both"
                )
            if diet.efficiency and diet.eats in config.objects and config.objects[diet.eats].energy is None:
                fault = f"{diet.eats} contains no energy"
                allowed = f"a gain instead, or objects.{diet.eats}.energy = {{ initial = 0.1 }}"
                yield Problem((*at, "efficiency"), fault, diet.efficiency, allowed)
            yield from at_most((*at, "reach"), config.space.too_wide, diet.reach, config.space.widest)
            aims = [s.name for s in species.sensors if s.kind == "nearest" and s.target == diet.eats]
            if diet.confusion is not None and diet.confusion not in aims:
                yield unknown((*at, "confusion"), f"nearest sensor for {diet.eats}", diet.confusion, aims)

    @staticmethod
    def undivided(species: Any) -> Iterator[tuple[str, str]]:
        for i, food in enumerate(species.diet):
            if food.confusion is not None:
                yield f"diet.{i}.confusion", "confused by the number of its prey"

    @staticmethod
    def meets(species: Any) -> Iterator[tuple[str, str, float]]:
        for i, food in enumerate(species.diet):
            yield f"diet.{i}", food.eats, food.reach

    @staticmethod
    def causes(species: Any, key: Key) -> Iterator[tuple[Key, str]]:
        for i, food in enumerate(species.diet):
            yield (*key, "diet", i), f"eaten by {key[1]}"
            if food.deadly:
                yield (*key, "diet", i), f"poisoned by {food.eats}"
