"""The part of a viewer source that is common to live worlds and recorded runs."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.analysis.palette import SAFE
from ecs_eco.config import WorldConfig
from ecs_eco.ecosystem import World
from ecs_eco.view import listing
from ecs_eco.view.families import Families, asked, tree
from ecs_eco.view.frames import Encoder, extent, grade
from ecs_eco.view.genealogy import Genealogy
from ecs_eco.view.past import Past
from ecs_eco.view.scene import growth_of, map_of, shown_genes, sky
from ecs_eco.view.sentence import sentence
from ecs_eco.view.source import Message, Source, said
from ecs_eco.view.story import Story

TICKS = 5  # ticks for which a death is marked
MOST = 100  # maximum number of deaths in a message; the latest are kept
NARROWER = 0.02  # fraction per frame by which the range of a color contracts toward the current values
Genes = dict[str, dict[str, Any]]
"""The genes of each species that have colors, by name, as codes of `ecs_eco.genomes`."""


class Crowd(NamedTuple):
    """The members of a species or the objects of a type at the displayed tick. `value(name)` returns the
    "energy", "happiness", "age", "born" or "gene:NAME" of each member, f32[n], NaN if unknown, or None if the
    kind has no such value. `full` is the maximum energy of a member."""

    uid: np.ndarray  # u64[n]
    x: np.ndarray  # f32[n] [m], like y and z
    y: np.ndarray
    z: np.ndarray
    heading: np.ndarray  # f32[n] [rad]
    value: Callable[[str], np.ndarray | None] = lambda what: None
    full: float | None = None
    alive: np.ndarray | None = None  # bool[n]: rows in use; None: all

    @property
    def rows(self) -> np.ndarray:
        """The rows in use: i64[k]."""
        return np.arange(self.uid.size) if self.alive is None else np.flatnonzero(self.alive)


class Watched(Source):
    """A world as seen by pages.

    `species` are the displayed species, `animals` the numbers of moving species, `objects` the object types,
    `genes` the genes that have colors, `eats` what each species eats, `foods` the part that does no harm. `answers`
    maps requests that differ between live worlds and recorded runs to methods; `refusal` is the text for others.
    Both kinds also have `earliest`, the earliest tick to which they can go back, and `config`, or None.
    """

    mode = refusal = ""
    ahead = 0  # tick of the clock minus the tick whose end is shown
    answers: dict[str, Callable[[Message], list[Message]]]
    species: list[str]
    animals: list[int]
    objects: list[str]
    genes: Genes
    foods: dict[str, list[str]]
    eats: dict[str, list[str]]
    genealogy: Genealogy
    story: Story | Past

    def __init__(self, size: Sequence[float]) -> None:
        self.size, self.families = size, Families(self.genealogy.lives)
        self.ranges: dict[tuple[str, str], tuple[float, float]] = {}
        self._encoder = Encoder(size, len(self.species) + len(self.objects))
        self.frame(0, "happiness")  # compiles kernels before the first page connects
        self.ranges.clear()

    # --- implemented by live worlds and recorded runs, together with methods of `Source` ---------------------

    @property
    def scene(self) -> World | None:
        """A world at this tick with the displayed light and fields, or None if there is none."""
        raise NotImplementedError

    @property
    def config(self) -> WorldConfig | None:
        return None if self.scene is None else self.scene.config

    def crowd(self, name: str) -> Crowd:
        """Return the members of a species or the objects of a type."""
        raise NotImplementedError

    def state(self, uid: int) -> Message:
        """Return everything known about an organism: the message "organism" without its sentence."""
        raise NotImplementedError

    def marks(self) -> Message:
        """Return the message "marks": marks along the timeline, and the land."""
        raise NotImplementedError

    # --- built on these methods -----------------------------------------------------------------------------

    def hello(self) -> Message:
        genes = dict.fromkeys(f"gene:{gene}" for names in self.genes.values() for gene in names)
        return {
            "kind": "hello",
            "mode": self.mode,
            "foods": self.foods,
            "eats": self.eats,
            "colours": ["species", "energy", "happiness", "age", "family", *genes],
            "palette": SAFE,
        }

    def sky(self) -> tuple[float, float]:
        """Return the light at the surface (0 to 1) and the sun's elevation [rad]."""
        return (1.0, math.pi / 2) if self.scene is None else sky(self.scene)

    def field(self, name: str) -> Message:
        assert self.scene is not None
        return map_of(self.scene, name)

    def frame(self, number: int, colour: str) -> bytes:
        self._encoder.begin(number, self.tick, *self.sky())
        for s, name in enumerate((*self.species, *self.objects)):
            c = self.crowd(name)
            value, genes = self._graded(name, c, colour), self._shown(s, name, c)
            self._encoder.add(c.x, c.y, c.z, c.heading, value, c.uid, c.alive, genes)
        return self._encoder.bytes()

    def _shown(self, s: int, name: str, crowd: Crowd) -> np.ndarray | None:
        """Return the genes that show in bodies as values of colors: u16[n], size + 256 · stripes, or None."""
        genes = shown_genes(self.genes.get(name, {}), s in self.animals)
        plain = s in self.animals and genes[0] is None and len(self.size) < 3  # no gene sizes the bodies
        grows = growth_of(config.species[name]) if plain and (config := self.config) is not None else None
        if genes == (None, None) and grows is None:
            return None
        low, high = (
            self._graded(name, crowd, f"gene:{gene}").astype(np.uint16) if gene else np.uint16(0)
            for gene in genes
        )
        if grows is not None and (column := crowd.value(grows[0])) is not None:
            low = np.zeros(column.size, np.uint8)
            grade(np.ones(column.size, np.bool_), column, np.float32(0), np.float32(grows[1]), low)
        return np.asarray(low + 256 * high, np.uint16)

    def _graded(self, name: str, crowd: Crowd, colour: str) -> np.ndarray:
        """Return the value of each organism for a color: u8[n]."""
        out, of = np.zeros(crowd.uid.size, np.uint8), asked(colour)
        if of is not None or colour == "family":
            rows = crowd.rows
            uid = crowd.uid[rows]
            out[rows] = self.families.values(name, uid) if of is None else self.families.kin(of, uid)
            return out
        column = crowd.value(colour)
        if column is not None:
            alive = np.ones(column.size, np.bool_) if crowd.alive is None else crowd.alive
            low, high = self.ranges[colour, name] = self._range(name, crowd, colour, *extent(alive, column))
            grade(alive, column, np.float32(low), np.float32(high), out)
        return out

    def _range(self, name: str, crowd: Crowd, colour: str, least: float, most: float) -> tuple[float, float]:
        """Return the range of a color: fixed, or wide enough for all values; it contracts slowly, without jumps."""
        if colour.startswith("gene:"):
            code = self.genes[name][colour[5:]]
            return float(code.low), float(code.high)
        low, high = None if colour == "happiness" else 0.0, crowd.full if colour == "energy" else None
        if (low is None or high is None) and not least <= most:
            return self.ranges.get((colour, name), (0.0, 1.0))
        before = self.ranges.get((colour, name), (least, most))
        return (
            min(least, before[0] + NARROWER * (least - before[0])) if low is None else low,
            max(most, before[1] + NARROWER * (most - before[1])) if high is None else high,
        )

    def scales(self, colour: str) -> dict[str, tuple[float, float]]:
        return {
            name: (float(f"{low:.5g}"), float(f"{high:.5g}"))
            for (c, name), (low, high) in self.ranges.items()
            if c == colour
        }

    def fates(self, after: int) -> list[tuple[float, ...]]:
        tick, names = self.tick - self.ahead, ("tick", "species", "uid", "x", "y", "z", "killer")
        columns = self.genealogy.noted.deaths.between(max(after - self.ahead, tick - TICKS) + 1, tick, names)
        # plants die too often to be marked
        rows = np.flatnonzero(np.isin(columns["species"], self.animals))[-MOST:]
        fates = {name: column[rows] for name, column in columns.items()}
        fates |= {axis: fates[axis].astype(np.float64).round(2) for axis in "xyz"}
        return list(zip(*(fates[name].tolist() for name in names), strict=True))

    def listed(self, name: str) -> listing.Columns:
        """Return the columns of a species, sorted by uid."""
        crowd, genes = self.crowd(name), self.genes.get(name, ())
        rows = crowd.rows
        rows = rows[np.argsort(crowd.uid[rows], kind="stable")]
        uid = crowd.uid[rows]
        values = {key: crowd.value(key) for key in ("born", *listing.STATES, *(f"gene:{g}" for g in genes))}
        return (
            {"uid": uid, "born": uid, "family": self.families.roots(uid)}
            | {key: column[rows] for key, column in values.items() if column is not None}
            | {axis: getattr(crowd, axis)[rows] for axis in "xyz"[: len(self.size)]}
        )

    def organism(self, uid: int) -> Message:
        state = self.state(uid)
        name = state["species"]
        eaters = [eater for eater, eaten in self.foods.items() if name in eaten]
        return state | {"kind": "organism", "sentence": sentence(state, self.foods.get(name, []), eaters)}

    def greeting(self) -> list[Message]:
        return [self.marks(), {"kind": "story", "entries": self.story.entries}]

    def passed(self) -> None:
        """Update after a tick; a recorded run needs no updates."""

    def sample(self) -> None:
        """Add a point to the curves; a recorded run already has its curves."""

    def handle(self, request: Message) -> list[Message]:
        kind = request["kind"]
        if kind in ("table", "scatter"):
            return [getattr(listing, kind)(self.listed, self.species, request)]
        if kind == "tree":
            return [tree(self.genealogy, self.families, request)]
        if kind in self.answers:
            return self.answers[kind](request)
        return [said("warning", self.refusal.format(kind), kind)]


def tick_of(value: object, allowed: str) -> int:
    """Return the tick of a `seek` request; raise ValueError if it is not a number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"seek: tick = {str(value)[:60]}; expected {allowed}")
    return round(value)
