"""How the substances of bodies change: decay."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ecs_eco.engine.section import FREE, Positive, Section, quantity


class Decomposition(Section, change=FREE):
    """Decay: what it holds goes into the first field of each substance, dc/dt = −rate c (Olson 1963), or is
    lost where there is none; the object vanishes when little is left."""

    rate: Positive = quantity("share given back in a second", "1/s")
    left: Annotated[float, Field(gt=0, lt=1)] = quantity(
        "share after whose time it gives back the rest at once and vanishes", "1", 0.01
    )
