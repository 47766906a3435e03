"""The record of one organism at a tick: the viewer's panel in a replay."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.view.genealogy import Genealogy
from ecs_eco.view.inspect import SEXES, action, copies_found, marked, nothing_of, number
from ecs_eco.view.parts import Columns
from ecs_eco.view.recording import Recording
from ecs_eco.view.rerun import Stretch

KEPT = 64  # lives kept in memory
TRACED = 300  # ticks before this one in the trace, if every tick was recorded


class Life(NamedTuple):
    """The facts of a life that do not depend on the tick."""

    message: dict[str, Any]  # the constant part of the message
    species: str
    born: int
    died: int | None
    birth: dict[str, Any]
    seen: Columns  # its rows in the snapshots


class Lives:
    """The lives of the organisms of a recording; `stretches` are the intervals that were rerun."""

    def __init__(self, recording: Recording, genealogy: Genealogy, stretches: list[Stretch]) -> None:
        self.recording, self.genealogy, self.stretches = recording, genealogy, stretches
        self._config: dict[str, Any] = recording.manifest["config"]["species"]
        self.life = lru_cache(KEPT)(self._read)

    def organism(self, uid: int, tick: int) -> dict[str, Any]:
        """Return the message "organism" at a tick; raise KeyError if the organism was never born.

        `detail` is "full" if readings and decision are known, "snapshot" if the state is from the nearest
        snapshot, and "record" if only birth and death are known; `note` explains it. For a dead organism,
        this is its last known state, at tick `as_of`.
        """
        life = self.life(uid)
        out = life.message | {"alive": life.born <= tick and (life.died is None or tick < life.died)}
        out |= {
            "age": number(
                max(0, min(tick, tick if life.died is None else life.died) - life.born) * self.recording.dt
            )
        }
        if (died := self.died(uid, tick)) is not None:
            return out | self._last(life, uid, died)
        detail = self._detail(life, uid, tick)
        return out | (self._nearest(life, tick, bool(out["alive"])) if detail is None else detail)

    def died(self, uid: int, tick: int) -> int | None:
        """Return the tick of its death, or None if it was not dead by the end of this tick."""
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
                "energy_max": self._config[species]["metabolism"]["energy_max"],
            }
        )
        died = None if death is None else int(death["tick"])
        seen = self._seen(uid, max(born, r.first), r.last if died is None else died)
        return Life(message, species, born, died, birth, seen)

    def _seen(self, uid: int, first: int, last: int) -> Columns:
        names = ("tick", "uid", "x", "y", "z", "heading", "energy", "happiness")
        blocks: list[Columns] = []
        for group in self.recording.snapshots.groups:
            if group.ticks[0] <= last and group.ticks[1] >= first:
                at = self.recording.snapshots.read(group, ("uid",))["uid"] == uid
                if at.any():
                    blocks.append(
                        {n: column[at] for n, column in self.recording.snapshots.read(group, names).items()}
                    )
        return {n: np.concatenate([f[n] for f in blocks]) if blocks else np.zeros(0) for n in names}

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
        if known is None:
            return None
        if known.get("longest"):
            return copies_found(known, text)
        length = len(text) // known["ploidy"]
        genes = [
            {
                "name": g["name"],
                "trait": g["trait"],
                "from": g["at"],
                "to": g["at"] + g["letters"],
                "value": None,
            }
            for g in known["genes"]
        ]
        strings = [text[s * length : (s + 1) * length] for s in range(known["ploidy"])]
        return {"alphabet": known["alphabet"], "strings": strings, "genes": genes}

    def _detail(self, life: Life, uid: int, tick: int) -> dict[str, Any] | None:
        """Return the state at a tick from details, recorded or rerun; None if there are none."""
        detail = self._found(life, uid, tick)
        if detail is not None and not self._config[life.species].get("happiness"):
            detail["trace"]["happiness"] = [None] * len(detail["trace"]["tick"])
            detail["nerves"] = detail.get("nerves") and detail["nerves"] | {"happiness": None, "reward": None}
        return detail

    def _found(self, life: Life, uid: int, tick: int) -> dict[str, Any] | None:
        for stretch in reversed(self.stretches):
            if stretch.first <= tick <= stretch.last:
                columns = stretch.details.get(life.species)
                note = f"Rerun from a checkpoint, ticks {stretch.first} to {stretch.last}."
                row = None if columns is None else _row(columns, uid, tick)
                if row is not None and columns is not None:
                    sex = stretch.sexes.get(uid)
                    trace = _trace(columns, uid, tick)
                    return _full(row, trace, note) | ({} if sex is None else {"sex": SEXES[sex]})
                state = _row(stretch.states, uid, tick)
                if state is not None:
                    senses = self._config[life.species].get("actions")
                    note += " It has not sensed anything yet." if senses else ""
                    return _state(state, _trace(stretch.states, uid, tick)) | {"detail": "full", "note": note}
        parts = self.recording.details[life.species]
        if not parts.rows:
            return None
        names = [n for group in parts.groups[:1] for n in group.names]
        columns = parts.between(tick, tick, names)
        if (row := _row(columns, uid, tick)) is None:
            return None
        trace = _trace(parts.between(tick - TRACED, tick, ("uid", "happiness", "energy")), uid, tick)
        return _full(row, trace, "")

    def _last(self, life: Life, uid: int, died: int) -> dict[str, Any]:
        """Return the last state of a dead organism: in its last tick if details exist, otherwise in its last
        snapshot."""
        for tick in (died, died - 1):  # details of its last tick may be missing
            if tick >= life.born and (detail := self._detail(life, uid, tick)) is not None:
                note = f"State in its last tick, {tick:,}. {detail['note']}".rstrip()
                return detail | {"as_of": tick, "note": note}
        trace = self._trace(life, died)
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

    def _trace(self, life: Life, tick: int) -> dict[str, list[Any]]:
        """Return its trace up to a tick, from snapshots."""
        so_far = life.seen["tick"] <= tick
        trace = {n: [number(v) for v in life.seen[n][so_far]] for n in ("happiness", "energy")}
        if not self._config[life.species].get("happiness"):
            trace["happiness"] = [None] * len(trace["energy"])
        return {"tick": [int(t) for t in life.seen["tick"][so_far]], **trace}

    def _without(self, life: Life) -> str:
        """Return a phrase for what snapshots lack."""
        thinks = self._config[life.species].get("actions")
        return ", without its nervous system" if thinks else ""

    def _nearest(self, life: Life, tick: int, alive: bool) -> dict[str, Any]:
        """Return the state in the nearest snapshot, or at birth."""
        seen, every = life.seen, self.recording.every
        out: dict[str, Any] = {"trace": self._trace(life, tick)}
        if not alive:
            return out | {"detail": "record", "note": "Not born yet."}
        fill = "“Fill in” reruns the ticks around this one."
        near = int(np.argmin(np.abs(seen["tick"] - tick))) if seen["tick"].size else -1
        # nothing was recorded at this tick, nor closer to it than the birth
        if near < 0 or (seen["tick"][near] != tick and abs(seen["tick"][near] - tick) >= tick - life.born):
            b = life.birth
            state = {"place": [number(b[axis]) for axis in "xyz"], "energy": number(b["energy"])}
            return out | state | {"detail": "record", "note": f"State at birth, tick {life.born}. {fill}"}
        row = {n: column[near] for n, column in seen.items()}
        when = "" if row["tick"] == tick else f"State at tick {int(row['tick'])}. "
        return (
            out
            | _state(row, out["trace"])
            | {
                "detail": "snapshot",
                "note": f"{when}Recorded every {every} ticks{self._without(life)}. {fill}",
            }
        )


def _row(columns: Columns, uid: int, tick: int) -> dict[str, Any] | None:
    at = np.flatnonzero((columns["uid"] == uid) & (columns["tick"] == tick))
    return {n: column[at[0]] for n, column in columns.items()} if at.size else None


def _trace(columns: Columns, uid: int, tick: int) -> dict[str, list[Any]]:
    at = np.flatnonzero((columns["uid"] == uid) & (columns["tick"] <= tick))
    return {
        "tick": columns["tick"][at].tolist(),
        **{n: [number(v) for v in columns[n][at]] for n in ("happiness", "energy")},
    }


def _state(row: dict[str, Any], trace: dict[str, list[Any]]) -> dict[str, Any]:
    place = [number(row[axis]) for axis in "xyz"]
    return {
        "place": place,
        "heading": number(row["heading"]),
        "energy": number(row["energy"]),
        "trace": trace,
    }


def _full(row: dict[str, Any], trace: dict[str, list[Any]], note: str) -> dict[str, Any]:
    """Return a row of details in the form of the message."""
    actions = [name.removeprefix("decision: ") for name in row if name.startswith("decision: ")]
    nerves = {
        "sensors": [
            {"name": n.removeprefix("sensor: "), "value": number(v)}
            for n, v in row.items()
            if n.startswith("sensor: ")
        ],
        "actions": [
            action(
                a.partition(".")[0],
                a.partition(".")[2],
                row[f"reflex: {a}"],
                row.get(f"probability: {a}"),
                row[f"chosen: {a}"],
                row[f"decision: {a}"],
                isinstance(row[f"decision: {a}"], float | np.floating),
            )
            for a in actions
        ],
        "happiness": number(row["happiness"]),
        "reward": number(row["reward"]),
    }
    return _state(row, trace) | {"nerves": nerves, "detail": "full", "note": note}
