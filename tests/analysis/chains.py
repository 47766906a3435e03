"""Synthetic runs for tests: a noisy Lotka–Volterra chain, and folders with everything a run leaves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

SPECIES = ("grass", "deer", "wolf")
CAUSES = ("eaten by deer", "starved", "eaten by wolf", "too old")


def chain(ticks: int, seed: int = 0, period: float = 250.0, noise: float = 0.015) -> np.ndarray:
    """Numbers (ticks, 3) of a chain around a stable focus, kept cycling by noise: a quasi-cycle.

    The lags are known: deer follow grass by .35 of the period, wolves deer by .28.
    """
    rng = np.random.default_rng(seed)
    decay, turn, z = np.exp(-1 / (2 * period)), np.exp(2j * np.pi / period), 0j
    waves = np.empty(ticks, complex)
    kicks = noise * rng.standard_normal((ticks + int(8 * period), 2)) @ [1, 1j]
    for t, kick in enumerate(kicks):
        z = z * decay * turn + kick
        if t >= int(8 * period):
            waves[t - int(8 * period)] = z
    lags = np.array([0.0, 0.35, 0.63])
    own = np.cumsum(0.004 * rng.standard_normal((ticks, 3)), 0)
    own -= np.linspace(0, 1, ticks)[:, None] * own[-1]
    log = (waves[:, None] * np.exp(-2j * np.pi * lags)).real + 0.5 * own + np.log([6000, 900, 150])
    return np.round(np.exp(log)).astype(np.int64)


def series_table(numbers: np.ndarray, seed: int = 0, species: tuple[str, ...] = SPECIES) -> pa.Table:
    """A series with births, deaths by cause and a ledger that fit the numbers (ticks, species)."""
    rng = np.random.default_rng(seed)
    ticks, s = numbers.shape
    before = np.vstack([numbers[:1], numbers[:-1]])
    births = rng.poisson(0.01 * before) + np.maximum(numbers - before, 0)
    deaths = before + births - numbers
    flat: dict[str, Any] = {"tick": np.repeat(np.arange(ticks), s)}
    flat["species"] = pa.array(np.tile(species, ticks)).dictionary_encode()
    flat |= {
        "n": numbers.astype(np.int32),
        "births": births.astype(np.int32),
        "deaths": deaths.astype(np.int32),
    }
    flat |= {
        "energy_mean": np.full((ticks, s), 0.5, np.float32),
        "happiness_mean": np.full((ticks, s), 0.2, np.float32),
    }
    stock = 0.5 * numbers
    start = 0.5 * before
    lost, endowed, burnt = 0.1 * deaths, 0.3 * births, 0.004 * before
    given = 0.3 * births
    taken = stock - start - endowed + burnt + given + lost
    flat |= {
        "stock_before": start,
        "endowed": endowed,
        "taken_in": taken,
        "burnt": burnt,
        "given": given,
        "lost": lost,
        "stock_after": stock,
    }
    shares = np.array([[1, 0, 0, 0], [0, 0.3, 0.6, 0.1], [0, 0.7, 0, 0.3]])[:s]
    by_cause = np.floor(deaths[..., None] * shares).astype(np.int32)
    by_cause[..., 0] += (shares[:, 0] > 0) * (deaths - by_cause.sum(-1)).astype(np.int32)
    by_cause[..., 1] += (shares[:, 0] == 0) * (deaths - by_cause.sum(-1)).astype(np.int32)
    flat |= {f"died: {cause}": by_cause[..., k] for k, cause in enumerate(CAUSES)}
    return pa.table(
        {k: v if isinstance(v, pa.Array) else pa.array(np.asarray(v).ravel()) for k, v in flat.items()}
    )


def write_run(
    folder: Path, numbers: np.ndarray, seed: int = 1, species: tuple[str, ...] = SPECIES, events: bool = True
) -> Path:
    """A run folder with series in parts, births, deaths and a snapshot."""
    table = series_table(numbers, seed, species)
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "series").mkdir()
    size = 1000 * len(species)
    for k in range(0, max(len(table), 1), size):
        pq.write_table(table.slice(k, size), folder / "series" / f"part-{k // size:05d}.parquet")
    if events and len(table):
        for kind in ("births", "deaths"):
            _events(folder / kind, kind, table, rng)
        at = [(s, n) for s, n in zip(species, numbers[-1], strict=True)]
        who = np.repeat([s for s, _ in at], [n for _, n in at])
        place = {c: pa.array(rng.uniform(0, 160, len(who)).astype(np.float32)) for c in "xy"}
        rest = {
            "z": pa.array(np.zeros(len(who), np.float32)),
            "uid": pa.array(np.arange(1, len(who) + 1, dtype=np.uint64)),
        }
        tick = pa.array(np.full(len(who), len(numbers) - 1))
        (folder / "snapshots").mkdir()
        pq.write_table(
            pa.table(
                {"tick": tick, "species": pa.array(who, pa.string()).dictionary_encode(), **rest, **place}
            ),
            folder / "snapshots" / "part-00000.parquet",
        )
    manifest = {
        "format": 1,
        "world": "predator-prey",
        "title": "Grass, deer and wolves",
        "config": {
            "space": {"size": [160.0, 160.0], "edges": "torus"},
            "species": {name: {} for name in species},
        },
        "config_hash": "0" * 64,
        "seed": seed,
        "ticks": len(numbers),
        "dt": 1.0,
        "versions": {"ecs-eco": "0.1.0"},
        "git_commit": None,
        "species": list(species),
        "colors": {"grass": "#4d9221", "deer": "#b8860b", "wolf": "#67001f"},
        "causes": list(CAUSES),
        "finished": True,
        "wall_seconds": 12.5,
        "compile_seconds": 3.0,
    }
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


def _events(folder: Path, kind: str, series: pa.Table, rng: np.random.Generator) -> None:
    count = series[kind].to_numpy()
    n = int(count.sum())
    species = pa.array(
        np.repeat(np.array(series["species"].cast(pa.string()).to_pylist()), count), pa.string()
    ).dictionary_encode()
    columns = {
        "tick": pa.array(np.repeat(series["tick"].to_numpy(), count)),
        "species": species,
        "uid": pa.array(np.arange(1, n + 1, dtype=np.uint64)),
    }
    columns |= {c: pa.array(rng.uniform(0, 160, n).astype(np.float32)) for c in ("x", "y", "energy")}
    if kind == "deaths":
        columns["age"] = pa.array(np.full(n, 42.0, np.float32))
    folder.mkdir()
    step = max(n // 3, 1)
    for k, start in enumerate(range(0, max(n, 1), step)):
        pq.write_table(pa.table(columns).slice(start, step), folder / f"part-{k:05d}.parquet")
