"""The outcome for one mutated world file: refused, run for some ticks, or failed."""

from __future__ import annotations

import random
import re
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.fuzz.guard import guarded
from studies.common.fuzz.mutations import mutate_text, mutate_values
from studies.common.fuzz.sources import FEW, parsed, sources, toml

TICKS = 5
SMALL = {"cells": 2_000, "hidden": 32}  # limits to which accepted worlds are reduced before they run
WORDS = (  # kinds of problem by message; the first match counts
    ("not TOML", "not TOML"),
    ("not text", "cannot be read"),
    ("missing", "is missing|is empty"),
    ("unknown key", "unknown key"),
    ("wrong type", "wrong type"),
    ("not finite", "not a finite number"),
    ("out of range", "out of range|not of this form"),
    (
        "unknown name",
        "no .* with this name|has no such|no such|unknown|cannot be imported|has no function|no "
        "component|no system",
    ),
    ("formula", "at character"),
    ("not a name", "not a name|reserved word"),
)


def tried(chunk: dict[str, Any], files: int) -> dict[str, Any]:
    """Return outcome counts by kind for one chunk of mutated world files, and details of the failures."""
    folder = Path(tempfile.mkdtemp(prefix="ecs-eco-fuzz-"))
    items = [
        (chunk["source"], chunk["what"], chunk["seed"] * 1_000_000 + i, str(folder)) for i in range(files)
    ]
    try:
        _warm(chunk["source"])
        outcomes = list(guarded(judge, items, seconds=10.0))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return counted(outcomes, items)


def counted(outcomes: list[dict[str, Any]], items: list[Any]) -> dict[str, Any]:
    """Return outcome counts by kind, problem counts by kind, and the failures with the items that caused
    them."""
    kinds: dict[str, int] = {}
    problems: dict[str, int] = {}
    failures = []
    for item, one in zip(items, outcomes, strict=True):
        kinds[one["kind"]] = kinds.get(one["kind"], 0) + 1
        for word, n in one.get("problems", {}).items():
            problems[word] = problems.get(word, 0) + n
        if one["kind"] in FAILURES:
            failures.append({"item": [str(x) for x in item[:3]], **one})
    return {"files": len(items), "kinds": kinds, "problems": problems, "failures": failures}


FAILURES = ("traceback", "hang", "crash", "no location", "not finite", "wrong load", "warning")


@cache
def _text(source: str) -> tuple[str, Path | None]:
    return sources()[source]


def _warm(source: str) -> None:
    """Run the unchanged world in this process, so that child processes inherit its compiled kernels."""
    from ecs_eco import World

    text, home = _text(source)
    data = parsed(text)
    for species in data["species"].values():
        if species.get("policy", {}).get("kind") == "shared":
            species["policy"]["learn"] = True
        if home is not None and "file" in species.get("policy", {}):
            species["policy"]["file"] = str(home / species["policy"]["file"])
    World.from_config(data).run(TICKS)


def written(source: str, what: str, seed: int, folder: Path) -> Any:
    """Return the mutated world: a path in `folder` or, for every second world with changed values, a dict."""
    text, home = _text(source)
    chance = random.Random(seed)
    for path in home.glob("*.safetensors") if home is not None else ():
        if not (folder / path.name).exists():
            shutil.copy(path, folder)
    if what == "text":
        raw = mutate_text(text, chance)
    else:
        data = mutate_values(parsed(text), chance)
        if chance.random() < 0.3:
            return data
        raw = toml(data).encode()
    (folder / "world.toml").write_bytes(raw)
    return folder / "world.toml"


def judge(item: tuple[str, str, int, str]) -> dict[str, Any]:
    """Return the kind of outcome for a file, with details."""
    import traceback

    from ecs_eco.config import load
    from ecs_eco.engine.errors import ConfigError

    source, what, seed, folder = item
    stage = "load"
    try:
        world = written(source, what, seed, Path(folder))
        try:
            config = load(world)
        except ConfigError as error:
            return _refused(error)
        stage = "build"
        return _run(config)
    except Warning as warning:
        return {
            "kind": "warning",
            "stage": stage,
            "said": traceback.format_exc()[-1500:],
            "name": str(warning)[:100],
        }
    except MemoryError as error:
        return {"kind": "too little memory", "said": str(error)[:200]}
    except FloatingPointError as error:
        return {"kind": "non-finite number, reported", "said": str(error)[:200]}
    except Exception:
        return {"kind": "traceback", "stage": stage, "said": traceback.format_exc()[-1500:]}


def _refused(error: Any) -> dict[str, Any]:
    problems: dict[str, int] = {}
    for p in error.problems:
        word = next((word for word, pattern in WORDS if re.search(pattern, p.what)), "does not fit")
        problems[word] = problems.get(word, 0) + 1
        if not (p.key or p.line or p.what.startswith("cannot be read")) or not p.what or not str(p):
            return {"kind": "no location", "said": str(p)[:500]}
    return {"kind": "refused", "problems": problems}


def _run(config: Any) -> dict[str, Any]:
    """Run a small version of an accepted world."""
    from ecs_eco import World
    from ecs_eco.config import load
    from ecs_eco.engine.errors import ConfigError

    try:
        config = load(config, _less(config))
        world = World.from_config(config).run(TICKS)
    except ConfigError as error:
        return _refused(error) | {"kind": "refused while building"}
    wrong = odd(world)
    return {"kind": "not finite", "said": ", ".join(wrong)} if wrong else {"kind": f"ran {TICKS} ticks"}


def _less(config: Any) -> dict[str, Any]:
    """Return values that make an accepted world small enough to run in milliseconds without hiding any
    error."""
    less: dict[str, Any] = {}
    for group in ("species", "objects"):
        less |= {
            f"{group}.{name}.count": FEW for name, kind in getattr(config, group).items() if kind.count > FEW
        }
    less |= {
        f"interventions.{i}.count": FEW
        for i, w in enumerate(config.interventions)
        if w.kind == "add" and w.count > FEW
    }
    side = min(config.space.size[:2]) / 10
    for name, field in config.fields.items():
        if np.prod([s / field.cell for s in config.space.size]) > SMALL["cells"]:
            less[f"fields.{name}.cell"] = side
    if (
        config.terrain is not None
        and np.prod([s / config.terrain.cell for s in config.space.size[:2]]) > SMALL["cells"]
    ):
        less["terrain.cell"] = side
    for name, species in config.species.items():
        if any(n > SMALL["hidden"] for n in species.policy.hidden) and not species.policy.file:
            less[f"species.{name}.policy.hidden"] = [min(n, SMALL["hidden"]) for n in species.policy.hidden]
        for word in ("epochs", "horizon", "minibatch"):
            if species.ppo.get(word, 0) > 64:
                less[f"species.{name}.ppo.{word}"] = 64
    return less


def odd(world: Any) -> list[str]:
    """Return the columns in which living organisms have non-finite numbers."""
    wrong = []
    for table in world.tables.values():
        rows = table.rows()
        for component, columns in table.columns.items():
            for name, column in vars(columns).items():
                values = column[rows]
                if values.dtype.kind == "f" and not np.isfinite(values).all():
                    wrong.append(f"{table.name}: {component.__name__}.{name}")
    wrong += [f"field {name}" for name, field in world.fields.items() if not np.isfinite(field.value).all()]
    return wrong
