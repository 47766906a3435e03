"""Files of trained policies: safetensors with a seal, a SHA-256 of all weights,
so that no damaged policy lives in a world.

Files of other origin have none, and are taken as they are.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ecs_eco.engine import files

Weights = Mapping[str, np.ndarray]
SEAL = "ecs-eco.seal"  # in the file's metadata


def save(path: str | Path, weights: Weights) -> Path:
    """Write a policy with its seal, whole or not at all; raises OSError that names the file."""
    arrays = {name: np.ascontiguousarray(array) for name, array in weights.items()}
    return files.write_tensors(path, arrays, {SEAL: seal_of(arrays)})


def load(path: str | Path) -> dict[str, np.ndarray]:
    """Return the weights in a file; raises ValueError where they are not those that were sealed,
    or no weights, OSError."""
    return read(Path(path).read_bytes())


def read(content: bytes) -> dict[str, np.ndarray]:
    """Return the weights in the bytes of a file; raises ValueError."""
    from safetensors import SafetensorError
    from safetensors.numpy import load as parsed

    try:
        weights = parsed(content)
        metadata = (json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")]).get("__metadata__")
                    or {})
    except (SafetensorError, TypeError, KeyError, AttributeError, OverflowError, ValueError) as error:
        raise ValueError(f"is no file of weights: {error}") from None
    if SEAL in metadata and metadata[SEAL] != seal_of(weights):
        raise ValueError("is damaged: its weights are not those that were written")
    return weights


def seal_of(weights: Weights) -> str:
    """Return the seal of weights: SHA-256 of names, types, shapes and bytes, 64 hexadecimal digits."""
    digest = hashlib.sha256()
    for name in sorted(weights):
        array = np.ascontiguousarray(weights[name])
        digest.update(json.dumps([name, array.dtype.str, list(array.shape)]).encode() + array.tobytes())
    return digest.hexdigest()


def hash_of(path: str | Path) -> str:
    """Return the SHA-256 of a file, 64 hexadecimal digits."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def add_seal(path: str | Path) -> None:
    """Write the seal into a file of weights of other origin, whose weights stay as they are."""
    save(path, load(path))


if __name__ == "__main__":  # python -m ecs_eco.learning.weights FILE…
    import sys

    for name in sys.argv[1:]:
        add_seal(name)
