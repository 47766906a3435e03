"""The record of one organism at a tick, for the viewer's panel in a replay."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.view.genealogy import Genealogy
from ecs_eco.view.inspect import SEXES, described, marked, nothing_of, number, recorded_genome
from ecs_eco.view.parts import Blocks, Columns
from ecs_eco.view.recording import Recording
from ecs_eco.view.rerun import Stretch

KEPT = 64  # lives kept in memory
TRACED = 300  # earlier ticks in the trace, if every tick was recorded


class Life(NamedTuple):
    """The facts of a life that do not depend on the tick."""

    message: dict[str, Any]  # the constant part of the message
    species: str
    born: int
    died: int | None
    birth: dict[str, Any]
    seen: Columns  # the organism's rows in the snapshots


class Lives:
    """The lives of the organisms in a recording; `stretches` are intervals that were rerun."""

    def __init__(self, recording: Recording, genealogy: Genealogy, stretches: list[Stretch]) -> None:
        self.recording, self.genealogy, self.stretches = recording, genealogy, stretches
        self._config: dict[str, Any] = recording.manifest["config"]["species"]
        self.life = lru_cache(KEPT)(self._read)

    def organism(self, uid: int, tick: int) -> dict[str, Any]:
        """Return the message "organism" at a tick; raise KeyError if the organism was never born. `detail` is
        "full" with readings and a decision, "snapshot" if the nearest one gives the state, otherwise "record".
        A dead organism has its last known state, at tick `as_of`."""
        life = self.life(uid)
        died = self.died(uid, tick)
        alive = life.born <= tick and died is None
        age = max(0, (tick if died is None else died) - life.born) * self.recording.dt
        out = life.message | {"alive": alive, "age": number(age)}
        if died is not None:
            out |= self._last(life, uid, died)
        else:
            out |= self._detail(life, uid, tick) or self._nearest(life, tick, alive)
        if not self._config[life.species].get("happiness"):
            out["trace"] = out["trace"] | {"happiness": [None] * len(out["trace"]["tick"])}
            out["nerves"] = out["nerves"] and out["nerves"] | {"happiness": None, "reward": None}
        return out

    def died(self, uid: int, tick: int) -> int | None:
        """Return the tick of an organism's death, or None if it was alive or unborn at the end of `tick`."""
        died = self.life(uid).died
        return None if died is None or tick < died else died

    def _read(self, uid: int) -> Life:
        """Return the facts of an organism's life."""
        r = self.recording
        birth = self.genealogy.birth(uid, ("x", "y", "z", "energy", "genome"))
        if birth is None:
            raise KeyError(f"no organism of this run has the uid {uid}")
        facts = self.genealogy.facts(uid)
        species, born, death = facts["species"], facts["born"], facts["died"]
        message = nothing_of(
            {
                "uid": uid,
                **facts,
                "note": "",
                "genome": self._genome(species, birth["genome"]),
                "energy_max": r.energy_max(species),
            }
        )
        died = None if death is None else int(death["tick"])
        names = ("uid", "x", "y", "z", "heading", "energy", "happiness")
        seen = r.snapshots.between(max(born, r.first), r.last if died is None else died, names, uid)
        return Life(message, species, born, died, birth, seen)

    def _genome(self, species: str, text: object) -> dict[str, Any] | None:
        r = self.recording
        if not isinstance(text, str) or not text:
            return None
        if (
            r.scene is not None
            and (heredity := r.scene.tables[species].species.heredity) is not None
            and heredity.layout is not None
        ):
            return marked(heredity.layout, heredity.layout.rows([text])[0])
        known = r.manifest.get("genomes", {}).get(species)
        return None if known is None else recorded_genome(known, text)

    def _detail(self, life: Life, uid: int, tick: int) -> dict[str, Any] | None:
        """Return the state at a tick from recorded or rerun details, or None if there are none."""
        for stretch in reversed(self.stretches):
            if stretch.first <= tick <= stretch.last:
                note = f"Rerun from a checkpoint, ticks {stretch.first} to {stretch.last}."
                details = stretch.details.get(life.species)
                if details is not None and (state := _at(details, uid, tick)) is not None:
                    sex = stretch.sexes.get(uid)
                    return state | {"note": note} | ({} if sex is None else {"sex": SEXES[sex]})
                if (state := _at(stretch.states, uid, tick)) is not None:
                    senses = self._config[life.species].get("actions")
                    return state | {"note": note + (" It has not sensed anything yet." if senses else "")}
        return _at(self.recording.details[life.species], uid, tick)

    def _last(self, life: Life, uid: int, died: int) -> dict[str, Any]:
        """Return the last state of a dead organism: of its last tick if recorded, else of its last snapshot."""
        for tick in (died, died - 1):  # details of the last tick may be missing
            if tick >= life.born and (detail := self._detail(life, uid, tick)) is not None:
                note = f"State in its last tick, {tick:,}. {detail['note']}".rstrip()
                return detail | {"as_of": tick, "note": note}
        trace = _trace(life.seen, died)
        fill = "“Fill in” reruns its last ticks."
        if not life.seen["tick"].size:
            return {
                "trace": trace,
                "detail": "record",
                "note": f"The run recorded nothing between its birth and its death. {fill}",
            }
        row = {name: column[-1] for name, column in life.seen.items()}
        as_of = int(row["tick"])
        return _state(row, trace) | {
            "detail": "snapshot",
            "as_of": as_of,
            "note": f"State at tick {as_of:,}, in its last snapshot{self._without(life)}. {fill}",
        }

    def _without(self, life: Life) -> str:
        """Return a phrase that names the data missing from snapshots."""
        thinks = self._config[life.species].get("actions")
        return ", without the nervous system" if thinks else ""

    def _nearest(self, life: Life, tick: int, alive: bool) -> dict[str, Any]:
        """Return the state in the nearest snapshot, or at birth."""
        seen, every = life.seen, self.recording.every
        out: dict[str, Any] = {"trace": _trace(life.seen, tick)}
        if not alive:
            return out | {"detail": "record", "note": "Not born yet."}
        fill = "“Fill in” reruns the ticks around this one."
        near = int(np.argmin(np.abs(seen["tick"] - tick))) if seen["tick"].size else -1
        # no snapshot is at this tick or closer to it than the birth is
        if near < 0 or (seen["tick"][near] != tick and abs(seen["tick"][near] - tick) >= tick - life.born):
            b = life.birth
            state = {"place": [number(b[axis]) for axis in "xyz"], "energy": number(b["energy"])}
            return out | state | {"detail": "record", "note": f"State at birth, tick {life.born:,}. {fill}"}
        row = {n: column[near] for n, column in seen.items()}
        when = "" if row["tick"] == tick else f"State at tick {int(row['tick']):,}. "
        return (
            out
            | _state(row, out["trace"])
            | {
                "detail": "snapshot",
                "note": f"{when}Recorded every {every} ticks{self._without(life)}. {fill}",
            }
        )


def _at(blocks: Blocks, uid: int, tick: int) -> dict[str, Any] | None:
    """Return an organism's state at a tick from details or snapshots of every tick, or None if it is missing."""
    names = [name for group in blocks.groups[:1] for name in group.names]
    columns = blocks.between(tick, tick, names, uid)
    if not columns["tick"].size:
        return None
    row = {name: column[0] for name, column in columns.items()}
    trace = _trace(blocks.between(tick - TRACED, tick, ("happiness", "energy"), uid), tick)
    nerves = {"nerves": _nerves(row)} if "reward" in row else {}
    return _state(row, trace) | nerves | {"detail": "full", "note": ""}


def _trace(columns: Columns, tick: int) -> dict[str, list[Any]]:
    """Return an organism's trace up to a tick."""
    rows = columns["tick"] <= tick
    values = {name: [number(value) for value in columns[name][rows]] for name in ("happiness", "energy")}
    return {"tick": [int(at) for at in columns["tick"][rows]], **values}


def _state(row: dict[str, Any], trace: dict[str, list[Any]]) -> dict[str, Any]:
    state = {"place": [number(row[axis]) for axis in "xyz"], "trace": trace}
    return state | {name: number(row[name]) for name in ("heading", "energy")}


def _nerves(row: dict[str, Any]) -> dict[str, Any]:
    """Return the nervous system in a row of details."""
    kinds: dict[str, dict[str, Any]] = {
        kind: {name.removeprefix(kind): value for name, value in row.items() if name.startswith(kind)}
        for kind in ("sensor: ", "reflex: ", "probability: ", "chosen: ", "decision: ")
    }
    sensors, reflex, probability, chosen, decision = kinds.values()
    actions = (
        (*a.split(".", 1), reflex[a], probability.get(a), chosen[a], done, isinstance(done, np.floating))
        for a, done in decision.items()
    )
    return described(sensors.items(), actions, row["happiness"], row["reward"])
