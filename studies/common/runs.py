"""Code shared by studies of recorded runs: small versions of worlds, and a run folder's content regardless of
how it is divided into parts."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

KINDS = ("series", "births", "deaths", "snapshots")


def small(name: str, share: float = 0.25, kind: str | None = None) -> dict[str, Any]:
    """Return a shipped world with a share of its organisms on the same share of its area; policies start
    untrained and learn.

    `kind`, "individual" or "shared", applies to all policies.
    """
    from ecs_eco.config import load

    config = load(name).resolved()
    config["space"]["size"] = [s * share**0.5 for s in config["space"]["size"]]
    for species in config["species"].values():
        species["count"] = max(4, round(species["count"] * share))
        policy = species["policy"]
        if policy["kind"] == "none":
            continue
        policy["file"] = None
        if kind is not None:
            policy |= {"kind": kind, "hidden": [12]}
            species["ppo"] |= {"horizon": 16, "epochs": 2, "minibatch_size": 2048}
        if policy["kind"] != "individual":
            policy |= {"inherit": "none", "mutation_sd": 0.0}
    return config


def content(folder: Path) -> str:
    """Return a hash of everything a run recorded: rows and columns of each kind in order, however they are
    divided into parts."""
    from ecs_eco.record.parquet import read_parts

    digest = hashlib.sha256()
    for kind in KINDS:
        if any((folder / kind).glob("part-*.parquet")):
            table = read_parts(folder / kind)
            digest.update(f"{kind} {table.num_rows} {table.column_names}".encode())
            for name in table.column_names:
                digest.update(json.dumps(table[name].to_pylist()).encode())
    return digest.hexdigest()


def summary(folder: Path) -> dict[str, Any]:
    """Return a run's folder, and the hashes of its world and recording."""
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    return {
        "done": manifest["done"],
        "finished": manifest["finished"],
        "world": manifest["digest"],
        "recording": content(folder),
    }
