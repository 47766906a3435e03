"""The body of an organism or an inanimate object: its shape, size and mass."""

import math
from typing import Annotated, Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from ecs_eco.inputs.section import (
    COLUMN,
    FORM,
    FREE,
    LARGEST,
    SMALLEST,
    Positive,
    Real,
    Section,
    about,
    quantity,
)


class Body(Section):
    """A sphere, a capsule (a cylinder along its heading with a hemisphere at each end) or an upright box. In
    a plane, a body is its outline from above: a disc, a stadium or a rectangle."""

    shape: Literal["sphere", "capsule", "box"] = about("shape", "sphere", omit=True)
    radius: Positive = quantity(
        "radius of a sphere or of a capsule's cross-section; not for a box, whose size determines its "
        "smallest enclosing sphere",
        "m",
        own=COLUMN,
    )
    length: Positive | None = quantity(
        "length of a capsule along its heading, from tip to tip", "m", omit=True, own=FORM
    )
    size: Annotated[list[Positive], Field(min_length=2, max_length=3)] | None = quantity(
        "length, width and height of a box; if only two numbers are given, the height equals the width",
        "m",
        omit=True,
        own=FORM,
    )
    mass: Positive = quantity("mass", "kg", 1.0, change=FREE, own=COLUMN)
    density: Positive | None = quantity(
        "density, given instead of mass, which is then density × volume",
        "kg/m^3",
        omit=True,
        change=FREE,
        own="it determines the mass; genes can code for body.mass instead",
    )
    opaque: bool = about("whether it blocks the view of bodies behind it", True, change=FREE)
    solid: bool = about("whether it pushes other solid bodies away", False, change=FREE)
    sinking: Real = quantity(
        "speed at which it sinks in a volume; if negative, it rises", "m/s", 0.0, change=FREE, own=True
    )
    compressible: bool = about(
        "whether its internal pressure equals the ambient pressure, which increases with depth; otherwise "
        "properties.pressure is constant and can represent blood pressure",
        False,
        omit=True,
    )

    @property
    def extents(self) -> tuple[float, float, float]:
        """Length along the heading, width and height [m]."""
        if self.size is not None:
            length, width, *height = self.size
            return length, width, height[0] if height else width
        return self.length or 2 * self.radius, 2 * self.radius, 2 * self.radius

    @property
    def bound(self) -> float:
        """Radius of the smallest enclosing sphere [m]."""
        return self.radius if self.length is None else self.length / 2

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        if self.size is not None:
            return math.prod(self.extents)
        r, straight = self.radius, self.extents[0] - 2 * self.radius
        return math.pi * r * r * (straight + 4 / 3 * r)

    @property
    def form(self) -> dict[str, float]:
        """The fields of the component Shape [body radii]."""
        rounding = 0.0 if self.shape == "box" else self.radius
        inner = (max(extent / 2 - rounding, 0.0) / self.radius for extent in self.extents)
        return dict(
            zip(("half_length", "half_width", "half_height"), inner, strict=True),
            rounding=rounding / self.radius,
        )

    @model_validator(mode="before")
    @classmethod
    def _derive(cls, data: object) -> Any:
        """Fill in values that follow from other keys; other checks report invalid values."""
        if not isinstance(data, dict):
            return data
        if data.get("shape") == "box":
            if "radius" in data:
                raise ValueError("a box takes no radius: its size defines it")
            size = data.get("size")
            data = data | {"radius": _around(size) if isinstance(size, list) else 1.0}
        if "density" in data and "mass" in data:
            raise ValueError("give either mass or density: mass is density × volume")
        return data

    @model_validator(mode="after")
    def _fits_shape(self) -> Self:
        for key, shape in (("length", "capsule"), ("size", "box")):
            given = getattr(self, key) is not None
            if given and self.shape != shape:
                raise ValueError(f'{key} requires a {shape}: set shape = "{shape}" or remove {key}')
            if not given and self.shape == shape:
                raise ValueError(f"a {shape} needs a {key} [m]")
        if self.length is not None and self.length < 2 * self.radius:
            raise ValueError(
                f"the tip-to-tip length must be at least twice the radius, {2 * self.radius:g} m"
            )
        if self.density is not None:
            self.__dict__["mass"] = mass = self.density * self.volume
            if not SMALLEST <= mass <= LARGEST:
                raise ValueError(f"density × volume is {mass:g} kg; expected 1e-30 to 1e+30")
        return self

    @model_serializer(mode="wrap")
    def _leave_out(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out values that follow from other keys."""
        data: dict[str, Any] = write(self)
        derived = {"radius": self.shape == "box", "mass": self.density is not None}
        return {key: value for key, value in data.items() if not derived.get(key)}


def _around(size: list[Any]) -> float:
    """Return the radius of the smallest sphere around a box [m]; 1 if its size is invalid."""
    sides = [float(side) for side in size if isinstance(side, int | float) and 0 < side <= 1e30]
    return math.hypot(*[*sides, sides[-1]][:3]) / 2 if len(sides) == len(size) in (2, 3) else 1.0
