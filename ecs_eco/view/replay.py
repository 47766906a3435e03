"""A recorded run as a source for the viewer."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.style import own_colors
from ecs_eco.config.models.body import Body
from ecs_eco.ecosystem import World
from ecs_eco.record.seal import validate
from ecs_eco.view.account import of_run
from ecs_eco.view.curves import series
from ecs_eco.view.genealogy import Genealogy
from ecs_eco.view.inspect import seen_by
from ecs_eco.view.interpolate import Organisms
from ecs_eco.view.life import Lives
from ecs_eco.view.parts import Cache
from ecs_eco.view.past import Past
from ecs_eco.view.recording import COMPARED, GeneValues, Recording, overlaid
from ecs_eco.view.rerun import Rerun, Stretch, note, stretches
from ecs_eco.view.scene import describe, drawn, eyes_of, plain_kind, sized
from ecs_eco.view.source import Message, said, uid_of
from ecs_eco.view.watched import Crowd, Watched, tick_of

STRETCHES = 3  # stretches kept in memory
GENOMES = 500_000  # with more births, gene means are not computed
OBJECT_UID = 0x80000000  # objects are recorded without uids; in a frame, their uids start here


class Replay(Watched):
    """A recorded run as shown in the viewer. The recording never changes.

    Parameters
    ----------
    path : str or Path
        Folder of a run.

    Attributes
    ----------
    tick : int
        The displayed tick, whose final state is shown.

    Examples
    --------
    >>> from ecs_eco.runs.run import run_to_folder
    >>> from ecs_eco.view.replay import Replay
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=5, out="my-run", report=False)
    >>> replay = Replay("my-run")
    >>> replay.species
    ['grass', 'deer', 'wolf']
    """

    mode = "replay"
    refusal = (
        "a recorded run cannot be changed; branch it: "
        "ecs-eco resume DIR --from-tick T --set KEY=VALUE --out NEW"
    )

    def __init__(self, path: str | Path) -> None:
        r = self.recording = Recording(path)
        self.species, self.objects = r.species, list(r.objects)
        self._config: dict[str, Any] = r.manifest["config"]["species"]
        self.animals = [s for s, name in enumerate(r.species) if self._config[name].get("locomotion")]
        self.past, self._values = Past(r), GeneValues(r)
        self.genes, self.story = self._values.codes, self.past
        self.foods, self.eats = self.past.foods, self.past.eats
        self.genealogy = Genealogy(r)
        self.stretches: list[Stretch] = []
        self.lives = Lives(r, self.genealogy, self.stretches)
        self._tick = r.first
        self._rerun = Rerun(r.path, r.manifest, r.last)
        self._land = r.land(r.first)
        self.answers = {
            "seek": self._seek,
            "fill": self._fill,
            "why": lambda request: [of_run(r.path, self._tick)],
            "params": lambda request: [{"kind": "params", "list": []}],
        }
        super().__init__(r.size)

    @property
    def tick(self) -> int:
        return self._tick

    @property
    def earliest(self) -> int:
        return self.recording.first

    @property
    def done(self) -> bool:
        return self._tick >= self.recording.last

    def run(self, turn: Callable[[], bool]) -> None:
        try:
            while turn():
                self._tick = min(self._tick + 1, self.recording.last)
        finally:
            self._rerun.halt()

    def hello(self) -> Message:
        return self._hello | {"tick": self._tick}

    @cached_property
    def _hello(self) -> Message:
        r, described = self.recording, self._described()
        if island := r.manifest.get("island"):
            described["title"] = f"{island}, {described['title']}"
        return super().hello() | {
            "first": r.first,
            "last": r.last,
            "acts": False,
            "snapshot_every": r.every,
            "note": note(r),
            **described,
        }

    def _described(self) -> Message:
        r = self.recording
        colors, config = own_colors(r.manifest.get("colors")), r.manifest["config"]
        if r.scene is not None:
            message = describe(r.scene, r.species, self.objects, self.genes)
            learn = r.manifest.get("learn")
            for kind in message["species"]:
                policy = r.scene.config.species[kind["name"]].policy
                decides = policy.kind != "none" and r.manifest.get("policies") != "random"
                kind["learns"] = decides and bool(policy.learn if learn is None else learn)
                kind["color"] = colors.get(kind["name"], kind["color"])
            fields = [name for name in message["fields"] if name not in r.scene.fields]  # not recorded
            return message | {"objects": sized(message["objects"], r.objects, OBJECT_UID), "fields": fields}
        for section in (*config["species"].values(), *(config["objects"][n] for n in self.objects)):
            validate(r.path / "manifest.json", section.get("body") or {}, Body)
        kinds = [
            plain_kind(n, config["species"][n], colors.get(n))
            | {"sees": eyes_of(config["species"][n].get("sensors"))}
            for n in r.species
        ]
        things = [
            plain_kind(n, config["objects"][n], config["objects"][n].get("color"))
            | {"inanimate": True, "solid": config["objects"][n]["body"]["solid"]}
            for n in self.objects
        ]
        world = r.manifest["world"]
        return {
            "world": world,
            "title": r.manifest.get("title") or world,
            "dt": r.dt,
            "seed": r.manifest["seed"],
            "size": r.size,
            "edges": "torus" if r.torus else "walls",
            "day": None,
            "usual_speed": 10.0,
            "species": kinds,
            "objects": sized(things, r.objects, OBJECT_UID),
            "terrain": None,
        }

    def greeting(self) -> list[Message]:
        warning = said("warning", f"this world cannot be built here: {self.recording.why}")
        return [*super().greeting(), *([warning] if self.recording.scene is None else [])]

    def marks(self) -> Message:
        r = self.recording
        return {
            "kind": "marks",
            "births": r.curves["births"].tolist(),
            "deaths": r.curves["deaths"].tolist(),
            "interventions": r.interventions(),
            "stretches": stretches(r, self.stretches),
        } | drawn(self._land)

    def news(self) -> list[Message]:
        before, self._land = self._land, self.recording.land(self._tick)
        return [*([] if self._land == before else [self.marks()]), *self._filled()]

    def _filled(self) -> list[Message]:
        stretch = self._rerun.answer()
        if stretch is None or isinstance(stretch, str):
            return [said("error", stretch, "fill")] if stretch else []
        del self.stretches[: max(0, len(self.stretches) + 1 - STRETCHES)]
        self.stretches.append(stretch)
        text = f"ticks {stretch.first} to {stretch.last} have been rerun: all their details are available"
        if stretch.wrong is not None:
            text += (
                f", but the rerun differs from the recording from tick {stretch.wrong} onward; "
                "different versions or another machine may be the cause"
            )
        message = said("info" if stretch.wrong is None else "warning", text, "fill")
        try:
            return [message, self.organism(self._rerun.uid), self.marks()]
        except KeyError:
            return [message, self.marks()]

    def counts(self) -> dict[str, int]:
        return self.recording.numbers(self._tick) | {
            name: len(places) for name, places in self.recording.objects.items()
        }

    def organisms(self, species: str) -> Organisms:
        """Return the living organisms of a species at this tick as exactly as possible."""
        r = self.recording
        organisms = r.organisms(self._tick, species)
        for stretch in self.stretches:
            if stretch.first <= self._tick <= stretch.last:
                organisms = overlaid(organisms, stretch.at(self._tick, r.species.index(species)))
        return organisms

    def crowd(self, name: str) -> Crowd:
        r = self.recording
        if name in self.objects:
            first = OBJECT_UID + sum(len(r.objects[n]) for n in self.objects[: self.objects.index(name)])
            lying = r.objects[name]
            x, y, z, heading = (np.ascontiguousarray(lying[:, i]) for i in range(4))
            return Crowd(np.arange(first, first + len(lying), dtype=np.uint64), x, y, z, heading)
        o, full = (self.organisms(name), r.energy_max(name))

        def value(what: str) -> np.ndarray | None:
            if what == "energy" or (what == "happiness" and self._config[name].get("happiness")):
                state: np.ndarray = getattr(o, what)
                return state
            if what in ("age", "born"):
                born = r.born(o.uid)
                return born if what == "born" else ((self._tick - born) * r.dt).astype(np.float32)
            if what.startswith("gene:") and (gene := what[5:]) in self.genes.get(name, {}):
                return self._values.expressed(name, o.uid, gene)
            return None

        return Crowd(o.uid, o.x, o.y, o.z, o.heading, value, full)

    @property
    def scene(self) -> World | None:
        scene: World | None = self.recording.scene
        if scene is not None:
            scene.tick = self._tick
        return scene

    def series(self, after: int) -> Message | None:
        return self._curves if self._curves["tick"][-1] > after else None

    @cached_property
    def _curves(self) -> Message:
        r = self.recording
        tick = r.curves["tick"]
        levels = self.past.levels(tick)
        if self.genes and r.births.rows <= GENOMES:
            levels |= {("genes", name): mean for name, mean in self._values.means(tick).items()}
        if self.hello()["day"] is not None:
            levels["light", ""] = np.array([r.sky(t)[0] for t in tick.tolist()])
        out = series(
            np.append(r.first - 1, tick),
            levels,
            {key: np.append(0.0, of) for key, of in self.past.sums(tick).items()},
            before=1,
        )
        return out | ({"shared": True} if self.past.shared and "flows" in out else {})

    def state(self, uid: int) -> Message:
        state, r = self.lives.organism(uid, self._tick), self.recording
        changed = (key for _, what in r.manifest.get("intervened", []) for key in what.get("set") or ())
        if r.scene is None or not state["nerves"] or any(".sensors" in key for key in changed):
            return state
        table = r.scene.tables[state["species"]]
        return state | {"channels": seen_by(r.scene, table, {str(n): None for n in table.species.own_ranges})}

    def _seek(self, request: Message) -> list[Message]:
        r = self.recording
        tick = tick_of(request.get("tick"), f"a tick from {r.first} to {r.last}")
        self._tick = min(max(tick, r.first), r.last)
        return []

    def _fill(self, request: Message) -> list[Message]:
        uid = uid_of(request)
        if self._rerun.busy:
            return [said("info", f"still running: {100 * self._rerun.share:.0f}%", "fill")]
        try:
            died = self.lives.died(uid, self._tick)
        except KeyError:
            raise ValueError(f"fill: no organism of this run has the uid {uid}") from None
        tick = self._tick if died is None else died  # for a dead organism, the last ticks of its life
        if any(s.first <= tick <= s.last for s in self.stretches):
            return [self.organism(uid)]
        # separate files and cache, because the recording's own belong to this thread
        series = self.recording.parts("series", Cache())
        self._rerun.begin(uid, tick, lambda tick: series.between(tick, tick, COMPARED))
        return [said("info", f"rerunning from the last checkpoint before tick {tick + 1}", "fill")]
