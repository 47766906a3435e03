"""A live world as a source for the viewer."""

from collections import deque
from collections.abc import Callable
from functools import partial

import numpy as np

from ecs_eco.components import Biology, Body, Genome, Metabolism, Nervous, Position, Velocity
from ecs_eco.config.knobs import offered
from ecs_eco.config.models.interventions import describe as in_words
from ecs_eco.config.models.reporters import DIED
from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import ConfigError
from ecs_eco.engine.hooks import listening
from ecs_eco.engine.table import Table
from ecs_eco.view.account import REMEMBERED, of_world
from ecs_eco.view.curves import Curves, feels, sample
from ecs_eco.view.families import Families
from ecs_eco.view.genealogy import Genealogy
from ecs_eco.view.inspect import OF_NOW, state_of
from ecs_eco.view.journal import Journal
from ecs_eco.view.rewind import Ring
from ecs_eco.view.scene import coloured_genes, describe, drawn, kinds_of, land_of, switches, uses_of
from ecs_eco.view.source import Message, said
from ecs_eco.view.story import EVERY, Story, Turn, foods_of, half_of_peak
from ecs_eco.view.watched import Crowd, Watched, tick_of

TRACED = 600  # maximum number of points in an organism's trace
FOLLOWED = 16  # organisms whose traces are stored
KEPT = 64  # dead organisms whose last states are stored
STATES = {"energy": Metabolism, "happiness": Nervous, "age": Biology, "radius": Body}


class Live(Watched):
    """A live world that runs in this thread until tick `last` (None: without end). Watching changes nothing:
    pages affect the world only through interventions, at the start of the next tick."""

    mode, ahead = "live", 1
    refusal = "{} needs a recorded run; this is a live world"
    story: Story

    def __init__(self, world: World, last: int | None = None) -> None:
        self.world, self.last = world, last
        self.species, self.objects = kinds_of(world)
        self.animals = [s for s, name in enumerate(self.species) if Velocity in world.tables[name]]
        self.genes = {name: coloured_genes(world.tables[name]) for name in self.species}
        self.journal = Journal(world, self.species)
        self.genealogy = Genealogy(self.journal)
        self.foods, self.eats = (
            foods_of(None if world.config is None else world.config.model_dump(include={"species"}), harmful)
            for harmful in (False, True)
        )
        self.story = Story(self.species, self.foods, self.journal.cause, self._half)
        super().__init__(world.space.size)
        self.answers = {
            "act": self._act,
            "seek": self._seek,
            "why": lambda request: [of_world(self.world, self.journal)],
            "params": lambda request: [{"kind": "params", **offered(self.world.config)}],
        }
        self.ring = Ring(world, self.journal, self.story)
        self._told = -1, 0  # sent so far: tick of the latest story entry, number of entries
        if world.recorder is not None and (world.recorder.sink is not None or not world.recorder.keeps):
            world.recorder.remembered = REMEMBERED
        self.curves = Curves()
        self._traces: dict[int, deque[tuple[int, float | None, float | None]]] = {}
        self.last_states: dict[int, Message] = {}  # dead organisms by uid, in order of death
        world.on_death.append(self._has_died)
        self._announced = len(world.intervened), uses_of(world)

    @property
    def tick(self) -> int:
        return self.world.tick

    @property
    def earliest(self) -> int:
        return self.ring.first

    @property
    def done(self) -> bool:
        return self.last is not None and self.world.tick >= self.last

    def run(self, turn: Callable[[], bool]) -> None:
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
                    go = served = turn()  # wait at the end until a page goes back in time
                else:
                    served = False
                world.run(10**12 if self.last is None else max(0, self.last - world.tick))

    def hello(self) -> Message:
        return super().hello() | {
            "first": 0,
            "last": self.last,
            "tick": self.tick,
            "acts": True,
            "rewinds": self.ring.used and not self.ring.why,
            "stays": self.ring.why,
            **describe(self.world, self.species, self.objects, self.genes),
        }

    def passed(self) -> None:
        k, over = len(self.species), self.world.tick - 1  # the last completed tick, as in the records
        n = [self.world.tables[name].n for name in self.species]
        if over % EVERY == 0 or self.story.changes(n):
            births, bred, died = self.journal.born[:k], self.journal.bred[:k], self.journal.died[:k]
            self.story.note(max(0, over), np.array(n, np.int64), births, died, bred)

    def _half(self, s: int, now: Turn) -> Turn | None:
        """Return when an extinct species last had half of its peak number, from the recorder."""
        rows = {} if self.world.recorder is None else self.world.recorder.since(-1)
        order = [self.world.recorder.place[name] for name in self.species] if self.world.recorder else []
        if not rows or (i := half_of_peak(rows["n"][:, order[s]])) is None:
            return None
        later = {name: column[i + 1 :, order[s]].sum() for name, column in rows.items()}
        deaths = now.deaths.copy()
        for number, cause in enumerate(self.world.causes, 1):
            deaths[number] -= int(later.get(DIED + cause, 0))
        n = rows["n"][i, order].astype(np.int64)
        return Turn(int(rows["tick"][i, 0]), int(n[s]), now.births - int(later["births"]), deaths, n)

    def news(self) -> list[Message]:
        done, entries = (len(self.world.intervened), uses_of(self.world)), self.story.entries
        marks = [] if self._announced == done else [self.marks()]
        told = (entries[-1]["tick"], len(entries)) if entries else (-1, 0)
        story = [] if self._told == told else [{"kind": "story", "entries": entries}]
        self._announced, self._told = done, told
        return [*marks, *story]

    def marks(self) -> Message:
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
        return {name: int(self.world.tables[name].n) for name in (*self.species, *self.objects)}

    @property
    def scene(self) -> World:
        return self.world

    def crowd(self, name: str) -> Crowd:
        table = self.world.tables[name]
        high, p = table.high, table[Position]
        budget = getattr(table.species.section, "metabolism", None) if Metabolism in table else None
        x, y, z, heading = (axis[:high] for axis in (p.x, p.y, p.z, p.heading))
        full = None if budget is None else float(budget.energy_max)
        value = partial(self._value, table)
        return Crowd(table.uid[:high], x, y, z, heading, value, full, table.alive[:high])

    def _value(self, table: Table, what: str) -> np.ndarray | None:
        """Return the values for `Crowd.value`, by row."""
        column: np.ndarray | None = table.born if what == "born" else None
        if what.startswith("gene:") and (gene := what[5:]) in self.genes.get(table.name, {}):
            rows, column = table.rows(), np.zeros(table.capacity, np.float32)
            column[rows] = table.species.heredity.layout.decode(table[Genome].loci[rows], [gene])[gene]
        elif what in STATES and STATES[what] in table and (what != "happiness" or feels(table)):
            column = getattr(table[STATES[what]], what)
        return None if column is None else column[: table.high]

    def sample(self) -> None:
        sample(self.curves, self.world, self.journal, self.genes)

    def series(self, after: int) -> Message | None:
        return self.curves.after(after)

    def state(self, uid: int) -> Message:
        state = state_of(self.world, uid, lives=self.genealogy)
        last = self.last_states.get(uid)
        if not state["alive"] and state["died"] is not None and last is not None:
            note = f"State in its last tick, {last['as_of']:,}."
            state = last | {name: state[name] for name in OF_NOW} | {"alive": False, "note": note}
        happy = None if state.get("nerves") is None else state["nerves"].get("happiness")
        return state | {"trace": self._trace(uid, happy, state["energy"] if state["alive"] else None)}

    def _has_died(self, table: Table, rows: np.ndarray) -> None:
        """Store the state of each followed organism that dies, before its row is freed."""
        for uid in table.uid[rows].tolist() if self._traces else ():
            if uid in self._traces:
                state, nerves = state_of(self.world, uid), table.species.nerves
                felt = nerves is not None and nerves.thoughts is not None and state["nerves"] is not None
                self.last_states.pop(uid, None)
                self.last_states[uid] = state | {"as_of": nerves.thoughts.tick if felt else self.tick}
                while len(self.last_states) > KEPT:
                    self.last_states.pop(next(iter(self.last_states)))

    def _trace(self, uid: int, happiness: float | None, energy: float | None) -> Message:
        """Add a point to an organism's trace and return the trace; keep those of the last selected organisms."""
        points = self._traces[uid] = self._traces.pop(uid, deque(maxlen=TRACED))
        while len(self._traces) > FOLLOWED:
            self._traces.pop(next(iter(self._traces)))
        if energy is not None and (not points or points[-1][0] < self.tick):
            points.append((self.tick, happiness, energy))
        return {
            name: [point[i] for point in points] for i, name in enumerate(("tick", "happiness", "energy"))
        }

    def _seek(self, request: Message) -> list[Message]:
        """Go back to an earlier tick and discard everything after it."""
        tick = tick_of(request.get("tick"), f"a tick up to {self.tick}")
        if request.get("undo") and tick < self.earliest:
            raise ValueError(
                f"undo: this world can go back only to tick {self.earliest:,}, and not to {tick:,}"
            )
        tick = self.ring.back(tick)
        self.genealogy.go_back()
        self.families = Families(self.genealogy.lives)
        self.curves.cut(tick)
        for trace in self._traces.values():
            while trace and trace[-1][0] >= tick:
                trace.pop()
        text = f"Back at tick {tick:,}. Unless you change something, the world will repeat itself"
        return [said("info", text, "seek")]

    def _act(self, request: Message) -> list[Message]:
        what = request.get("what")
        try:
            if not isinstance(what, dict):
                raise ValueError("act: `what` is not an intervention; see [[interventions]] in world files")
            if self.done:
                raise ValueError("act: the run has ended")
            self.world.intervene(what)
            self.ring.acts.append((self.tick, what))
        except (ValueError, RuntimeError) as error:
            problems = error.problems if isinstance(error, ConfigError) else []
            field = ".".join(map(str, problems[0].key)) if problems else "act"
            return [said("error", str(error), field)]
        return [said("info", f"tick {self.tick}: {in_words(what)}")]
