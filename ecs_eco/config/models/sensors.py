"""Sensors: each has a place on the body and one thing that it is sensitive to.

A sensor gives one or more channels, numbers that the networks read. A sensor without a name is named after
what it senses (`energy`, `deer`, `touch_wall`); sensors that would share a name are numbered in the order of
the list (`deer_smell_1`, `deer_smell_2`). Formulas, weights and reflexes use the channels' names; the plain
name of a smell is the mean over all noses for it.
"""

import math
from collections import Counter
from typing import Annotated, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from ecs_eco.inputs.section import (
    COLUMN,
    WIDTH,
    Name,
    NonNegative,
    Point,
    Positive,
    Real,
    Section,
    WithParameters,
    about,
    function_name,
    is_absent,
    quantity,
)

Angle = Annotated[float, Field(ge=-math.pi, le=math.pi)]
ON_BODY = (
    "place on the body: forward, left (, up), in radii of the body; of a capsule or box in halves of "
    "its length, width and height"
)
WIDEST = 2.0 * math.pi + 1e-6


def _is_zero(value: float | list[float]) -> bool:
    """Whether rays begin at the centre or look ahead, as all did once: what is written leaves it out then,
    so that worlds keep the hashes that they had."""
    return not any(value if isinstance(value, list) else [value])


Kin = Literal["mother", "father", "offspring", "siblings"]


class Sensor(Section):
    """Keys of all sensors."""

    name: Name | None = about("name of the channel, or prefix of the channels' names", None)

    called: ClassVar[str] = "{0.kind}"

    def base(self) -> str:
        """The default name, before numbering."""
        return self.called.format(self).replace(".", "_")

    def channels(self, dims: int) -> tuple[str, ...]:
        """Names of its channels, in a space of `dims` axes."""
        return (self.name or self.base(),)


class Own(Sensor):
    """Feels one property or substance of the own body."""

    kind: Literal["own"]
    property: str = about(
        "energy, age, fertility, sex (0 none, 1 female, 2 male), mass, radius, volume, "
        "a property or substance that the species has, or Component.field of a component "
        "of your own"
    )
    scale: Positive = quantity("the value that reads 1", "unit of the property", 1.0, own=True)
    at: Point = quantity(
        f"{ON_BODY}; a body is the same throughout, but for the pressure in a compressible "
        "one, which is that of the depth",
        "1",
        [0.0, 0.0],
        exclude_if=_is_zero,
        own=COLUMN,
    )

    called = "{0.property}"


class Nearest(Sensor, own=True):
    """Sees the nearest of one kind: name_forward and name_left (cosine and sine of its bearing), name_near.

    The last is 1 where it touches and falls to 0 at its range; all are 0 where there is none. It is the
    centre of a sphere that is seen, of a capsule or box the nearest place of its axis or of the box.
    """

    kind: Literal["nearest"]
    target: str = about("a species or an object type")
    range: Positive = quantity("how far it sees", "m", own=COLUMN, former="radius")
    fov: Annotated[float, Field(gt=0, le=WIDEST)] = quantity(
        "field of view around the heading", "rad", 2 * math.pi
    )
    occlusion: bool = about("whether opaque bodies between hide the target", False)
    sight: NonNegative | None = quantity(
        "if given, it sees by light: as far as blind + sight × light at its eye, at most range", "m", None
    )
    blind: NonNegative = quantity("how far it notices the target in the dark, if sight is given", "m", 0.0)
    kin: Kin | None = about(
        "only relatives count, those of the own species or its eggs; absent: all", None, exclude_if=is_absent
    )

    at: Point = quantity(
        f"{ON_BODY}; direction and distance are those from there, the heading is the body's",
        "1",
        [0.0, 0.0],
        exclude_if=_is_zero,
        own=COLUMN,
    )

    def base(self) -> str:
        return self.target if self.kin is None else f"{self.target}_{self.kin}"

    def channels(self, dims: int) -> tuple[str, ...]:
        name = self.name or self.base()
        return tuple([f"{name}_{way}" for way in _ways(dims)])


class Rays(Sensor):
    """Casts rays; per_ray: name_target_1 … (closeness along each ray); closest: name_target_forward,
    _left, _near."""

    kind: Literal["rays"]
    count: Annotated[int, Field(ge=1, le=360)] = quantity("number of rays", "1", own=WIDTH)
    fov: Annotated[float, Field(gt=0, le=WIDEST)] = quantity(
        "angle between the outermost rays", "rad", math.pi, own=True
    )
    range: Positive = quantity("length of a ray", "m", own=COLUMN, former="radius")
    targets: Annotated[list[str], Field(min_length=1)] = about(
        'species, object types or "wall" that a ray can report'
    )
    report: Literal["per_ray", "closest"] = about(
        "each ray's closeness, or where the closest hit is", "closest"
    )
    at: Point = quantity(f"{ON_BODY}; they begin there", "1", [0.0, 0.0], exclude_if=_is_zero, own=COLUMN)
    angle: Angle = quantity(
        "direction of the middle ray; 0 is ahead and left is positive",
        "rad",
        0.0,
        exclude_if=_is_zero,
        own=True,
    )
    sight: NonNegative | None = quantity(
        "if given, it sees by light: as far as blind + sight × light at its eye, at most range",
        "m",
        None,
        exclude_if=is_absent,
        own=True,
    )
    blind: NonNegative = quantity(
        "how far it sees in the dark, if sight is given", "m", 0.0, exclude_if=_is_zero, own=True
    )

    def channels(self, dims: int) -> tuple[str, ...]:
        ways = _ways(dims) if self.report == "closest" else tuple(str(i + 1) for i in range(self.count))
        return tuple(f"{self.name or self.base()}_{target}_{way}" for target in self.targets for way in ways)


class Property(Sensor, own=COLUMN):
    """Feels a property of the bodies around: the sum of weight × (value − zero)/scale over all whose centres
    are nearer than the range, or their mean.

    The weight of a body at distance d [m] is 1 with decay = "none", 1 − d/range with "linear" and 1/d²
    [1/m²] with "inverse_square", where d is at least that body's own radius: luminous intensity [cd] becomes
    illuminance [lx]. The mean is the same sum divided by that of the weights. It reads 0 where there is
    nobody; the own body does not count.
    """

    kind: Literal["property"]
    property: str = about(
        "energy, age, fertility, sex (0 none, 1 female, 2 male), mass, radius, volume, "
        "a property or substance that the bodies have, or Component.field of a "
        "component of your own"
    )
    of: (
        Annotated[
            Annotated[str, Tag("word")] | Annotated[list[str], Field(min_length=1), Tag("names")],
            Discriminator(lambda value: "names" if isinstance(value, list) else "word"),
        ]
        | None
    ) = about("a species or an object type, or a list of them; absent: all that have the property", None)
    range: Positive = quantity("how far it reaches, to the centre of a body", "m", former="radius")
    at: Point = quantity(ON_BODY, "1", [0.0, 0.0])
    decay: Literal["none", "linear", "inverse_square"] = about(
        "how the weight of a body falls with its distance", "none"
    )
    report: Literal["sum", "mean"] = about("the sum over the bodies, or their weighted mean", "sum")
    zero: Real = quantity("the value of a body that adds nothing", "unit of the property", 0.0, own=True)
    scale: Positive = quantity(
        "the sum or the mean that reads 1",
        "unit of the property, over m² for a sum with inverse_square",
        1.0,
        own=True,
    )

    kin: Kin | None = about(
        "only relatives count, of kinds that are named; absent: all", None, exclude_if=is_absent
    )

    def base(self) -> str:
        kin = [self.kin] if self.kin else []
        return "_".join([*(self.kinds() or ["any"]), *kin, self.property.replace(".", "_")])

    def kinds(self) -> list[str]:
        """The species and object types that are named; none: all that have the property."""
        return [self.of] if isinstance(self.of, str) else list(self.of or [])


class Smell(Sensor):
    """A nose: reads c/(c + half_saturation) of a scalar field c at one place of the body."""

    kind: Literal["smell"]
    field: str = about("name of a field")
    at: Point = quantity(ON_BODY, "1", [0.0, 0.0], own=COLUMN)
    half_saturation: Positive = quantity(
        "the value of the field that reads 1/2", "unit of the field", 1.0, own=True, former="scale"
    )

    called = "{0.field}"


class Gradient(Sensor, own=True):
    """Compares a smell on two sides of the body: (a − b)/(a + b + scale) ahead and behind,
    left and right, above and below.

    Channels name_forward, name_left and, in a volume, name_up.
    """

    kind: Literal["gradient"]
    field: str = about("name of a field")
    span: Positive = quantity("distance between the two receptors of a pair", "m", 1.0)
    scale: Positive = quantity("concentration below which it shows no direction", "unit of the field", 0.01)

    called = "{0.field}_gradient"

    def channels(self, dims: int) -> tuple[str, ...]:
        name = self.name or self.base()
        return tuple([f"{name}_{way}" for way in _ways(dims)[:-1]])


class Approach(Sensor):
    """Feels the flow that a moving body pushes ahead of itself: direction to the nearest, and how fast it
    approaches by its own motion.

    Channels name_forward, name_left, in a volume name_up (a unit vector), and name_closing, the speed over
    `scale`; all are 0 unless the nearest approaches.
    """

    kind: Literal["approach"]
    target: str = about("a species")
    range: Positive = quantity("how far it feels", "m", own=COLUMN, former="radius")
    scale: Positive = quantity("speed of approach that reads 1", "m/s", 1.0, own=True)

    called = "{0.target}_approach"

    def channels(self, dims: int) -> tuple[str, ...]:
        return tuple(f"{self.name or self.base()}_{way}" for way in (*_ways(dims)[:-1], "closing"))


class Touch(Sensor, own=COLUMN):
    """Reads 1 while something of the kind touches the body within a sector, else 0."""

    kind: Literal["touch"]
    target: str = about('a species, an object type, "wall" or "any"', "any")
    at: Annotated[list[Angle], Field(min_length=2, max_length=2)] = quantity(
        "sector of the body, counter-clockwise from and to; 0 is ahead and left is positive",
        "rad",
        [-math.pi, math.pi],
    )

    called = "touch_{0.target}"


class Place(Sensor):
    """Keys of sensors of the ambient conditions."""

    at: Point = quantity(ON_BODY, "1", [0.0, 0.0], own=COLUMN)
    zero: Real = quantity("the value that reads 0", "unit of the quantity", 0.0)
    scale: Positive = quantity("the difference from it that reads 1", "unit of the quantity", 1.0)


class Light(Place, own=True):
    """Reads the light at one place of the body, 1 is full daylight; with `dark`,
    its logarithm (Fechner 1860)."""

    kind: Literal["light"]
    dark: Positive | None = quantity(
        "light that counts as dark; if given, the reading is log10(1 + light/dark)", "1", None
    )


class Temperature(Place, own=True):
    """Reads the temperature of the surroundings [K]."""

    kind: Literal["temperature"]


class Pressure(Place, own=True):
    """Reads the pressure of the surroundings [Pa], which tells the depth."""

    kind: Literal["pressure"]


class Custom(Sensor, own=WIDTH):
    """A function of your own: function(world, table, seekers, out f32[n, channels],
    first) writes `width` channels."""

    kind: Literal["custom"]
    function: WithParameters = about("module:name of the function")
    width: Annotated[int, Field(ge=1, le=1024)] = quantity("number of channels", "1", 1)

    def base(self) -> str:
        return function_name(self.function).partition(":")[2]

    def channels(self, dims: int) -> tuple[str, ...]:
        name = self.name or self.base()
        return (name,) if self.width == 1 else tuple(f"{name}_{i + 1}" for i in range(self.width))


AnySensor = Annotated[
    Own
    | Nearest
    | Rays
    | Property
    | Smell
    | Gradient
    | Approach
    | Touch
    | Light
    | Temperature
    | Pressure
    | Custom,
    Field(discriminator="kind"),
]


def name_sensors(sensors: list[Sensor]) -> list[Sensor]:
    """The same sensors, all with names; those that would share one are numbered from 1."""
    shared = Counter(s.base() for s in sensors if s.name is None)
    used: Counter[str] = Counter()
    named = []
    for sensor in sensors:
        if sensor.name is None:
            base = sensor.base()
            used[base] += 1
            number = f"_{used[base]}" if shared[base] > 1 else ""
            sensor = sensor.model_copy(update={"name": base + number})
        named.append(sensor)
    return named


def _ways(dims: int) -> tuple[str, ...]:
    return ("forward", "left", "near") if dims == 2 else ("forward", "left", "up", "near")
