"""The `ecs-eco why` diagnosis for the viewer page."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.compare import clean
from ecs_eco.analysis.runs import load_series
from ecs_eco.analysis.why import Case, explain, sentences
from ecs_eco.analysis.why.case import in_force
from ecs_eco.ecosystem import World
from ecs_eco.view.journal import Journal
from ecs_eco.view.source import Message

REMEMBERED = 20  # blocks of 1,000 ticks kept by the recorder of a live world


def of_run(folder: Path, tick: int) -> Message:
    """Return the diagnosis of an entire recorded run: {"kind": "why", …}."""
    return _told(Case.read(folder), tick)


def of_world(world: World, journal: Journal) -> Message:
    """Return the diagnosis of a live world for the ticks that its recorder still keeps."""
    if world.recorder is None or world.config is None:
        return _nothing(world.tick, "This world is not recorded, so there is nothing to diagnose.")
    series = load_series(world.recorder.series())
    if len(series.ticks) < 2:
        return _nothing(world.tick, "A diagnosis needs at least two recorded ticks.")
    manifest = {
        "config": world.config.model_dump(mode="json"),
        "intervened": list(world.intervened),
        "dt": world.dt,
        "species": list(series.species),
    }
    known = replace(series, manifest=manifest)
    config = in_force(manifest)
    animals = [name for name, values in config["species"].items() if values.get("diet")]
    return _told(Case(known, config, _deaths(journal, animals)), world.tick)


def _deaths(journal: Journal, names: Sequence[str]) -> dict[str, dict[str, np.ndarray]]:
    """Return the tick, age [s] and cause of each known death, by species."""
    columns = journal.deaths.between(-1, journal.world.tick, ("species", "age", "cause"))
    words, out = np.array(["unknown", *journal.causes]), {}
    for name in names:
        rows = np.flatnonzero(columns["species"] == journal.species.index(name))
        if rows.size:
            cause = words[columns["cause"][rows].astype(np.int64) + 1]
            out[name] = {"tick": columns["tick"][rows], "age": columns["age"][rows], "cause": cause}
    return out


def _nothing(tick: int, text: str) -> Message:
    return {"kind": "why", "tick": tick, "first": tick, "sections": {"What happened": [text]}, "turns": []}


def _told(case: Case, tick: int) -> Message:
    with np.errstate(all="ignore"):
        findings = explain(case)
    sections: Mapping[str, Any] = sentences(case, findings)
    ticks, turns = case.series.ticks, clean(findings["parameters"])
    return {
        "kind": "why",
        "tick": tick,
        "first": int(ticks[0]) if len(ticks) else 0,
        "sections": {head: list(lines) for head, lines in sections.items() if head != "What to change"},
        "turns": [{key: t[key] for key in ("key", "value", "turn", "effect")} for t in turns],
    }
