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
    Point,
    Positive,
    Real,
    Section,
    Share,
    about,
    is_absent,
    is_empty,
    quantity,
    table,
)

PROPERTIES = {  # physical properties a body may have besides mass, and their units (paper, Definition 1)
    "temperature": "K",
    "pressure": "Pa",
    "electric_current": "A",
    "luminous_intensity": "cd",
}
BODY = ("mass", "radius", "volume")  # of the body itself
Color = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]


class Space(Section):
    """Size and edges of the space."""

    size: Annotated[list[Positive], Field(min_length=2, max_length=3)] = quantity(
        "extent along each axis; two numbers are a plane, three a volume", "m"
    )
    edges: Literal["torus", "walls"] = about(
        "torus: leaving on one side enters on the other; walls: nothing leaves", "torus"
    )
    cell: Positive | None = quantity("side of the cells of the neighbor index; absent: chosen", "m", None)

    @property
    def widest(self) -> float:
        """The largest distance of a search [m]: half of the shorter side of a torus, or the diagonal between
        walls."""
        return min(self.size[:2]) / 2 if self.edges == "torus" else math.hypot(*self.size)

    @property
    def too_wide(self) -> str:
        """The words for a distance beyond `widest`."""
        return "larger than half of the torus" if self.edges == "torus" else "larger than the world"


class Hills(Section):
    """Smooth random ground."""

    seed: Annotated[int, Field(ge=0, lt=2**63)] = about("seed of the hills' shape", 0)
    amplitude: NonNegative = quantity("height of a typical hill above the mean ground", "m")
    scale: Positive = quantity("distance from hill to hill", "m")


class Landmark(Section):
    """A mountain, a rock or a lake: a disc on the ground."""

    at: Annotated[list[Real], Field(min_length=2, max_length=2)] = quantity("centre", "m")
    radius: Positive = quantity("radius of the disc", "m")
    height: NonNegative = quantity("height of the top above the ground around; a lake has none", "m", 0.0)


class Strip(Section):
    """A road: a strip of ground on which walkers are faster or slower, and pay more or less."""

    line: Annotated[list[Annotated[list[Real], Field(min_length=2, max_length=2)]], Field(min_length=2)] = (
        quantity("the corners of its middle line", "m")
    )
    width: Positive = quantity(
        "breadth of the strip; at least the cells of the ground that the line passes", "m", 1.0
    )
    pace: Positive = quantity("factor of the speed of animals on it", "1", 1.0)
    cost: NonNegative = quantity("factor of the cost of moving per second", "1", 1.0)


class Terrain(RealLand):
    """The shape of the ground."""

    submodel = Submodel(
        "Terrain",
        reads=("terrain",),
        rules={
            "terrain.hills": "Hills are a smooth random surface with a seed of its own.",
            "terrain.hides": "Hills hide what is behind them.",
        },
    )

    cell: Positive = quantity(
        "side of the cells of the height map, and of those of a raster that does not state its own", "m", 1.0
    )
    hills: Hills | None = about("smooth random hills", None)
    mountains: list[Landmark] = table("high ground, slow to climb", list)
    rocks: list[Landmark] = table("cannot be entered or seen through", list)
    lakes: list[Landmark] = table("water", list)
    roads: list[Strip] = about(
        "roads that lie there from the start; others are interventions", [], exclude_if=is_empty
    )
    slope_cost: NonNegative = quantity(
        "extra cost of moving, as a factor per unit of slope", "1", 1.0, change=FREE
    )
    hides: bool = about(
        "whether hills hide what is behind them from rays and from `nearest` with occlusion, "
        "whose eyes are at the top of the body; else only rocks do",
        False,
        exclude_if=is_absent,
    )


class Ambient(Section, change=FREE):
    """The state of the environment unless something changes it."""

    temperature: NonNegative = quantity("temperature", "K", 285.0)
    pressure: NonNegative = quantity("pressure at the surface", "Pa", 101_325.0)
    light: NonNegative = quantity("light at the surface, 1 is full daylight", "1", 1.0)


class ScalarField(Section):
    """A quantity with one value at each place: emitted by bodies, diffusing, decaying."""

    cell: Positive = quantity("side of the field's cells", "m")
    diffusion: NonNegative = quantity("diffusion coefficient", "m^2/s", 0.0, change=FREE)
    decay: NonNegative = quantity("share lost per second", "1/s", 0.0, change=FREE)
    substance: str | None = about(
        "the substance whose concentration [mol/L] it is; absent: a smell without amount",
        None,
        exclude_if=is_absent,
    )
    depth: Positive | None = quantity(
        "thickness of the layer in a plane; absent: 1 m", "m", None, exclude_if=is_absent
    )
    initial: Positive | None = quantity(
        "concentration at the start, and that of renewal; absent: 0", "mol/L", None, exclude_if=is_absent
    )
    renewal: Positive | None = quantity(
        "share of the difference from `initial` that air, rain or springs "
        "from outside of the world make up for in a second; absent: none",
        "1/s",
        None,
        exclude_if=is_absent,
        change=FREE,
    )
    only: Literal["lakes", "land"] | None = about(
        "where `initial` holds; elsewhere it is 0; absent: everywhere", None, exclude_if=is_absent
    )


class Store(Section, change=FREE):
    """Energy in objects, for animals that eat them (`diet.efficiency`); remains hold what the dead body held."""

    initial: NonNegative = quantity("energy of each object but remains", "energy", 0.0)
    decay: NonNegative = quantity("share that rots per second", "1/s", 0.0)
    left: Share = quantity(
        "share of a store that rots: the object vanishes when so much would be left of it", "1", 0.01
    )


class Motion(Section, change=FREE):
    """How objects move by themselves: with a velocity, or along a path; give one of them. Water carries them
    in addition, as it carries all bodies."""

    velocity: Annotated[list[Real], Field(min_length=2, max_length=3)] | None = quantity(
        "along each axis; rocks, lakes, fences and walls stop it", "m/s", None
    )
    path: Annotated[list[Point], Field(min_length=2, max_length=1000)] | None = quantity(
        "places that they go to one after the other, around and around, wherever "
        "they begin; nothing stops them",
        "m",
        None,
    )
    speed: Positive | None = quantity("along the path", "m/s", None)


@assembled
class ObjectType(WarmObjects, Chemistry, Decomposing, Emitting):
    """A type of inanimate objects."""

    count: Annotated[int, Field(ge=0, le=50_000_000)] = quantity(
        "how many lie at random places at the start", "1", 0, change=NUMBERS
    )
    at: list[Point] = table("places of single objects at the start [m]", list, change=NUMBERS)
    heading: list[Real] = Field(
        default_factory=list,
        exclude_if=is_empty,
        json_schema_extra={"unit": "rad"},
        description="headings of the objects in at, counter-clockwise from the x "
        "axis: one for each, or one for all; absent: 0 [rad]",
    )
    between: list[Annotated[list[Real], Field(min_length=4, max_length=4)]] = quantity(
        "single objects at the start that reach from one place on the ground to another, [x, y, x, y]: "
        "middle, heading and length follow; capsules or boxes, in a volume on its floor",
        "m",
        default_factory=list,
        exclude_if=is_empty,
        change=NUMBERS,
    )
    color: Color = about("color in figures, #rrggbb", "#888888", change=FREE)
    body: Body = about("shape, size, mass, opacity")
    properties: dict[str, Real] = table(
        f"physical properties by name: {', '.join(PROPERTIES)}", dict, entries=FREE
    )
    substances: dict[Name, NonNegative] = table("concentrations by name [mol/L]", dict, entries=FREE)
    energy: Store | None = about(
        "energy that they hold, as food; absent: none", None, exclude_if=is_absent, change=SHAPE
    )
    renewal: NonNegative = quantity(
        "rate at which each one missing of `count` comes back, at a random place; 0: never",
        "1/s",
        0.0,
        exclude_if=is_empty,
        change=FREE,
    )
    motion: Motion | None = about(
        "how they move by themselves; absent: they do not", None, exclude_if=is_absent, change=SHAPE
    )
    pushed: bool = about(
        "whether solid bodies push them away, as they push each other; else nothing does",
        False,
        exclude_if=is_absent,
        change=FREE,
    )

    def felt(self) -> tuple[str, ...]:
        """Names of properties and substances of these bodies."""
        held = () if self.energy is None else ("energy",)
        return tuple(dict.fromkeys((*held, *self.properties, *self.substances, *BODY)))
