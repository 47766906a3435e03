"""Care: parents feed their young."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from ecs_eco.config.features.feature import Feature, Key, WorldSections
from ecs_eco.engine.errors import Problem
from ecs_eco.engine.section import FREE, SHAPE, NonNegative, Positive, Section, about, is_absent, quantity

Arriving = Annotated[float, Field(ge=1e-6, le=1)]


class Care(Section, change=FREE, own=True):
    """Feeding of the young by their parents, who pay for it.

    With an action `nurse` a parent feeds when it decides to, else whenever it can.
    """

    rate: Positive = quantity("most energy given to each of the young", "energy/s")
    until: Positive = quantity("age until which the young are fed", "s")
    reach: NonNegative = quantity("distance between the surfaces of both bodies", "m", 0.0)
    reserve: NonNegative = quantity("energy that a parent keeps back", "energy", 0.0)
    efficiency: Arriving = quantity("share of the energy given that reaches the young", "1", 1.0)
    by: Literal["mother", "father", "both"] = about("who feeds them", "mother")


class Caring(Feature, after="reproduction"):
    """Parents feed their young, by decision or whenever they can: system `Nurse`."""

    acts = {"nurse": ("nurse",)}
    care: Care | None = about(
        "how parents feed their young; absent: they do not", None, exclude_if=is_absent, change=SHAPE
    )

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield an action that nurses nobody."""
        if species.care is None and "nurse" in species.actions and "nurse" not in species.ranges():
            at = (*key, "actions", "nurse")
            yield Problem(at, "it cares for nobody", species.actions["nurse"], "care, or no such group")
