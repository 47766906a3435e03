"""Space, terrain, ambient conditions, scalar fields and inanimate objects."""

import math
from typing import Annotated, Literal

from pydantic import Field

from ecs_eco.config.features.chemistry import Chemistry, Decomposing, Emitting
from ecs_eco.config.features.feature import assembled
from ecs_eco.config.features.heat import WarmObjects
from ecs_eco.config.models.body import Body
from ecs_eco.config.models.land import RealLand
from ecs_eco.engine.submodel import Submodel
from ecs_eco.inputs.section import (
    FREE,
    NUMBERS,
    SHAPE,
    Name,
    NonNegative,
    Pair,
    Point,
    Positive,
    Real,
    Section,
    Share,
    about,
    quantity,
    table,
)

PROPERTIES = {  # physical properties that a body may have besides mass, and their units (paper, Definition 1)
    "temperature": "K",
    "pressure": "Pa",
    "electric_current": "A",
    "luminous_intensity": "cd",
}
PROPERTY_UNITS = ", ".join(f"{name} in {unit}" for name, unit in PROPERTIES.items())
BODY = ("mass", "radius", "volume")  # properties of the body itself
Color = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]


class Space(Section):
    """Size and edges of the space."""

    size: Annotated[list[Positive], Field(min_length=2, max_length=3)] = quantity(
        "extent along each axis; two numbers define a plane, three a volume", "m"
    )
    edges: Literal["torus", "walls"] = about(
        "torus: organisms that leave on one side enter on the other; walls: nothing leaves", "torus"
    )
    cell: Positive | None = quantity(
        "side of the cells of the neighbor index; default: chosen automatically", "m", None
    )

    @property
    def widest(self) -> float:
        """The maximum search distance [m]: half the width of a torus, or the diagonal of a walled world."""
        return min(self.size[:2]) / 2 if self.edges == "torus" else math.hypot(*self.size)

    @property
    def too_wide(self) -> str:
        """The message for a distance above `widest`."""
        return "larger than half the width of the torus" if self.edges == "torus" else "larger than the world"


class Hills(Section):
    """Smooth random ground."""

    seed: Annotated[int, Field(ge=0, lt=2**63)] = about("seed of the hills' shape", 0)
    amplitude: NonNegative = quantity("height of a typical hill above the mean ground", "m")
    scale: Positive = quantity("distance between hills", "m")


class Landmark(Section):
    """A mountain, a rock or a lake: a disc on the ground."""

    at: Pair = quantity("center", "m")
    radius: Positive = quantity("radius of the disc", "m")
    height: NonNegative = quantity("height of the top above the surrounding ground; not for a lake", "m", 0.0)


class Strip(Section):
    """A road: a strip of ground that changes the speed of walkers and their cost of moving."""

    line: Annotated[list[Pair], Field(min_length=2)] = quantity("the vertices of its center line", "m")
    width: Positive = quantity(
        "width of the strip; it covers at least the ground cells on the line", "m", 1.0
    )
    pace: Positive = quantity("factor for the speed of animals on it", "1", 1.0)
    cost: NonNegative = quantity("factor for the cost of moving per second", "1", 1.0)


class Terrain(RealLand):
    """The shape of the ground."""

    submodel = Submodel(
        "Terrain",
        reads=("terrain",),
        rules={
            "terrain.hills": "Hills are a smooth random surface with its own seed.",
            "terrain.hides": "Hills block the view of bodies behind them.",
        },
    )

    cell: Positive = quantity(
        "side of the cells of the height map, and of a raster that does not state its cell size", "m", 1.0
    )
    hills: Hills | None = about("smooth random hills", None)
    mountains: list[Landmark] = table("high ground, slow to climb", list)
    rocks: list[Landmark] = table("obstacles that cannot be entered or seen through", list)
    lakes: list[Landmark] = table("water", list)
    roads: list[Strip] = about(
        "roads that exist from the start; later roads are interventions", [], omit=True
    )
    slope_cost: NonNegative = quantity(
        "extra cost of moving uphill: the cost is multiplied by 1 + slope_cost × slope", "1", 1.0, change=FREE
    )
    hides: bool = about(
        "whether hills block the view of sensors `rays`, and `nearest` with occlusion, seen from the top of the "
        "body; otherwise only rocks and opaque bodies do",
        False,
        omit=True,
    )


class Ambient(Section, change=FREE):
    """The state of the environment, constant unless a process changes it."""

    temperature: NonNegative = quantity("temperature", "K", 285.0)
    pressure: NonNegative = quantity("pressure at the surface", "Pa", 101_325.0)
    light: NonNegative = quantity("light at the surface; 1 is full daylight", "1", 1.0)


class ScalarField(Section):
    """A quantity with a value at each position, which bodies emit and which diffuses and decays."""

    cell: Positive = quantity("side of the field's cells", "m")
    diffusion: NonNegative = quantity("diffusion coefficient", "m^2/s", 0.0, change=FREE)
    decay: NonNegative = quantity("proportion lost per second", "1/s", 0.0, change=FREE)
    substance: str | None = about(
        "the substance whose concentration [mol/L] it represents; default: a smell without matter", omit=True
    )
    depth: Positive | None = quantity("thickness of the layer in a plane; default: 1 m", "m", omit=True)
    initial: Positive | None = quantity(
        "concentration at the start, and target of renewal; default: 0", "mol/L", omit=True
    )
    renewal: Positive | None = quantity(
        "proportion of the difference from `initial` that is restored per second by air, rain or springs "
        "from outside the world; default: none",
        "1/s",
        omit=True,
        change=FREE,
    )
    only: Literal["lakes", "land"] | None = about(
        "region where `initial` applies; elsewhere it is 0; default: everywhere", omit=True
    )


class Store(Section, change=FREE):
    """Energy in objects, for animals that eat them (`diet.efficiency`); remains contain the energy of the
    dead body."""

    initial: NonNegative = quantity("energy of each object except remains", "energy", 0.0)
    decay: NonNegative = quantity("proportion that decays per second", "1/s", 0.0)
    left: Share = quantity("remaining fraction of a decaying store at which the object disappears", "1", 0.01)


class Motion(Section, change=FREE):
    """Independent movement of objects, either with a velocity or along a path. In addition, water carries
    them along, like all bodies."""

    velocity: Annotated[list[Real], Field(min_length=2, max_length=3)] | None = quantity(
        "velocity along each axis; rocks, lakes, fences and walls stop it", "m/s", None
    )
    path: Annotated[list[Point], Field(min_length=2, max_length=1000)] | None = quantity(
        "positions that they visit in order, in a closed loop, from any starting point; nothing stops them",
        "m",
        None,
    )
    speed: Positive | None = quantity("speed along the path", "m/s", None)


@assembled
class ObjectType(WarmObjects, Chemistry, Decomposing, Emitting):
    """A type of inanimate object."""

    count: Annotated[int, Field(ge=0, le=50_000_000)] = quantity(
        "initial number of objects at random positions", "1", 0, change=NUMBERS
    )
    at: list[Point] = table("initial positions of individual objects [m]", list, change=NUMBERS)
    heading: list[Real] = quantity(
        "headings of the objects in `at`, counterclockwise from the x axis: one per object, or one for all; "
        "default: 0",
        "rad",
        default_factory=list,
        omit=True,
    )
    between: list[Annotated[list[Real], Field(min_length=4, max_length=4)]] = quantity(
        "initial capsules or boxes, on the ground or on the floor of a volume; each is given by the positions "
        "of its two ends, [x, y, x, y], which determine its center, heading and length",
        "m",
        default_factory=list,
        omit=True,
        change=NUMBERS,
    )
    color: Color = about("color in figures, #rrggbb", "#888888", change=FREE)
    body: Body = about("shape, size, mass, opacity")
    properties: dict[str, Real] = table(f"physical properties by name: {PROPERTY_UNITS}", dict, entries=FREE)
    substances: dict[Name, NonNegative] = table("concentrations by name [mol/L]", dict, entries=FREE)
    energy: Store | None = about("energy that they contain as food; absent: none", omit=True, change=SHAPE)
    renewal: NonNegative = quantity(
        "rate at which each object missing from `count` is replaced, at a random position; 0: never",
        "1/s",
        0.0,
        omit=True,
        change=FREE,
    )
    motion: Motion | None = about("independent movement; absent: they do not move", omit=True, change=SHAPE)
    pushed: bool = about(
        "whether solid bodies push them, as they push each other; otherwise nothing pushes them",
        False,
        omit=True,
        change=FREE,
    )

    def felt(self) -> tuple[str, ...]:
        """Return the names of properties and substances of these bodies."""
        held = () if self.energy is None else ("energy",)
        return tuple(dict.fromkeys((*held, *self.properties, *self.substances, *BODY)))
