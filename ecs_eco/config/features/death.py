"""Death: the limits within which members survive, and the objects that dead members become."""

import math
from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Field, model_validator

from ecs_eco.config.features.feature import Feature, Key, WorldSections, of_each
from ecs_eco.engine.errors import Problem, unknown
from ecs_eco.inputs.section import FREE, Real, Section, about, quantity, table


class Lethal(Section, own=True):
    """The range of a property outside which the organism dies."""

    property: str = about(
        "energy, age, fertility, a property or substance of the species, or a custom Component.field"
    )
    min: Real | None = quantity("it dies at or below this value", "unit of the property", None)
    max: Real | None = quantity("it dies at or above this value", "unit of the property", None)
    cause_below: Annotated[str, Field(max_length=60)] = about("cause of death below min", "", former="low")
    cause_above: Annotated[str, Field(max_length=60)] = about("cause of death above max", "", former="high")

    @model_validator(mode="before")
    @classmethod
    def _name_causes(cls, data: object) -> Any:
        if isinstance(data, dict) and isinstance(data.get("property"), str):
            words = {"cause_below": ("min", "too low"), "cause_above": ("max", "too high")}
            named = {
                w: f"{data['property']} {text}"
                for w, (end, text) in words.items()
                if data.get(end) is not None
            }
            return named | {k: v for k, v in data.items() if not (k in named and v == "")}
        return data


class Mortality(Feature, after="hatch"):
    """Members die outside their limits and become objects: systems `Perish` and `LeaveRemains`."""

    lethal: list[Lethal] = table("limits beyond which it dies", list, change=FREE)
    remains: str | None = about("object type that dead members become", None)

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        if species.remains is not None and species.remains not in config.objects:
            yield unknown((*key, "remains"), "object type", species.remains, config.objects)
        born = {"energy": species.metabolism.energy, "age": 0.0, "fertility": species.fertility}
        born |= species.properties | species.substances | {name: 0.0 for name, _ in of_each(species, "feels")}
        born |= (own := config.own_fields(str(key[1])))
        for i, lethal in enumerate(species.lethal):
            at, value = (*key, "lethal", i), born.get(lethal.property)
            low = -math.inf if lethal.min is None else lethal.min
            high = math.inf if lethal.max is None else lethal.max
            if value is None:
                if not config.may_have(str(key[1]), lethal.property):
                    yield unknown(
                        (*at, "property"),
                        "property or substance of the species",
                        lethal.property,
                        (*species.own(), *own),
                    )
            elif lethal.min is None and lethal.max is None:
                yield Problem((*at, "min"), "neither min nor max is given", allowed="min, max or both")
            elif low >= high:
                yield Problem((*at, "min"), "not below max", low, f"less than {high:g}")
            elif not low < value < high and not (lethal.property == "age" and value == 0.0 < high):
                end, fault = (
                    "min" if value <= low else "max",
                    f"deadly at birth, when {lethal.property} is {value:g}",
                )
                yield Problem((*at, end), fault, getattr(lethal, end), "a range around the value at birth")

    @staticmethod
    def causes(species: "Mortality", key: Key) -> Iterator[tuple[Key, str]]:
        for i, limit in enumerate(species.lethal):
            for end, cause in (("min", limit.cause_below), ("max", limit.cause_above)):
                if getattr(limit, end) is not None:
                    yield (*key, "lethal", i, end), cause

    @staticmethod
    def undivided(species: "Mortality") -> Iterator[tuple[str, str]]:
        if species.remains is not None:
            yield "remains", "whose dead members become objects"
