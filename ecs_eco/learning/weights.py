"""Files of trained policies: safetensors with a seal (a SHA-256 hash of all weights, which reveals damage)
and the names of the policy's inputs and choices.

Files from other sources have neither a seal nor names and are accepted unchanged.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load as parsed

from ecs_eco.engine import files

MOST_BYTES = 100_000_000  # per world's file: more than the largest allowed network needs
Weights = Mapping[str, np.ndarray]
SEAL, NAMES = "ecs-eco.seal", "ecs-eco.names"  # in the file's metadata
Names = Mapping[str, Any]
"""The inputs and choices of a policy: "channels", the "options" of each group, the "gaits" with their speeds
[m/s], and the "version" of the package that wrote them."""


def save(path: str | Path, weights: Weights, names: Names | None = None) -> Path:
    """Atomically write a policy with its seal and its names. Raises an OSError that names the file."""
    arrays = {name: np.ascontiguousarray(array) for name, array in weights.items()}
    text = "" if names is None else json.dumps(names)
    return files.write_tensors(path, arrays, {SEAL: seal_of(arrays, text)} | ({NAMES: text} if text else {}))


def load(path: str | Path) -> dict[str, np.ndarray]:
    """Return the weights in a file. Raises ValueError if the seal does not match or the file has no weights,
    and OSError if the file cannot be read."""
    return read(files.read_bytes(path))[0]


def read(content: bytes) -> tuple[dict[str, np.ndarray], Names | None]:
    """Return the weights and the names from a file's bytes. Raises ValueError."""
    try:
        weights = parsed(content)
        metadata = (
            json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")]).get("__metadata__") or {}
        )
        text = metadata.get(NAMES, "")
        names = _named(json.loads(text)) if text else None
    except (SafetensorError, TypeError, KeyError, AttributeError, OverflowError, ValueError) as error:
        raise ValueError(f"is not a weights file: {error}") from None
    if SEAL in metadata and metadata[SEAL] != seal_of(weights, text):
        raise ValueError("is damaged: its weights differ from what was written")
    return weights, names


def _named(names: Mapping[str, Any]) -> Names:
    """Return the validated names. Raises ValueError, KeyError, TypeError or AttributeError if they are
    invalid."""
    options = {str(group): [str(option) for option in some] for group, some in names["options"].items()}
    return {
        "channels": [str(channel) for channel in names["channels"]],
        "options": options,
        "gaits": {str(gait): float(speed) for gait, speed in names["gaits"].items()},
        "version": str(names["version"]),
    }


def seal_of(weights: Weights, text: str = "") -> str:
    """Return the seal of weights, 64 hexadecimal digits: a SHA-256 hash of names, types, shapes, bytes and,
    last, a text."""
    digest = hashlib.sha256()
    for name in sorted(weights):
        array = np.ascontiguousarray(weights[name])
        digest.update(json.dumps([name, array.dtype.str, list(array.shape)]).encode() + array.tobytes())
    digest.update(text.encode())
    return digest.hexdigest()


def hash_of(path: str | Path) -> str:
    """Return the SHA-256 hash of a file, 64 hexadecimal digits."""
    return hashlib.sha256(files.read_bytes(path)).hexdigest()


def add_seal(path: str | Path) -> None:
    """Add a seal to a weights file from another source without changing the weights."""
    save(path, *read(files.read_bytes(path)))


if __name__ == "__main__":  # python -m ecs_eco.learning.weights FILE…
    import sys

    for name in sys.argv[1:]:
        add_seal(name)
