"""The target: the processor and package versions, on which results depend in addition to the world and seed."""

from __future__ import annotations

import hashlib
import platform
from importlib.metadata import PackageNotFoundError, version
from typing import NamedTuple

from ecs_eco.compiled import portable
from ecs_eco.compiled.numba_version import interpreted
from ecs_eco.compiled.processor import processor

COMPUTING = ("numpy", "numba", "llvmlite", "torch", "deap", "scipy")  # may affect results
OTHERS = (
    "esper",
    "pyarrow",
    "pydantic",
    "safetensors",
    "optuna",
    "starlette",
    "uvicorn",
    "websockets",
    "matplotlib",
    "typer",
    "rich",
)


class Target(NamedTuple):
    """A kind of machine: results are guaranteed to be identical on all machines with the same target."""

    system: str  # operating system and architecture
    cpu: str  # the processor's LLVM name
    features: str  # a hash of all instructions that LLVM may use
    torch: str  # the torch kernels in use
    versions: dict[str, str]

    @property
    def key(self) -> str:
        """A line that identifies the target."""
        text = " ".join(f"{name} {number}" for name, number in self.versions.items())
        return f"{self.system}, {self.cpu} ({self.features}), torch {self.torch}; {text}"


def versions(names: tuple[str, ...]) -> dict[str, str]:
    """Return the versions of packages; "-" for a package that is not installed."""
    versions_of = {}
    for name in names:
        try:
            versions_of[name] = version(name)
        except PackageNotFoundError:
            versions_of[name] = "-"
    return versions_of


def instructions() -> tuple[str, str, list[str]]:
    """Return the target triple, processor (as in NUMBA_CPU_NAME) and features for which numba compiles."""
    triple, name, features = processor()
    return triple, name, sorted(word[1:] for word in features.split(",") if word.startswith("+"))


def target() -> Target:
    """Return the target of this process."""
    import torch

    python = ".".join(platform.python_version_tuple()[:2])
    if portable.on():  # independent of the machine
        return Target(
            platform.machine(),
            portable.CPU,
            "portable",
            "not asked",  # part of the identity by which digests.json lists targets
            {"python": python, **versions(COMPUTING)},
        )
    _, name, features = instructions()
    digest = hashlib.sha256(" ".join(features).encode()).hexdigest()[:8]
    compiled = " without compilation" if interpreted() else ""
    return Target(
        f"{platform.system()} {platform.machine()}",
        name + compiled,
        digest,
        torch.backends.cpu.get_cpu_capability(),
        {"python": python, **versions(COMPUTING)},
    )
