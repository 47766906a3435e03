"""Sensors: each has a position on the body and responds to one quantity.

A sensor provides one or more channels, numbers that the networks read. A sensor without a name is named after
the quantity or target that it senses (`energy`, `deer`, `touch_wall`); sensors that would share a name are
numbered in list order (`deer_smell_1`, `deer_smell_2`). Formulas, weights and reflexes use channel names; the
plain name of a smell is the mean over all noses that sense it.
"""

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from ecs_eco.config.numbers import numbered
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
    quantity,
)

Angle = Annotated[float, Field(ge=-math.pi, le=math.pi)]
ON_BODY = (
    "position on the body: forward, left (, up), in body radii; for a capsule or box, in half-lengths, "
    "half-widths and half-heights"
)
WIDEST = 2.0 * math.pi + 1e-6


def _on_body(text: str) -> Any:
    """Declare a position on the body, with 2 or 3 axes; files omit it if it is the center."""
    return quantity(text, "1", [0.0, 0.0], exclude_if=lambda at: not any(at), own=COLUMN)


Kin = Literal["mother", "father", "offspring", "siblings"]


class Sensor(Section):
    """Keys shared by all sensors."""

    name: Name | None = about("name of the channel, or prefix of the channels' names", None)

    called: ClassVar[str] = "{0.kind}"

    def base(self) -> str:
        """Return the default name, before numbering."""
        return self.called.format(self).replace(".", "_")

    def channels(self, dims: int) -> tuple[str, ...]:
        """Return the names of the sensor's channels in a space with `dims` axes."""
        return (self.name or self.base(),)


class Own(Sensor):
    """Reads value/scale, where the value is a property or substance of its own body."""

    kind: Literal["own"]
    property: str = about(
        "energy, age, fertility, sex (0 none, 1 female, 2 male), mass, radius, volume, a property or "
        "substance of the species, or Component.field of a custom component"
    )
    scale: Positive = quantity("value at which the sensor reads 1", "unit of the property", 1.0, own=True)
    at: Point = _on_body(
        f"{ON_BODY}; it matters only for the pressure in a compressible body, which depends on depth"
    )

    called = "{0.property}"


class Nearest(Sensor, own=True):
    """Sees the nearest target; channels: name_forward, name_left (cosine, sine of its bearing), name_near.

    name_near is 1 − distance/range; all channels are 0 if no target is within range. In a volume, the direction
    also has name_up. The distance is from `at` to the center of a sphere, or to the nearest point of a box or of
    a capsule's axis.
    """

    kind: Literal["nearest"]
    target: str = about("a species or an object type")
    range: Positive = quantity("maximum viewing distance", "m", own=COLUMN, former="radius")
    fov: Annotated[float, Field(gt=0, le=WIDEST)] = quantity(
        "field of view around the heading", "rad", 2 * math.pi
    )
    occlusion: bool = about("whether opaque bodies in between hide the target", False)
    sight: NonNegative | None = quantity(
        "if given, it sees as far as blind + sight × light at the eye, at most range", "m", None
    )
    blind: NonNegative = quantity(
        "distance at which it detects the target in the dark, if sight is given", "m", 0.0
    )
    kin: Kin | None = about(
        "sees only these relatives, in its own species or its eggs; default: all", omit=True
    )

    at: Point = _on_body(
        f"{ON_BODY}; direction and distance are measured from there, relative to the body's heading"
    )

    def base(self) -> str:
        return self.target if self.kin is None else f"{self.target}_{self.kin}"

    def channels(self, dims: int) -> tuple[str, ...]:
        name = self.name or self.base()
        return tuple([f"{name}_{way}" for way in _ways(dims)])


class Rays(Sensor):
    """Casts rays, which end at the first target, opaque body, rock or wall; closeness is 1 − distance/range.
    With per_ray, the channels are name_target_1 … (closeness along each ray); with closest, they are
    name_target_forward, _left (cosine, sine of the ray's bearing) and _near (its closeness)."""

    kind: Literal["rays"]
    count: Annotated[int, Field(ge=1, le=360)] = quantity("number of rays", "1", own=WIDTH)
    fov: Annotated[float, Field(gt=0, le=WIDEST)] = quantity(
        "angle between the outermost rays", "rad", math.pi, own=True
    )
    range: Positive = quantity("length of a ray", "m", own=COLUMN, former="radius")
    targets: Annotated[list[str], Field(min_length=1)] = about(
        'targets that a ray can report: species, object types or "wall"'
    )
    report: Literal["per_ray", "closest"] = about(
        "the closeness along each ray, or the position of the closest hit", "closest"
    )
    at: Point = _on_body(f"{ON_BODY}; rays begin there")
    angle: Angle = quantity(
        "direction of the middle ray; 0 is straight ahead, left is positive", "rad", 0.0, omit=True, own=True
    )
    sight: NonNegative | None = quantity(
        "if given, it sees as far as blind + sight × light at the eye, at most range",
        "m",
        omit=True,
        own=True,
    )
    blind: NonNegative = quantity(
        "maximum viewing distance in the dark, if sight is given", "m", 0.0, omit=True, own=True
    )

    def channels(self, dims: int) -> tuple[str, ...]:
        ways = _ways(dims) if self.report == "closest" else tuple(str(i + 1) for i in range(self.count))
        return tuple(f"{self.name or self.base()}_{target}_{way}" for target in self.targets for way in ways)


class Property(Sensor, own=COLUMN):
    """Senses a property of the surrounding bodies: the sum of weight × (value − zero)/scale over all bodies
    whose centers are nearer than `range`, or their mean.

    The weight of a body at distance d [m] is 1 with decay = "none", 1 − d/range with "linear" and 1/d² [1/m²]
    with "inverse_square", where d is at least that body's own radius: luminous intensity [cd] becomes
    illuminance [lx]. The mean is this sum divided by the sum of the weights. The sensor reads 0 if there are
    no bodies; the organism's own body does not count.
    """

    kind: Literal["property"]
    property: str = about(
        "energy, age, fertility, sex (0 none, 1 female, 2 male), mass, radius, volume, a property or "
        "substance of the bodies, or Component.field of a custom component"
    )
    of: (
        Annotated[
            Annotated[str, Tag("word")] | Annotated[list[str], Field(min_length=1), Tag("names")],
            Discriminator(lambda value: "names" if isinstance(value, list) else "word"),
        ]
        | None
    ) = about("a species or an object type, or a list of them; default: all that have the property", None)
    range: Positive = quantity("maximum distance to the center of a body", "m", former="radius")
    at: Point = quantity(ON_BODY, "1", [0.0, 0.0])
    decay: Literal["none", "linear", "inverse_square"] = about(
        "how the weight of a body decreases with distance", "none"
    )
    report: Literal["sum", "mean"] = about("the sum over the bodies, or their weighted mean", "sum")
    zero: Real = quantity("value at which a body contributes 0", "unit of the property", 0.0, own=True)
    scale: Positive = quantity(
        "sum or mean at which the sensor reads 1",
        "unit of the property, over m² for a sum with inverse_square",
        1.0,
        own=True,
    )

    kin: Kin | None = about("count only these relatives, in the named species; default: all", omit=True)

    def base(self) -> str:
        kin = [self.kin] if self.kin else []
        return "_".join([*(self.kinds() or ["any"]), *kin, self.property.replace(".", "_")])

    def kinds(self) -> list[str]:
        """The species and object types that the sensor detects; empty means all that have the property."""
        return [self.of] if isinstance(self.of, str) else list(self.of or [])


class Smell(Sensor):
    """A nose: reads c/(c + half_saturation), where c is a scalar field at one position on the body."""

    kind: Literal["smell"]
    field: str = about("name of a field")
    at: Point = quantity(ON_BODY, "1", [0.0, 0.0], own=COLUMN)
    half_saturation: Positive = quantity(
        "value of the field at which the sensor reads 1/2", "unit of the field", 1.0, own=True, former="scale"
    )

    called = "{0.field}"


class Gradient(Sensor, own=True):
    """Compares a smell on two sides of the body: (a − b)/(a + b + scale), ahead and behind, left and right,
    above and below.

    Channels are name_forward, name_left and, in a volume, name_up.
    """

    kind: Literal["gradient"]
    field: str = about("name of a field")
    span: Positive = quantity("distance between the two receptors of a pair", "m", 1.0)
    scale: Positive = quantity(
        "concentration below which the sensor hardly indicates a direction", "unit of the field", 0.01
    )

    called = "{0.field}_gradient"

    def channels(self, dims: int) -> tuple[str, ...]:
        name = self.name or self.base()
        return tuple([f"{name}_{way}" for way in _ways(dims)[:-1]])


class Approach(Sensor):
    """Senses the flow that a moving body pushes ahead of itself: the direction to the nearest body, and the
    speed at which its own motion brings it closer.

    Channels are name_forward, name_left, in a volume name_up (a unit vector), and name_closing, this speed
    divided by `scale`; all are 0 unless the nearest body approaches.
    """

    kind: Literal["approach"]
    target: str = about("a species")
    range: Positive = quantity("maximum distance", "m", own=COLUMN, former="radius")
    scale: Positive = quantity("approach speed at which the sensor reads 1", "m/s", 1.0, own=True)

    called = "{0.target}_approach"

    def channels(self, dims: int) -> tuple[str, ...]:
        return tuple(f"{self.name or self.base()}_{way}" for way in (*_ways(dims)[:-1], "closing"))


class Alignment(Sensor):
    """Senses the mean heading of the members of a species whose centers are nearer than `range`, relative to its
    own heading.

    Channels are name_forward and name_left, the means of the cosine and sine of the difference in heading. Both
    are 0 if there are no neighbors; if all neighbors have the same heading, the two form a unit vector.
    """

    kind: Literal["alignment"]
    target: str = about("a species")
    range: Positive = quantity("maximum distance to the center of a body", "m", own=COLUMN)

    called = "{0.target}_alignment"

    def channels(self, dims: int) -> tuple[str, ...]:
        return tuple(f"{self.name or self.base()}_{way}" for way in _ways(2)[:-1])


class Touch(Sensor, own=COLUMN):
    """Reads 1 while a target touches the body within a sector, otherwise 0."""

    kind: Literal["touch"]
    target: str = about('a species, an object type, "wall" or "any"', "any")
    at: Annotated[list[Angle], Field(min_length=2, max_length=2)] = quantity(
        "sector of the body, counterclockwise from start to end; 0 is straight ahead, and left is positive",
        "rad",
        [-math.pi, math.pi],
    )

    called = "touch_{0.target}"


class Place(Sensor):
    """Keys shared by sensors of ambient conditions."""

    at: Point = quantity(ON_BODY, "1", [0.0, 0.0], own=COLUMN)
    zero: Real = quantity("value at which the sensor reads 0", "unit of the quantity", 0.0)
    scale: Positive = quantity(
        "difference from `zero` at which the sensor reads 1", "unit of the quantity", 1.0
    )


class Light(Place, own=True):
    """Reads (value − zero)/scale, where the value is the light at one position on the body, 1 in full daylight,
    or with `dark` its logarithm (Fechner 1860)."""

    kind: Literal["light"]
    dark: Positive | None = quantity(
        "light level that counts as dark; if given, the value is log10(1 + light/dark)", "1", None
    )


class Temperature(Place, own=True):
    """Reads the temperature of the surroundings [K]."""

    kind: Literal["temperature"]


class Pressure(Place, own=True):
    """Reads the pressure of the surroundings [Pa], which indicates the depth."""

    kind: Literal["pressure"]


class Custom(Sensor, own=WIDTH):
    """A custom function(world, table, seekers, out, first): it writes `width` columns of `out`
    (f32[n, channels]) from column `first` on, for the n organisms with rows `seekers.rows`."""

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
    | Alignment
    | Touch
    | Light
    | Temperature
    | Pressure
    | Custom,
    Field(discriminator="kind"),
]


def name_sensors(sensors: list[Sensor]) -> list[Sensor]:
    """Return the same sensors, all with names; sensors that would share a name are numbered from 1."""
    names = iter(numbered([s.base() for s in sensors if s.name is None]))
    return [s.model_copy(update={"name": next(names)}) if s.name is None else s for s in sensors]


def _ways(dims: int) -> tuple[str, ...]:
    return ("forward", "left", "near") if dims == 2 else ("forward", "left", "up", "near")
