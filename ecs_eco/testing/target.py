"""What results depend on besides world and seed: the processor, and versions of packages."""

from __future__ import annotations

import hashlib
import platform
from importlib.metadata import PackageNotFoundError, version
from typing import NamedTuple

from ecs_eco.compiled import portable
from ecs_eco.compiled.numba_version import interpreted
from ecs_eco.compiled.processor import processor

COMPUTING = ("numpy", "numba", "llvmlite", "torch", "deap", "scipy")  # whose versions results may depend on
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
    """A kind of machine: results are promised to be identical on two machines of the same target."""

    system: str  # operating system and architecture
    cpu: str  # the processor's name, as LLVM calls it
    features: str  # a hash of all the instructions that LLVM may use
    torch: str  # which of torch's kernels are used
    versions: dict[str, str]

    @property
    def key(self) -> str:
        """Return a line that names the target."""
        text = " ".join(f"{name} {number}" for name, number in self.versions.items())
        return f"{self.system}, {self.cpu} ({self.features}), torch {self.torch}; {text}"


def versions(names: tuple[str, ...]) -> dict[str, str]:
    """Return the versions of some packages, "-" for one that is not installed."""
    versions_of = {}
    for name in names:
        try:
            versions_of[name] = version(name)
        except PackageNotFoundError:
            versions_of[name] = "-"
    return versions_of


def instructions() -> tuple[str, str, list[str]]:
    """Return the triple, the processor and the features that numba compiles for, as NUMBA_CPU_NAME has them."""
    triple, name, features = processor()
    return triple, name, sorted(word[1:] for word in features.split(",") if word.startswith("+"))


def target() -> Target:
    """Return the target of this process."""
    import torch

    python = ".".join(platform.python_version_tuple()[:2])
    if portable.on():  # whatever the machine
        return Target(
            platform.machine(),
            portable.CPU,
            "portable",
            "not asked",
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
