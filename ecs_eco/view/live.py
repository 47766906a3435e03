"""A living world as a source for the viewer."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np

from ecs_eco.components import Biology, Genome, Metabolism, Nervous, Position
from ecs_eco.config.knobs import offered
from ecs_eco.config.models.interventions import describe as in_words
from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import ConfigError
from ecs_eco.engine.hooks import listening
from ecs_eco.engine.table import Table
from ecs_eco.view import listing
from ecs_eco.view.account import REMEMBERED, of_world
from ecs_eco.view.families import Families, Logged, asked, logged, tree
from ecs_eco.view.fates import Fate, Fates
from ecs_eco.view.frames import Encoder, extent, grade
from ecs_eco.view.inspect import LastStates
from ecs_eco.view.pedigree import PedigreeLog
from ecs_eco.view.rewind import Ring
from ecs_eco.view.scene import (
    coloured_genes,
    describe,
    drawn,
    kinds_of,
    land_of,
    map_of,
    sky,
    switches,
    uses_of,
)
from ecs_eco.view.sentence import sentence
from ecs_eco.view.source import Message, said
from ecs_eco.view.tally import Curves, Tally

TRACED = 600  # points of the happiness trace of one organism
FOLLOWED = 16  # organisms whose traces are kept


class Live:
    """A world that lives in this thread, to be watched; see `ecs_eco.view.source.Source`.

    `last` is the tick at which it ends, None for never. Watching changes nothing: pages act on the world by
    interventions only, at the start of the next tick.
    """

    def __init__(self, world: World, last: int | None = None) -> None:
        self.world, self.last = world, last
        self.species, self.objects = kinds_of(world)
        self.names = [*self.species, *self.objects]
        self.pedigree, self.tally = PedigreeLog(world), Tally(world, self.species)
        self.ring, self._fates = Ring(world, self.tally), Fates(world, self.species)
        self.ring.loaded = self._forget
        self.families = Families(lambda: logged(self.pedigree))
        self._told = -1, 0  # how far the story has been told
        if world.recorder is not None:
            world.recorder.remembered = REMEMBERED
        self._encoder = Encoder(world.space.size, len(self.names))
        self.genes = {name: coloured_genes(world.tables[name]) for name in self.species}
        self.ranges: dict[tuple[str, str], tuple[float, float]] = {}
        self._values: dict[str, np.ndarray] = {}
        self.curves = Curves()
        self._traces: dict[int, deque[tuple[int, float | None, float | None]]] = {}
        self.last_states = LastStates(world, self.pedigree, self._traces.keys())
        self._announced = len(world.intervened), uses_of(world)
        self.frame(0, "happiness")  # compiles kernels before anybody waits

    @property
    def tick(self) -> int:
        """The next tick."""
        return self.world.tick

    @property
    def done(self) -> bool:
        """Whether the world has reached its end."""
        return self.last is not None and self.world.tick >= self.last

    def run(self, turn: Callable[[], bool]) -> None:
        """Run the world, calling `turn()` before every tick and after the last, until it returns False."""
        world = self.world
        go, served = True, False
        self.ring.used = True

        def look() -> None:
            nonlocal go, served
            if self.ring.busy:
                self.passed()
                return
            self.ring.look()
            go, served = served or turn(), False
            if not go:
                world.stop()

        with listening(world.before_tick, look):
            while go:
                if self.done:
                    go = served = turn()  # at its end, until somebody goes back in time
                else:
                    served = False
                world.run(10**12 if self.last is None else max(0, self.last - world.tick))

    def hello(self) -> Message:
        """Return what a page needs to know of the world."""
        genes = dict.fromkeys(f"gene:{gene}" for names in self.genes.values() for gene in names)
        scene = describe(self.world, self.species, self.objects, self.genes)
        return {
            "kind": "hello",
            "mode": "live",
            "first": 0,
            "last": self.last,
            "tick": self.tick,
            "acts": True,
            "rewinds": self.ring.used and not self.ring.why,
            "stays": self.ring.why,
            "foods": self.tally.foods,
            "colours": ["species", "energy", "happiness", "age", "family", *genes],
            **scene,
        }

    def greeting(self) -> list[Message]:
        """Return the interventions and the story so far."""
        return [self._marks(), {"kind": "story", "entries": self.tally.story.entries}]

    def passed(self) -> None:
        """Take note of a tick that has passed."""
        self.tally.passed()

    def news(self) -> list[Message]:
        """Return the marks again after an intervention, and the story where it has gone on."""
        done, entries = (len(self.world.intervened), uses_of(self.world)), self.tally.story.entries
        marks = [] if self._announced == done else [self._marks()]
        told = (entries[-1]["tick"], len(entries)) if entries else (-1, 0)
        story = [] if self._told == told else [{"kind": "story", "entries": entries}]
        self._announced, self._told = done, told
        return [*marks, *story]

    def _marks(self) -> Message:
        done = [
            {"tick": tick, "text": in_words(intervention)}
            for tick, intervention in self.world.intervened[-1000:]
        ]
        return {
            "kind": "marks",
            "births": None,
            "deaths": None,
            "interventions": done,
            "switches": switches(self.world, self.species),
            **drawn(land_of(self.world)),
        }

    def counts(self) -> dict[str, int]:
        """Return the number of each kind."""
        return {name: int(self.world.tables[name].n) for name in self.names}

    def frame(self, number: int, colour: str) -> bytes:
        """Return the frame of this tick: value 0 for organisms without one,
        1 to 255 from the low to the high of `scales`."""
        light, elevation = sky(self.world)
        self._encoder.begin(number, self.tick, light, elevation)
        for name in self.names:
            table = self.world.tables[name]
            high, p = table.high, table[Position]
            self._encoder.add(
                p.x[:high],
                p.y[:high],
                p.z[:high],
                p.heading[:high],
                self._value(table, colour)[:high],
                table.uid[:high],
                table.alive[:high],
            )
        return self._encoder.bytes()

    def fates(self, after: int) -> list[Fate]:
        """Return the deaths of animals after a tick."""
        return self._fates.since(after)

    def field(self, name: str) -> Message:
        """Return the map of a field."""
        return map_of(self.world, name)

    def scales(self, colour: str) -> dict[str, tuple[float, float]]:
        """Return low and high of a colour, by kind."""
        return {
            name: (float(f"{low:.5g}"), float(f"{high:.5g}"))
            for (c, name), (low, high) in self.ranges.items()
            if c == colour
        }

    def _value(self, table: Table, colour: str) -> np.ndarray:
        """Return the value of each row: u8[capacity]."""
        value = self._values.get(table.name)
        if value is None or value.size < table.capacity:
            value = self._values[table.name] = np.zeros(table.capacity, np.uint8)
        if colour == "family" or asked(colour):
            rows, of = table.rows(), asked(colour)
            uid = table.uid[rows]
            value[rows] = self.families.kin(of, uid) if of else self.families.values(table.name, uid)
            return value
        column, low, high = self.column(table, colour)
        if column is None:
            value[:] = 0
            return value
        alive = table.alive[: table.high]
        if low is None or high is None:
            low, high = self._range(table.name, colour, low, high, *extent(alive, column[: table.high]))
        self.ranges[colour, table.name] = low, high
        grade(alive, column[: table.high], np.float32(low), np.float32(high), value)
        return value

    def column(self, table: Table, colour: str) -> tuple[Any, float | None, float | None]:
        """Return the values behind a colour: a column or None,
        and their range as far as it is known beforehand."""
        if colour == "energy" and Metabolism in table:
            budget = getattr(table.species.section, "metabolism", None)
            return table[Metabolism].energy, 0.0, None if budget is None else float(budget.energy_max)
        if colour == "happiness" and Nervous in table and table.species.nerves.happiness is not None:
            return table[Nervous].happiness, None, None
        if colour == "age" and Biology in table:
            return table[Biology].age, 0.0, None
        code = (
            self.genes.get(table.name, {}).get(colour.removeprefix("gene:"))
            if colour.startswith("gene:")
            else None
        )
        if code is None:
            return None, None, None
        return self._expressed(table, code.name), float(code.low), float(code.high)

    def _expressed(self, table: Table, gene: str) -> np.ndarray:
        rows, out = table.rows(), np.zeros(table.capacity, np.float32)
        out[rows] = table.species.heredity.layout.decode(table[Genome].loci[rows], [gene])[gene]
        return out

    def _range(
        self, name: str, colour: str, low: float | None, high: float | None, least: float, most: float
    ) -> tuple[float, float]:
        """Return the range of a colour: wide enough for all now, and only slowly narrower,
        so that colours do not jump."""
        if not least <= most:
            return self.ranges.get((colour, name), (0.0, 1.0))
        before = self.ranges.get((colour, name), (least, most))
        low = min(least, before[0] + 0.02 * (least - before[0])) if low is None else low
        high = max(most, before[1] + 0.02 * (most - before[1])) if high is None else high
        return low, high

    def sample(self) -> None:
        """Note numbers, mean happiness (before the first tick nobody has felt any), mean values of genes, the
        light, and what reporters said last."""
        point: dict[tuple[str, ...], float] = {("light", ""): sky(self.world)[0]}
        for name in self.species:
            table = self.world.tables[name]
            point["n", name] = int(table.n)
            if not table.n:
                continue
            rows = table.rows()
            if self.tick and Nervous in table and table.species.nerves.happiness is not None:
                point["happiness", name] = float(table[Nervous].happiness[rows].mean(dtype=np.float64))
            if self.genes[name]:
                decoded = table.species.heredity.layout.decode(table[Genome].loci[rows], self.genes[name])
                for gene, values in decoded.items():
                    point["genes", f"{name}.{gene}"] = float(values.mean(dtype=np.float64))
        for name, report in self._reports().items():
            for species, value in (report if isinstance(report, dict) else {"": report}).items():
                point["reports", name, species] = value
        self.curves.add(self.tick, point | self.tally.rates())

    def _reports(self) -> dict[str, float | dict[str, float]]:
        """Return what reporters said last; of a world that is not recorded, what they say now."""
        recorder = self.world.recorder
        if recorder is not None:
            return {} if recorder.reports is None else recorder.reports.latest
        return {name: self.world.report(name) for name in self.world.reporters}

    def series(self, after: int) -> Message | None:
        """Return the points since a tick."""
        return self.curves.after(after)

    def organism(self, uid: int) -> Message:
        """Return one organism, living or dead; KeyError for an unknown one."""
        state = self.last_states.state_of(uid)
        happy = None if state.get("nerves") is None else state["nerves"].get("happiness")
        foods, name = self.tally.foods, state["species"]
        eaters = [eater for eater, eaten in foods.items() if name in eaten]
        words = sentence(state, foods.get(name, []), eaters)
        return state | {
            "kind": "organism",
            "sentence": words,
            "trace": self._trace(uid, happy, state["energy"] if state["alive"] else None),
        }

    def _trace(self, uid: int, happiness: float | None, energy: float | None) -> Message:
        """Add a point to an organism's trace and return the trace;
        those of the last few organisms selected are kept."""
        points = self._traces.pop(uid, None)
        points = self._traces[uid] = deque(maxlen=TRACED) if points is None else points
        while len(self._traces) > FOLLOWED:
            self._traces.pop(next(iter(self._traces)))
        if energy is not None and (not points or points[-1][0] < self.tick):
            points.append((self.tick, _number(happiness), _number(energy)))
        names = ("tick", "happiness", "energy")
        return {
            name: list(values)
            for name, values in zip(names, zip(*points, strict=True) if points else ([], [], []), strict=True)
        }

    def listed(self, name: str) -> listing.Columns:
        """Return the columns of a species, in the order of uids."""
        table, genes = self.world.tables[name], self.genes[name]
        rows, p = table.by_uid(), table[Position]
        values = {key: self.column(table, key)[0] for key in (*listing.STATES, *(f"gene:{g}" for g in genes))}
        return (
            {"uid": table.uid[rows], "born": table.born[rows], "family": self.families.roots(table.uid[rows])}
            | {key: column[rows] for key, column in values.items() if column is not None}
            | {axis: getattr(p, axis)[rows] for axis in ("xyz" if self.world.space.volume else "xy")}
        )

    def handle(self, request: Message) -> list[Message]:
        """Intervene, or list the values that may be changed."""
        kind = request["kind"]
        if kind == "act":
            return [self._act(request.get("what"))]
        if kind == "seek":
            return [self._seek(request.get("tick"))]
        if kind == "why":
            return [of_world(self.world, self.pedigree)]
        if kind == "tree":
            return [tree(Logged(self.pedigree), self.families, request)]
        if kind in ("table", "scatter"):
            return [getattr(listing, kind)(self.listed, self.species, request)]
        if kind == "params":
            return [{"kind": "params", **offered(self.world.config)}]
        return [said("warning", f"{kind} is for recorded runs; this world is alive", kind)]

    def _seek(self, tick: object) -> Message:
        """Go back to an earlier tick; what came after it is forgotten."""
        if isinstance(tick, bool) or not isinstance(tick, int | float) or not math.isfinite(tick):
            raise ValueError(f"seek: tick = {str(tick)[:60]}; allowed: a tick up to {self.tick}")
        tick = self.ring.back(round(tick))
        self.families = Families(lambda: logged(self.pedigree))
        self.curves.cut(tick)
        for trace in self._traces.values():
            while trace and trace[-1][0] >= tick:
                trace.pop()
        text = f"Back at tick {tick:,}. It goes on as it did, unless you change something"
        return said("info", text, "seek")

    def _forget(self) -> None:
        """Forget who was born and died since a checkpoint: they are noted again as it is lived again."""
        self.pedigree.go_back(self.world.tick, int(self.world.next_uid))
        self._fates.go_back(self.world.tick)

    def _act(self, request: object) -> Message:
        try:
            if not isinstance(request, dict):
                raise ValueError("act: `what` is no intervention; see [[interventions]] of a world file")
            if self.done:
                raise ValueError("act: the run is at its end")
            self.world.intervene(request)
            self.ring.acts.append((self.tick, request))
        except (ValueError, RuntimeError) as error:
            problems = error.problems if isinstance(error, ConfigError) else []
            field = ".".join(map(str, problems[0].key)) if problems else "act"
            return said("error", str(error), field)
        return said("info", f"tick {self.tick}: {in_words(request)}")


def _number(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(f"{value:.6g}")
