"""Lazy loading of the names in a package, and aliases for former module names.

This module imports nothing from the package, so every `__init__` can use it.
"""

import re
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

FORMER = {  # public modules of earlier versions; an entry for a package covers its contents
    "ecs_eco.analysis.crossed": "ecs_eco.analysis.seed_grid",
    "ecs_eco.archipelago": "ecs_eco.lab",
    "ecs_eco.components.Desires": "ecs_eco.components.HappinessWeights",
    "ecs_eco.components.Plasticity": "ecs_eco.components.LearningRates",
    "ecs_eco.components.Vigour": "ecs_eco.components.SpeedScale",
    "ecs_eco.experiments": "ecs_eco.lab",
    "ecs_eco.experiments.compare": "ecs_eco.lab.comparison",
    "ecs_eco.random": "ecs_eco.engine.random",
    "ecs_eco.record.arrow": "ecs_eco.record.parquet",
    "ecs_eco.record.repeat": "ecs_eco.runs.repeat",
    "ecs_eco.record.run": "ecs_eco.runs.run",
    "ecs_eco.search": "ecs_eco.lab.searching",
    "ecs_eco.sweeps": "ecs_eco.lab",
    "ecs_eco.worlds.pretrain": "ecs_eco.lab.pretraining",
    "ecs_eco.worlds.retune": "ecs_eco.life.reconfigure",
}


def lazy(package: str, homes: Mapping[str, str], subpackages: str = "") -> Callable[[str], Any]:
    """Return a package's `__getattr__`, and set its `__all__` and `__dir__`, given the names that each module
    defines and the package's public subpackages, separated by spaces."""
    modules = {name: module for module, names in homes.items() for name in names.split()}
    public = [*modules, *subpackages.split()]
    loaded = vars(sys.modules[package])

    def find(name: str) -> Any:
        if name in modules:
            return getattr(import_module(modules[name], package), name)
        present = present_name(f"{package}.{name}")
        if present and file_of(name) != name:  # a class
            warnings.warn(f"{package}.{name} is now {present}", DeprecationWarning, stacklevel=2)
            return getattr(import_module(package), present.rpartition(".")[2])
        if present or name in public:
            return import_module(f"{package}.{name}")
        raise AttributeError(f"{package} has no {name!r}; it has {', '.join(public)}")

    loaded["__all__"] = public
    loaded["__dir__"] = lambda: sorted({*loaded["__all__"], *(name for name in loaded if name[:2] == "__")})
    return find


def present_name(name: str) -> str | None:
    """Return the current name of a module, given its former name; None for any other name."""
    package, _, module = name.rpartition(".")
    if name in FORMER or package not in FORMER:
        return FORMER.get(name)
    return f"{FORMER[package]}.{module}"


def stored_name(component: type[Any]) -> str:
    """Return the name of a component in checkpoints and digests: its original name."""
    name = f"{component.__module__.rpartition('.')[0]}.{component.__name__}"
    return next((old for old, now in FORMER.items() if now == name), name).rpartition(".")[2]


class Later:
    """A module that is imported when one of its names is first used, for slow imports that few functions
    need. For type checkers, also import it under TYPE_CHECKING."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module(self._name), name)


def file_of(name: str) -> str:
    """Return the module name of a class in a package with one class per file: give_birth for GiveBirth."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


class Former(MetaPathFinder, Loader):
    """Finds modules by their former names, with a DeprecationWarning that gives the current name."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return a spec for the former name of a module, or None for any other name."""
        return ModuleSpec(name, self) if present_name(name) and file_of(name) == name else None

    def exec_module(self, module: ModuleType) -> None:
        """Replace the module under the former name with the current module."""
        name = module.__name__
        present = str(present_name(name))
        warnings.warn(f"{name} is now {present}", DeprecationWarning, stacklevel=2)
        there = import_module(present)
        if hasattr(there, "__path__"):  # a stand-in, as importing submodules sets attributes on it
            module.__dict__.update(__path__=[], __getattr__=partial(getattr, there))
        else:
            sys.modules[name] = there


def find_former_names() -> None:
    """Enable imports by former names, which take precedence over files."""
    if not any(isinstance(finder, Former) for finder in sys.meta_path):
        sys.meta_path.insert(0, Former())
