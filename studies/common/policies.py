"""A training seed's policies: newly trained, or stored by an earlier case of any study."""

from __future__ import annotations

import hashlib
import json
import tempfile
from functools import cache
from pathlib import Path
from typing import Any


def trained(config: Any, seed: int, ticks: int | None = None) -> Path:
    """Train a seed's policies, or reuse the policies of an earlier case; return their folder of
    <species>.safetensors files.

    Stored policies are keyed by configuration, seed, length and ecs_eco source code, so they are never stale.
    """
    from ecs_eco.lab.jobs import train_or_find

    text = json.dumps([_sources(), without_policies(config), seed, ticks], sort_keys=True)
    name = hashlib.sha256(text.encode()).hexdigest()[:24]
    folder = Path(tempfile.gettempdir()) / "ecs-eco-policies" / name
    return train_or_find(folder, config, seed, ticks, verify=False)


def without_policies(config: Any) -> dict[str, Any]:
    """Return a configuration without the bundled policies, which do not affect training."""
    data: dict[str, Any] = config.resolved(former=True)
    for species in data["species"].values():
        species["policy"]["file"] = None
    return data


@cache
def _sources() -> str:
    import ecs_eco

    files = sorted(Path(str(ecs_eco.__file__)).parent.rglob("*.py"))
    return hashlib.sha256(b"".join(p.read_bytes() for p in files)).hexdigest()
