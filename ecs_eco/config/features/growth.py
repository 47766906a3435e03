"""Growth: the young are smaller than adults, and grow."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.engine.errors import Problem
from ecs_eco.engine.section import (
    FREE,
    SHAPE,
    NonNegative,
    Positive,
    Section,
    about,
    is_absent,
    is_empty,
    quantity,
)

Newborn = Annotated[float, Field(ge=1e-9, le=1)]


class Growth(Section, change=FREE, own=True):
    """Growth from newborn to adult size, which is that of `body`; the costs of living follow the mass to the
    power 3/4. Founders and immigrants are adults."""

    law: Literal["von_bertalanffy", "west"] = about(
        "what approaches the adult's at a constant rate: the cube root of the mass (von Bertalanffy 1957) or "
        "the fourth root (West, Brown & Enquist 2001)",
        "von_bertalanffy",
    )
    rate: Positive = quantity("of that approach; of an adult mass that is a gene, the one of body", "1/s")
    newborn: Newborn = quantity("mass of a newborn, as a share of the adult's", "1", 0.05)
    cost: NonNegative = quantity("energy burnt for each kilogram of growth", "energy/kg", 0.0)
    reserve: NonNegative = quantity(
        "energy that it keeps back: it grows by what it holds beyond; "
        "with 0 it spends all on growth, and starves",
        "energy",
        0.0,
    )
    pace: NonNegative = quantity(
        "power of the mass, as a share of the adult's, with which speeds rise; 0: "
        "the young are as fast as adults",
        "1",
        0.0,
    )
    store: NonNegative = quantity(
        "power of the mass, as a share of the adult's, with which "
        "metabolism.energy_max rises, 1 for fat in proportion to the body; 0: the "
        "young hold as much as adults. What one was born with beyond it is kept",
        "1",
        0.0,
        exclude_if=is_empty,
    )


class Growing(Feature, after="breeding"):
    """The young grow: system `GrowUp`, component `Stature`."""

    growth: Growth | None = about(
        "how the young grow; absent: they are born as large as adults",
        None,
        exclude_if=is_absent,
        change=SHAPE,
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield a reserve that leaves nothing for growth."""
        way, most = species.growth, species.metabolism.energy_max
        if way is not None and way.cost and way.reserve >= most:
            fault = "as much as energy_max: nobody would grow"
            yield Problem((*key, "growth", "reserve"), fault, way.reserve, f"less than {most:g}")
