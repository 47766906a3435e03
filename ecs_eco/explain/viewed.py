"""Sweeps of an explained run for the viewer: entries of its story, and worlds without an allele next to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ecs_eco.ecosystem import World
from ecs_eco.engine.files import read_json
from ecs_eco.explain.edits import Edit
from ecs_eco.view.second import Swept


def sweeps_in(run: str | Path) -> list[Swept]:
    """Return the sweeps in a run's explain.json; none if it does not exist or is damaged."""
    try:
        found = read_json(Path(run) / "explain.json")
        return [_swept(one) for one in found["sweeps"]]
    except (ValueError, KeyError, TypeError):
        return []


def _swept(one: dict[str, Any]) -> Swept:
    entry = {
        "tick": int(one["half"]),
        "kind": "sweep",
        "species": str(one["species"]),
        "n": 0,
        "text": f"{one['lead']} of {one['species']} rose from {one['first']:.0%} to {one['last']:.0%}",
        "cause": " ".join(map(str, one["sentences"][1:])),
        "colour": f"gene:{one['gene']}" if one.get("gene") else "species",
    }
    if one.get("edit") is None:  # no allele was taken out, or by an earlier version
        return Swept(entry)
    edit = Edit(**one["edit"])

    def take_out(world: World) -> None:
        table = world.table(edit.species)
        rows, _ = edit.carriers(table)
        if not rows.size:
            raise ValueError(f"what if: no {edit.species} carries {one['lead']} at this tick")
        edit.apply(table, rows)

    return Swept(entry, f"all {edit.species} lose {one['lead']}", take_out)
