"""A recorded run as a source for the viewer; see `ecs_eco.view.source.Source`."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.style import own_colors
from ecs_eco.view import families, listing
from ecs_eco.view.account import of_run
from ecs_eco.view.families import Families, Recorded, asked, tree
from ecs_eco.view.fates import Fate, recorded
from ecs_eco.view.frames import Encoder, extent, grade
from ecs_eco.view.interpolate import Organisms
from ecs_eco.view.life import Lives
from ecs_eco.view.parts import Cache
from ecs_eco.view.recording import COMPARED, GeneValues, Recording, overlaid
from ecs_eco.view.rerun import Rerun, Stretch, note, stretches
from ecs_eco.view.scene import describe, drawn, eyes_of, map_of, size_in, sized, sky
from ecs_eco.view.sentence import sentence
from ecs_eco.view.source import Message, said, uid_of
from ecs_eco.view.story import foods_of
from ecs_eco.view.tally import DEPTH
from ecs_eco.view.told import Told

STRETCHES = 3  # that are kept
GENOMES = 500_000  # beyond so many births, mean values of genes are not computed
OBJECT_UID = 0x80000000  # objects are not recorded by uid: their uids in a frame start here


class Replay:
    """A folder written by `ecs-eco run`. Time is the tick shown; nothing of the recording changes."""

    def __init__(self, path: str | Path) -> None:
        self.recording = Recording(path)
        r = self.recording
        self.stretches: list[Stretch] = []
        self.lives = Lives(r, self.stretches)
        self._tick = r.first
        self.genes = GeneValues(r)
        self.ranges: dict[tuple[str, str], tuple[float, float]] = {}
        self._encoder = Encoder(r.size, len(r.species) + len(r.objects))
        self._rerun = Rerun(r.path, r.manifest, r.last)
        self._land = r.land(r.first)
        self._foods, self.past = foods_of(r.manifest.get("config")), Told(r)
        self.families = Families(lambda: self._births)
        self._hello: Message | None = None
        self._curves: Message | None = None
        self.frame(0, "happiness")  # compiles kernels before anybody waits

    @cached_property
    def _births(self) -> families.Lives:
        return families.recorded(self.recording)

    @property
    def tick(self) -> int:
        """The tick that is shown: the state at its end."""
        return self._tick

    @property
    def done(self) -> bool:
        """Whether this is the last tick."""
        return self._tick >= self.recording.last

    def run(self, turn: Callable[[], bool]) -> None:
        """Show tick after tick."""
        try:
            while turn():
                self._tick = min(self._tick + 1, self.recording.last)
        finally:
            self._rerun.halt()

    def hello(self) -> Message:
        """Return what a page needs to know of the run."""
        if self._hello is None:
            r = self.recording
            genes = dict.fromkeys(f"gene:{gene}" for names in self.genes.codes.values() for gene in names)
            self._hello = {
                "kind": "hello",
                "mode": "replay",
                "first": r.first,
                "last": r.last,
                "acts": False,
                "foods": self._foods,
                "snapshot_every": r.every,
                "colours": ["species", "energy", "happiness", "age", "family", *genes],
                "note": note(r),
                **self._scene(),
            }
        return self._hello | {"tick": self._tick}

    def _scene(self) -> Message:
        r = self.recording
        colors, config = own_colors(r.manifest.get("colors")), r.manifest["config"]
        if r.scene is not None:
            message = describe(
                r.scene,
                r.species,
                list(r.objects),
                {name: dict.fromkeys(g) for name, g in self.genes.codes.items()},
            )
            learn = r.manifest.get("learn")
            for kind in message["species"]:
                policy = config["species"][kind["name"]]["policy"]
                kind["learns"] = policy["kind"] != "none" and bool(
                    policy["learn"] if learn is None else learn
                )
                kind["color"] = colors.get(kind["name"], kind["color"])
            fields = [name for name in message["fields"] if name not in r.scene.fields]  # unrecorded
            return message | {"objects": sized(message["objects"], r.poses, OBJECT_UID), "fields": fields}
        kinds = [
            {
                "name": n,
                "color": colors.get(n, "#888888"),
                **size_in(config["species"][n]["body"]),
                "moves": bool(config["species"][n].get("locomotion")),
                "sessile": not config["species"][n].get("locomotion"),
                "genes": [],
                "learns": False,
                "sees": eyes_of(config["species"][n].get("sensors")),
            }
            for n in r.species
        ]
        things = [
            {
                "name": n,
                "color": config["objects"][n].get("color", "#888888"),
                **size_in(config["objects"][n]["body"]),
                "moves": False,
                "sessile": True,
                "genes": [],
                "learns": False,
                "inanimate": True,
                "solid": config["objects"][n]["body"]["solid"],
            }
            for n in r.objects
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
            "objects": sized(things, r.poses, OBJECT_UID),
            "terrain": None,
        }

    def greeting(self) -> list[Message]:
        """Return births and deaths along the time line, interventions, and the story."""
        both = [self._marks(), {"kind": "story", "entries": self.past.entries}]
        if self.recording.scene is not None:
            return both
        return [*both, said("warning", f"this world cannot be built here: {self.recording.why}")]

    def _marks(self) -> Message:
        r = self.recording
        return {
            "kind": "marks",
            "births": r.curves["births"].tolist(),
            "deaths": r.curves["deaths"].tolist(),
            "interventions": r.interventions(),
            "stretches": stretches(r, self.stretches),
        } | drawn(self._land)

    def news(self) -> list[Message]:
        """Return the marks if the land changed, and the result of a `fill` once it is done."""
        before, self._land = self._land, self.recording.land(self._tick)
        return [*([] if self._land == before else [self._marks()]), *self._filled()]

    def _filled(self) -> list[Message]:
        stretch = self._rerun.answer()
        if stretch is None:
            return []
        if isinstance(stretch, str):
            return [said("error", stretch, "fill")]
        del self.stretches[: max(0, len(self.stretches) + 1 - STRETCHES)]
        self.stretches.append(stretch)
        text = f"ticks {stretch.first} to {stretch.last} have been run again: all details are available there"
        if stretch.wrong is None:
            message = said("info", text, "fill")
        else:
            differs = (
                f"but it differs from the recording from tick {stretch.wrong} on: other versions, "
                "or another machine?"
            )
            message = said("warning", f"{text}; {differs}", "fill")
        try:
            return [message, self.organism(self._rerun.uid), self._marks()]
        except KeyError:
            return [message, self._marks()]

    def counts(self) -> dict[str, int]:
        """Return the number of each kind."""
        return self.recording.numbers(self._tick) | {
            name: len(places) for name, places in self.recording.objects.items()
        }

    def organisms(self, species: str) -> Organisms:
        """Return the living of a species at this tick, as exactly as possible."""
        r = self.recording
        organisms = r.organisms(self._tick, species)
        for stretch in self.stretches:
            if stretch.first <= self._tick <= stretch.last:
                organisms = overlaid(organisms, stretch.at(self._tick, r.species.index(species)))
        return organisms

    def sky(self, tick: int) -> tuple[float, float]:
        """Return the light at the surface at a tick, 0 to 1, and the sun's elevation [rad]."""
        scene = self.recording.scene
        if scene is None:
            return 1.0, math.pi / 2
        scene.tick = tick
        return sky(scene)

    def frame(self, number: int, colour: str) -> bytes:
        """Return the frame of this tick: value 0 where it is unknown,
        1 to 255 from the low to the high of `scales`."""
        self._encoder.begin(number, self._tick, *self.sky(self._tick))
        for name in self.recording.species:
            organisms = self.organisms(name)
            self._encoder.add(
                organisms.x,
                organisms.y,
                organisms.z,
                organisms.heading,
                self._value(name, organisms, colour),
                organisms.uid,
            )
        first = OBJECT_UID
        for name, places in self.recording.objects.items():
            x, y, z = (np.ascontiguousarray(places[:, i]) for i in range(3))
            heading = np.ascontiguousarray(self.recording.poses(name)[:, 0])
            self._encoder.add(
                x,
                y,
                z,
                heading,
                np.zeros(len(places), np.uint8),
                np.arange(first, first + len(places), dtype=np.uint64),
            )
            first += len(places)
        return self._encoder.bytes()

    def fates(self, after: int) -> list[Fate]:
        """Return the deaths of animals after a tick."""
        moving = {kind["name"] for kind in self.hello()["species"] if kind["moves"]}
        return recorded(self.recording, moving, after, self._tick)

    def field(self, name: str) -> Message:
        """Return the map of what is not recorded, but follows from time and place."""
        self.recording.scene.tick = self._tick
        return map_of(self.recording.scene, name)

    def scales(self, colour: str) -> dict[str, tuple[float, float]]:
        """Return low and high of a colour, by kind."""
        return {
            name: (float(f"{low:.5g}"), float(f"{high:.5g}"))
            for (c, name), (low, high) in self.ranges.items()
            if c == colour
        }

    def _value(self, name: str, organisms: Organisms, colour: str) -> np.ndarray:
        out, of = np.zeros(organisms.uid.size, np.uint8), asked(colour)
        if of is not None:
            return self.families.kin(of, organisms.uid)
        if colour == "family":
            return self.families.values(name, organisms.uid)
        column, low, high = self.column(name, organisms, colour)
        if column is None:
            return out
        alive = np.ones(column.size, np.bool_)
        if low is None or high is None:
            least, most = extent(alive, column)
            was = self.ranges.get((colour, name), (least, most) if least <= most else (0.0, 1.0))
            low = min(was[0], least) if low is None else low
            high = max(was[1], most) if high is None else high
        self.ranges[colour, name] = float(low), float(high)
        grade(alive, column, np.float32(low), np.float32(high), out)
        return out

    def column(self, name: str, organisms: Organisms, colour: str) -> tuple[Any, float | None, float | None]:
        """Return the values behind a colour: f32[n] or None,
        and their range as far as it is known beforehand."""
        species = self.recording.manifest["config"]["species"][name]
        if colour == "energy":
            return organisms.energy, 0.0, float(species["metabolism"]["energy_max"])
        if colour == "happiness" and species.get("happiness"):
            return organisms.happiness, None, None
        if colour == "age":
            return (
                ((self._tick - self.recording.born(organisms.uid)) * self.recording.dt).astype(np.float32),
                0.0,
                None,
            )
        code = (
            self.genes.codes.get(name, {}).get(colour.removeprefix("gene:"))
            if colour.startswith("gene:")
            else None
        )
        if code is None:
            return None, None, None
        return self.genes.expressed(name, organisms.uid, code.name), float(code.low), float(code.high)

    def sample(self) -> None:
        """Do nothing: the series were recorded."""

    def series(self, after: int) -> Message | None:
        """Return the points after a tick: all of them for −1, those of the future too."""
        if self._curves is None:
            self._curves = self._all()
        return self._curves if self._curves["tick"][-1] > after else None

    def _all(self) -> Message:
        r = self.recording
        tick = r.curves["tick"]
        out: Message = {
            "kind": "series",
            "tick": tick.tolist(),
            "reports": r.curves["reports"],
            "n": {n: v.astype(int).tolist() for n, v in r.curves["n"].items()},
        }
        feels = [name for name in r.species if r.manifest["config"]["species"][name].get("happiness")]
        out["happiness"] = {
            name: [
                float(f"{v:.5g}") if n else None
                for v, n in zip(r.curves["happiness"][name], r.curves["n"][name], strict=True)
            ]
            for name in feels
        }
        if deep := self.past.depths(tick):
            out["reports"] = out["reports"] | {DEPTH: deep}
        out |= self.past.rates(tick) | {"energy": self.past.energy(tick)} | self.past.flows(tick)
        out["genes"] = self.genes.means(tick) if self.genes.codes and r.births.rows <= GENOMES else {}
        if self.hello()["day"] is not None:
            out["light"] = [round(self.sky(t)[0], 4) for t in tick.tolist()]
        return out

    def organism(self, uid: int) -> Message:
        """Return the state of one organism at this tick; KeyError for one that was never born."""
        state = self.lives.organism(uid, self._tick)
        foods, name = self._foods, state["species"]
        eaters = [eater for eater, eaten in foods.items() if name in eaten]
        return state | {"sentence": sentence(state, foods.get(name, []), eaters)}

    def passed(self) -> None:
        """Do nothing: what passed was recorded."""

    def listed(self, name: str) -> listing.Columns:
        """Return the columns of a species at this tick, in the order of uids."""
        r, organisms = self.recording, self.organisms(name)
        keys = (*listing.STATES, *(f"gene:{gene}" for gene in self.genes.codes.get(name, ())))
        values = {key: self.column(name, organisms, key)[0] for key in keys}
        return (
            {
                "uid": organisms.uid,
                "born": r.born(organisms.uid),
                "family": self.families.roots(organisms.uid),
            }
            | {key: column for key, column in values.items() if column is not None}
            | {axis: getattr(organisms, axis) for axis in "xyz"[: len(r.size)]}
        )

    def handle(self, request: Message) -> list[Message]:
        """Go to a tick, fill in what was not recorded, or say why; interventions are refused."""
        kind = request["kind"]
        if kind == "seek":
            return self._seek(request.get("tick"))
        if kind == "fill":
            return self._fill(request)
        if kind in ("table", "scatter"):
            return [getattr(listing, kind)(self.listed, self.recording.species, request)]
        if kind == "why":
            return [of_run(self.recording.path, self._tick)]
        if kind == "tree":
            return [tree(Recorded(self.recording), self.families, request)]
        if kind == "params":
            return [{"kind": "params", "list": []}]
        how = "ecs-eco resume DIR --from-tick T --set KEY=VALUE --out NEW"
        return [said("warning", f"a recorded run does not change; fork it: {how}", kind)]

    def _seek(self, tick: object) -> list[Message]:
        r = self.recording
        if isinstance(tick, bool) or not isinstance(tick, int | float) or not math.isfinite(tick):
            raise ValueError(f"seek: tick = {str(tick)[:60]}; allowed: a tick from {r.first} to {r.last}")
        self._tick = min(max(round(tick), r.first), r.last)
        return []

    def _fill(self, request: Message) -> list[Message]:
        uid = uid_of(request)
        if self._rerun.busy:
            return [said("info", f"still running: {100 * self._rerun.share:.0f} %", "fill")]
        try:
            died = self.lives.died(uid, self._tick)
        except KeyError:
            raise ValueError(f"fill: no organism of this run has the uid {uid}") from None
        tick = self._tick if died is None else died  # of a dead one its last ticks are wanted
        if any(s.first <= tick <= s.last for s in self.stretches):
            return [self.organism(uid)]
        # its own files and cache: the recording's belong to this thread
        series = self.recording.parts("series", Cache())
        self._rerun.begin(uid, tick, lambda tick: series.between(tick, tick, COMPARED))
        return [said("info", f"running again from the last checkpoint before tick {tick + 1}", "fill")]
