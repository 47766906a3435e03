"""Code that a world names: a closed list of shipped names, and files or modules that the user has allowed.

A world lists its own code in `code`: files next to it ("sir.py") or installed modules ("mypackage.ecology").
Reading a world executes no code: the source text is read and hashed, and runs only after the user allows
exactly this text (see trust.py). Files are never looked up on Python's module path, and compiled copies are
never used.
"""

from __future__ import annotations

import builtins
import hashlib
import importlib
import inspect
import re
import sys
import traceback
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest
from ecs_eco.inputs import trust
from ecs_eco.inputs.sources import Source, of_file, of_module, of_session

SHIPPED = (
    "ecs_eco.learning.mlp:MLP",
    "ecs_eco.worlds.diel_migration.senses:whim",
    "ecs_eco.worlds.lamb.systems:Breathe",
    "ecs_eco.worlds.lamb.systems:Burn",
    "ecs_eco.worlds.lamb.systems:Suckle",
)
"""The names in this package that data may use without listing their modules."""
ENTRY = re.compile(r"(__main__:)?[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*")
_loaded: dict[tuple[Source, ...], dict[str, ModuleType | Exception]] = {}


class CodeError(ConfigError):
    """Raised if code named in data cannot run here because it is not listed, is not allowed, or cannot be
    imported."""


@dataclass(frozen=True)
class Code:
    """The code that a world lists, and whether all of it is allowed to run."""

    sources: tuple[Source, ...] = ()
    passed_on: bool = False  # allowed in the parent process
    unread: tuple[str, ...] = ()  # listed modules whose text could not be read; already reported

    def __reduce__(self) -> tuple[Any, ...]:
        return Code, (self.sources, self.allowed)

    @property
    def allowed(self) -> bool:
        """Whether this process or its user allows all of the code to run."""
        return self.passed_on or all(s.allowed for s in self.sources)

    def allow(self) -> None:
        """Allow these texts in this process."""
        trust.allow(s.sha256 for s in self.sources)

    def pass_on(self) -> None:
        """Allow in a child process the code that its parent allowed, including copies of these texts."""
        if self.allowed:
            self.allow()

    def lists(self, name: str) -> bool:
        """Return whether "module:name" is shipped or its module is listed."""
        return name in SHIPPED or any(
            name == s.entry if s.of_session else name.partition(":")[0] == s.module for s in self.sources
        )

    def require(self, where: str = "") -> None:
        """Raise CodeError unless all of the code is allowed to run."""
        if not self.allowed:
            place = f"{where}: " if where else ""
            raise CodeError(
                self.problems(), f"{place}names code that is not allowed to run here; none of it was run"
            )

    def problems(self) -> list[Problem]:
        """Return a problem for each text that is not allowed."""
        return [
            Problem(("code", i), f"not allowed yet: {s.path or 'no file'}, SHA-256 {s.sha256}", s.entry, HOW)
            for i, s in enumerate(self.sources)
            if not (self.passed_on or s.allowed)
        ]

    def function(self, name: object) -> Any:
        """Return the object that "module:name" refers to; return anything other than a string unchanged.

        Raises CodeError, ImportError or AttributeError.
        """
        if not isinstance(name, str):
            return name
        module, _, attribute = name.partition(":")
        if name in SHIPPED:
            return getattr(importlib.import_module(module), attribute)
        if not self.lists(name):
            raise CodeError([self.unlisted((), name)])
        self.require(name)
        thing = getattr(self._module(module), attribute)
        if (inspect.isroutine(thing) or inspect.isclass(thing)) and not self._is_home(
            module, getattr(thing, "__module__", None)
        ):
            raise AttributeError(f"{module} only imports {attribute}, from {thing.__module__}")
        return thing

    def problem(self, key: tuple[str | int, ...], name: object) -> Problem | None:
        """Return the problem with a name; None if it is valid, or if its code is not allowed to run or
        fails."""
        try:
            if self._unseen(name):
                return None
            if isinstance(name, str) and not self.lists(name):
                return self.unlisted(key, name)
            thing = self.function(name)
        except AttributeError as error:
            return self._missing(key, str(name), str(error))
        except Exception as error:
            return Problem(
                key, f"cannot be imported: {type(error).__name__}: {error}", name, "code that runs"
            )
        if not callable(thing) and not callable(getattr(thing, "process", None)):
            return Problem(key, f"{name} is not a function", name, "a function or a class")
        return None

    def faults(self) -> list[Problem]:
        """Return a problem for each listed text that fails to run, if all of them are allowed."""
        if not self.allowed:
            return []
        return [
            Problem(
                ("code", i),
                f"cannot be imported: {type(error).__name__}: {error}{_line(error, s)}",
                s.entry,
                "code that runs",
            )
            for i, s in enumerate(self.sources)
            if isinstance(error := self._modules[s.module], Exception)
        ]

    def _unseen(self, name: object) -> bool:
        """Return whether a name's listed source cannot be read, is not allowed to run, or failed to run."""
        return (
            isinstance(name, str)
            and name not in SHIPPED
            and (self.lists(name) or name.partition(":")[0] in self.unread)
            and (not self.allowed or not isinstance(self._modules.get(name.partition(":")[0]), ModuleType))
        )

    def _missing(self, key: tuple[str | int, ...], name: str, why: str) -> Problem:
        module, _, attribute = name.partition(":")
        names = vars(self._module(module))
        own = [
            n
            for n, f in names.items()
            if callable(f) and n[0] != "_" and self._is_home(module, getattr(f, "__module__", None))
        ]
        fault = why if "only imports" in why else f"{module} has no function {attribute}"
        return Problem(key, fault, name, listed(own), nearest(attribute, own))

    def known(self, name: object) -> Any:
        """Return the object that a name refers to; None if the name is wrong or its code cannot run."""
        wrong = self._unseen(name) or self.problem((), name) is not None
        return None if wrong else self.function(name)

    def subclasses(self, base: type, *among: type) -> list[type]:
        """Return the subclasses of `base` defined in the listed texts, restricted to `among` if given."""
        found = [
            thing
            for name, module in (self._modules if self.allowed else {}).items()
            if isinstance(module, ModuleType)
            for thing in vars(module).values()
            if isinstance(thing, type) and issubclass(thing, base) and self._is_home(name, thing.__module__)
        ]
        return [thing for thing in dict.fromkeys(found) if not among or thing in among]

    def unlisted(self, key: tuple[str | int, ...], name: str) -> Problem:
        """Return the problem with a name whose module is not listed in `code`."""
        module, known = name.partition(":")[0], [s.module for s in self.sources]
        allowed = (
            f"a module listed in `code` ({listed(known)}), "
            f'for example code = ["{module.partition(".")[0]}.py"]'
        )
        near = next((n for n in SHIPPED if n.lower() == name.lower()), "") or nearest(module, known)
        return Problem(key, f"names code in {module}, which `code` does not list", name, allowed, near)

    @cached_property
    def _modules(self) -> dict[str, ModuleType | Exception]:
        """Return each module, or the error if it failed to run; if all of them ran, all worlds share them."""
        modules = _loaded.get(self.sources) or dict(_load(self.sources))
        if not any(isinstance(module, Exception) for module in modules.values()):
            _loaded[self.sources] = modules
        return modules

    def _module(self, module: str) -> ModuleType:
        """Return the module, or raise its error if it failed to run."""
        if isinstance(loaded := self._modules[module], Exception):
            raise loaded
        return loaded

    def _is_home(self, module: str, home: str | None) -> bool:
        """Return whether a function or class with this `__module__` was defined in the module."""
        own = self._module(module).__name__
        return (
            home is None
            or home == own
            or (not own.startswith(PRIVATE) and home.partition(".")[0] == own.partition(".")[0])
        )


HOW = "read it; if you trust it, repeat the command with --trust, or pass trust=True in Python"
PRIVATE = "_ecs_eco_code_"
NONE = Code()


def handed_over(function: object) -> Any:
    """Return a function unchanged. Raises CodeError for a name, because only a world can resolve it."""
    return NONE.function(function)


def public_module(module: str) -> str:
    """Return a module's name as worlds use it, not the private name of a file next to a world."""
    return getattr(sys.modules.get(module), "__public__", module) if module.startswith(PRIVATE) else module


def read(
    entries: Iterable[str], places: Sequence[Path], wanted: Mapping[str, str] = MappingProxyType({})
) -> tuple[Code, list[Problem]]:
    """Return the code that a world lists, and any problems; nothing runs.

    A file is taken from the first of `places` that contains it, preferably with the hash in `wanted`.
    """
    sources: list[Source] = []
    problems = []
    for i, entry in enumerate(entries):
        if not ENTRY.fullmatch(entry):
            continue  # already reported by the field's type
        source, fault = (
            of_session(entry)
            if ":" in entry
            else of_file(entry, places, wanted.get(entry))
            if entry.endswith(".py")
            else of_module(entry)
        )
        if source is not None and source.module in [s.module for s in sources if not source.of_session]:
            source, fault = None, "has the same module as another entry"
        if source is None:
            allowed = "a file next to the world file, or your own installed module"
            problems.append(Problem(("code", i), fault, entry, allowed))
        else:
            sources.append(source)
    unread = tuple(str(p.value).removesuffix(".py") for p in problems)
    return Code(tuple(sources), unread=unread), problems


def _load(sources: tuple[Source, ...]) -> Iterator[tuple[str, ModuleType | Exception]]:
    """Run the texts in order, so that files can import earlier files. Yield each module, or the error if it
    failed."""
    digest = hashlib.sha256(" ".join(f"{s.entry} {s.sha256}" for s in sources).encode()).hexdigest()[:16]
    earlier: dict[str, ModuleType | Exception] = {}
    for source in sources:
        loaded: ModuleType | Exception
        try:
            if not source.is_file and source.module not in sys.modules:
                _require_unchanged(source)
            loaded = (
                _run(source, f"{PRIVATE}{digest}_{source.module}", dict(earlier))
                if source.is_file
                else importlib.import_module(source.module)
            )
        except Exception as error:
            loaded = error
        if source.is_file:
            earlier[source.module] = loaded
        yield source.module, loaded


def _require_unchanged(source: Source) -> None:
    """Raise CodeError if the file of an installed module is not the one that was read and allowed."""
    if source.text is not None and (now := of_module(source.entry)[0]) != source:
        fault = (
            f"has changed since it was read: its SHA-256 was {source.sha256}, "
            f"and is now {'none' if now is None else now.sha256}"
        )
        raise CodeError([Problem(("code",), fault, source.entry, HOW)])


def _line(error: Exception, source: Source) -> str:
    """Return the line at which the text failed, or "" if the error names that line or the text did not start
    to run."""
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == source.path]
    return f" ({source.entry}, line {lines[-1]})" if lines else ""


def _run(source: Source, name: str, earlier: dict[str, ModuleType | Exception]) -> ModuleType:
    """Execute the text that was read, as a module with a private name that no other import can find."""

    def find(
        wanted: str,
        globals_: Mapping[str, object] | None = None,
        locals_: Mapping[str, object] | None = None,
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> ModuleType:
        if level == 0 and wanted in earlier:
            if isinstance(module := earlier[wanted], Exception):
                raise ImportError(f"{wanted}.py cannot be imported")
            return module
        return builtins.__import__(wanted, globals_, locals_, fromlist, level)

    module = ModuleType(name)
    module.__file__, module.__dict__["__public__"] = source.path, source.module
    module.__dict__["__builtins__"] = {**vars(builtins), "__import__": find}
    sys.modules[name] = module  # dataclasses and pickle look modules up here
    try:
        exec(compile(source.text or b"", source.path, "exec", dont_inherit=True), module.__dict__)
    except BaseException:
        del sys.modules[name]
        raise
    return module
