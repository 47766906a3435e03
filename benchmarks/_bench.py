"""Code shared by the benchmarks: a description of the machine, timing, results as JSON, and a world of a
given size."""

import json
import math
import os
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).parent / "results"


def pin_threads() -> None:
    """Limit every library to one thread; call this before importing numpy."""
    for name in (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "NUMBA_NUM_THREADS",
        "POLARS_MAX_THREADS",
    ):
        os.environ[name] = "1"


def machine() -> dict[str, Any]:
    """Describe the processor, its cores, its load before the benchmark, and the versions in use."""
    from ecs_eco.engine.versions import versions
    from ecs_eco.record.folder import git_commit

    model = "unknown"
    if Path("/proc/cpuinfo").exists():
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        model = next(
            (line.split(":")[1].strip() for line in lines if line.startswith("model name")),
            platform.machine(),
        )
    return {
        "processor": model,
        "cores": os.cpu_count(),
        "load": round(os.getloadavg()[0], 2),
        "versions": versions(),
        "commit": git_commit(),
    }


def best_of(work: Callable[[], None], repeats: int = 5) -> float:
    """Return the shortest of several timings [s], the one that other work disturbed least."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def save(name: str, question: str, rows: list[dict[str, Any]], notes: dict[str, Any] | None = None) -> None:
    """Print a table and write benchmarks/results/<name>.json."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=question)
    for column in rows[0]:
        table.add_column(column)
    for row in rows:
        table.add_row(*(f"{v:.4g}" if isinstance(v, float) else str(v) for v in row.values()))
    Console(width=160).print(table)
    RESULTS.mkdir(exist_ok=True)
    content = {"question": question, "rows": rows, "notes": notes or {}, "machine": machine()}
    (RESULTS / f"{name}.json").write_text(json.dumps(content, indent=1) + "\n")


SMELLS = "plant_smell", "grazer_smell", "hunter_smell"


def savanna(animals: int, plants_per_animal: float = 1.6, **space: Any) -> dict[str, Any]:
    """Return the configuration of a world with this many animals, 15% of which hunt, and an area proportional
    to their number.

    Each animal has 24 observations: the nearest of three kinds (a grazer has about 14 neighbors within
    range), three smells with two nostrils, and nine more about its own body and surroundings.
    """
    grazers, hunters, plants = (
        round(animals * 0.85),
        round(animals * 0.15),
        round(animals * plants_per_animal),
    )
    side = math.sqrt(animals / 0.045)
    return {
        "format": 1,
        "name": "savanna",
        "dt": 1.0,
        "space": {"size": [side, side], "edges": "torus", **space},
        "fields": {f: {"cell": 4.0, "diffusion": 1.0, "decay": 0.2} for f in SMELLS},
        "species": {
            "plant": {
                "count": plants,
                "body": {"radius": 0.4, "opaque": False},
                "metabolism": {"energy": 0.2, "energy_max": 0.2},
                "emits": {"plant_smell": 0.1},
                "reproduction": {"kind": "spread", "rate": 0.02, "seed_rain": 0.015, "spacing": 3.0},
            },
            "grazer": _animal(grazers, "plant", "grazer_smell", 1.0),
            "hunter": _animal(hunters, "grazer", "hunter_smell", 1.2),
        },
    }


def _animal(count: int, eats: str, smell: str, speed: float) -> dict[str, Any]:
    return {
        "count": count,
        "body": {"radius": 0.5},
        "metabolism": {"energy": 0.6, "basal": 0.003},
        "emits": {smell: 1.0},
        "properties": {"temperature": 311.0, "luminous_intensity": 0.0, "electric_current": 0.0},
        "locomotion": {
            "speed": {"still": 0.0, "walk": 0.5, "run": speed},
            "cost": {"walk": 0.004, "run": 0.02},
            "turn": 0.6,
        },
        "diet": [{"eats": eats, "reach": 0.5, "chance": 0.5, "gain": 0.2}],
        "sensors": _senses(),
        "actions": {"speed": ["still", "walk", "run"], "turn": ["left", "none", "right"], "eat": ["eat"]},
        "default_action": {"speed": "still", "turn": "none"},
        "always_on": ["eat"],
        "happiness": {"formula": "energy - 0.2 * hunter_smell", "minimum": -1.0},
        "policy": {"kind": "shared", "hidden": [64, 64]},
        "ppo": {"horizon": 64, "epochs": 3, "learning_rate": 1e-3},
        "lethal": [
            {"property": "energy", "min": 0.0, "cause_below": "starved"},
            {"property": "age", "max": 3000.0, "cause_above": "too old"},
        ],
    }


def _senses() -> list[dict[str, Any]]:
    return [
        {"kind": "nearest", "target": "plant", "range": 6.0},
        {"kind": "nearest", "target": "grazer", "range": 6.0},
        {"kind": "nearest", "target": "hunter", "range": 12.0},
        *({"kind": "smell", "field": f, "at": [1.0, side]} for f in SMELLS for side in (0.5, -0.5)),
        {"kind": "own", "property": "energy"},
        {"kind": "own", "property": "age", "scale": 1000.0},
        {"kind": "own", "property": "fertility"},
        {"kind": "own", "property": "temperature", "scale": 300.0},
        {"kind": "light"},
        {"kind": "temperature", "zero": 285.0},
        {"kind": "pressure", "zero": 1e5, "scale": 1e4},
        {"kind": "own", "property": "luminous_intensity", "name": "glow"},
        {"kind": "own", "property": "electric_current", "name": "charge"},
    ]
