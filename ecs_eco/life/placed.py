"""Positions, headings and lengths of objects that a world file places one by one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.elementary import arrays
from ecs_eco.components import Body, Position, Shape
from ecs_eco.config.models.body import Body as BodyConfig

if TYPE_CHECKING:
    from ecs_eco.config.models.surroundings import ObjectType
    from ecs_eco.space.geometry import Space

Values = dict[tuple[type, str], np.ndarray]


def placed(kind: ObjectType, space: Space) -> Iterator[Values]:
    """Yield the columns of a type's objects at single points, then those of its objects that extend between
    two points."""
    if kind.at:
        place = np.array([[*at, 0.0][:3] for at in kind.at], np.float32)
        values: Values = {(Position, axis): place[:, i] for i, axis in enumerate("xyz")}
        if kind.heading:
            turned = np.resize(np.array(kind.heading) % (2 * np.pi), len(place))
            values[Position, "heading"] = turned.astype(np.float32)
        yield values
    if kind.between:
        yield between(np.array(kind.between, np.float64), kind.body, space)


def between(ways: np.ndarray, body: BodyConfig, space: Space) -> Values:
    """Return the columns of capsules or boxes that reach from one point to another: ways f64[n, 4] [m] are x,
    y of both ends; everything else is as in `body`."""
    ahead, length = ways[:, 2:] - ways[:, :2], arrays.hypot(*(ways[:, 2:] - ways[:, :2]).T)
    middle = ways[:, :2] + ahead / 2
    height = body.extents[2] / 2 if space.volume else 0.0
    bodies = [_as_long(body, float(one)) for one in length]
    values: Values = {
        (Position, "x"): middle[:, 0],
        (Position, "y"): middle[:, 1],
        (Position, "z"): np.full(len(ways), height),
        (Position, "heading"): arrays.arctan2(ahead[:, 1], ahead[:, 0]) % (2 * np.pi),
        (Body, "radius"): np.array([one.radius for one in bodies]),
        (Body, "mass"): np.array([one.mass for one in bodies]),
    }
    values |= {(Shape, field): np.array([one.form[field] for one in bodies]) for field in body.form}
    return {key: value.astype(np.float32) for key, value in values.items()}


def _as_long(body: BodyConfig, length: float) -> BodyConfig:
    """Return the same body with a different length [m]; its mass also changes if it has a density."""
    longer = {"length": length} if body.size is None else {"size": [length, *body.size[1:]]}
    return BodyConfig.model_validate(body.model_dump() | longer)
