"""Chemotaxis in a recorded run: how often animals move down the gradient that they smell."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.depth import is_night
from ecs_eco.analysis.runs import load_series, tables
from ecs_eco.analysis.tracks import Box, shortest


@dataclass(frozen=True)
class Leaving:
    """How often moves lead down the gradient of a smell: (N down − N up)/N,
    of all moves and of those at night."""

    n: int
    index: float
    n_night: int
    night: float


def noses(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(species, channels without their directions) of noses that compare two sides, of species with details."""
    kinds = {
        k.removeprefix("details-")
        for k, n in manifest.get("parts", {}).items()
        if k.startswith("details-") and n
    }
    known = {
        name: species.get("sensors", ())
        for name, species in manifest["config"]["species"].items()
        if name in kinds
    }
    return [
        (name, s.get("name") or f"{s['field']}_gradient")
        for name, all_ in known.items()
        for s in all_
        if s["kind"] == "gradient"
    ]


def leaving(run: Path | str, species: str, nose: str, least: float = 0.1, most: int = 3000) -> Leaving | None:
    """How often a species moves away from a smell, in the last `most` ticks of a run with details, where the
    nose measures a gradient above `least` (of at most 1) at the beginning of the tick; None if nothing was
    smelt."""
    series = load_series(run)
    names = [
        "tick",
        "uid",
        "x",
        "y",
        "z",
        "heading",
        *(f"sensor: {nose}_{way}" for way in ("forward", "left", "up")),
    ]
    blocks = [[rows[name].to_numpy() for name in names] for rows in tables(run, f"details-{species}", names)]
    if not blocks:
        return None
    tick, uid, *columns = (np.concatenate(column) for column in zip(*blocks, strict=True))
    order = np.lexsort((tick, uid))
    order = order[tick[order] > int(series.ticks[-1]) - most]
    before, after = order[:-1], order[1:]
    # places are those of the end of a tick
    both = (uid[before] == uid[after]) & (tick[after] - tick[before] == 1)
    before, after = before[both], after[both]
    x, y, z, heading, forward, left, up = (np.asarray(c, float) for c in columns)
    way = shortest(Box.of(series), np.stack([c[after] - c[before] for c in (x, y, z)], 1))
    cos, sin = np.cos(heading[before]), np.sin(heading[before])
    along = (
        (way[:, 0] * cos + way[:, 1] * sin) * forward[after]
        + (way[:, 1] * cos - way[:, 0] * sin) * left[after]
        + way[:, 2] * up[after]
    )
    felt = (np.sqrt(forward**2 + left**2 + up**2)[after] > least) & (along != 0)
    night = is_night(series, tick[after])
    if not felt.any():
        return None
    down, dark = along < 0, felt & night
    of = [
        (int(moves.sum()), float(2 * down[moves].mean() - 1) if moves.any() else float("nan"))
        for moves in (felt, dark)
    ]
    return Leaving(*of[0], *of[1])
