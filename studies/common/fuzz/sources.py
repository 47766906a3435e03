"""Worlds to start from, both as text and as parsed data with few organisms of each species."""

from __future__ import annotations

import copy
import datetime
import importlib.util
import json
import re
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[3]
FEW = 12  # organisms of a species


def sources() -> dict[str, tuple[str, Path | None]]:
    """Return the text of every shipped world and test world, with the folder that its file names are relative
    to."""
    from ecs_eco.config.shipped import shipped

    worlds: dict[str, tuple[str, Path | None]] = {
        name: (path.read_text(encoding="utf-8"), path.parent) for name, path in shipped().items()
    }
    menagerie = _module("tests/conftest.py").MENAGERIE
    herd = copy.deepcopy(_module("tests/worlds/herd.py").HERD)
    goat = herd["species"]["goat"]
    del goat["components"]  # defined by the test
    goat["genome"]["genes"] = [g for g in goat["genome"]["genes"] if g["name"] != "wool"]
    return worlds | {
        "menagerie": (toml(menagerie), None),
        "herd": (toml(_without_none(herd) | {"interventions": DONE}), None),
    }


DONE = [  # to the herd
    {
        "kind": "cull",
        "at": 1,
        "species": "goat",
        "share": 0.2,
        "which": "oldest",
        "region": [15.0, 15.0, 8.0],
    },
    {
        "kind": "add",
        "at": 1,
        "every": 2,
        "until": 4,
        "species": "grass",
        "count": 3,
        "region": [2.0, 2.0, 9.0, 9.0],
    },
    {"kind": "fence", "at": 2, "line": [[5.0, 5.0], [5.0, 20.0]]},
    {"kind": "set", "at": 3, "set": {"species.goat.metabolism.basal": 0.005}},
    {"kind": "switch", "at": 3, "species": "goat", "learning": False},
]


def _module(path: str) -> Any:
    spec = importlib.util.spec_from_file_location(Path(path).stem + "_fuzzed", ROOT / path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _without_none(x: Any) -> Any:
    if isinstance(x, dict):
        return {k: _without_none(v) for k, v in x.items() if v is not None}
    return [_without_none(v) for v in x] if isinstance(x, list) else x


def toml(data: dict[str, Any]) -> str:
    """Return a dict as TOML: scalars first, then a section for each table, and a nested section for each
    table that contains only tables."""
    lines = [f"{_key(k)} = {_value(v)}" for k, v in data.items() if not isinstance(v, dict)]
    for name, section in data.items():
        if not isinstance(section, dict):
            continue
        if section and all(isinstance(v, dict) for v in section.values()):
            for word, part in section.items():
                lines += [
                    "",
                    f"[{_key(name)}.{_key(word)}]",
                    *(f"{_key(k)} = {_value(v)}" for k, v in part.items()),
                ]
        else:
            lines += ["", f"[{_key(name)}]", *(f"{_key(k)} = {_value(v)}" for k, v in section.items())]
    return "\n".join(lines) + "\n"


def _key(key: Any) -> str:
    return (
        key
        if isinstance(key, str) and re.fullmatch(r"[A-Za-z0-9_-]+", key)
        else json.dumps(str(key), ensure_ascii=False)
    )


def _value(x: Any) -> str:
    if isinstance(x, bool):
        return "true" if x else "false"
    if isinstance(x, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in x.items()) + " }"
    if isinstance(x, list):
        return "[" + ", ".join(_value(v) for v in x) + "]"
    if isinstance(x, datetime.date):
        return x.isoformat()
    return json.dumps(x, ensure_ascii=False) if isinstance(x, str) else repr(x)


def parsed(text: str) -> dict[str, Any]:
    """Return a world's text as parsed data, with few organisms."""
    return fewer(tomllib.loads(text))


def fewer(data: dict[str, Any]) -> dict[str, Any]:
    """Return the data with at most FEW organisms of each species and FEW objects of each kind."""
    for group in ("species", "objects"):
        for kind in data.get(group, {}).values():
            if kind.get("count", 0) > FEW:
                kind["count"] = FEW
    return data
