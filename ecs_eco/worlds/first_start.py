"""The first start of a world: two processes compile its kernels, one from the start of the list, the other
from its end.

The kernels that a world calls, with their types, are known in advance only if they are listed;
`tools/make_kernels.py` lists them for the shipped worlds. An outdated line of the list only loses that
kernel's saving, and a kernel that is not listed is compiled when it is called.
"""

from __future__ import annotations

import gc
import os
import subprocess
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from ecs_eco.compiled import jit, signatures
from ecs_eco.compiled.garbage import uncollected
from ecs_eco.compiled.numba_version import plain
from ecs_eco.config.shipped import shipped
from ecs_eco.engine.processes import python

_HELPER = "from ecs_eco.worlds.first_start import help_on; help_on(sys.argv[1:])"
LIST, MARK = Path(__file__).with_name("kernels.txt"), ".warm"


@dataclass
class Compiled:
    """The number of kernels compiled for a run, and the number of processes that compiled them."""

    number: int = 0
    processes: int = 1

    def __str__(self) -> str:
        if not self.number:
            return ""
        plural = "" if self.number == 1 else "s"
        return f"\n  {self.number} kernel{plural} compiled" + ", by two processes" * (self.processes > 1)


def listed(world: str) -> list[tuple[str, str]]:
    """Return (function, types) of the kernels that a world calls, in the order of first calls; for other
    worlds, the kernels of most shipped worlds."""
    head, *lines = LIST.read_text(encoding="utf-8").splitlines()
    names = head.removeprefix("# worlds: ").split(", ")
    out = []
    for line in lines:
        where, function, types = line.split("\t")
        callers = {names[int(number)] for number in where.split(",")}
        if world in callers or (world not in names and 2 * len(callers) > len(names)):
            out.append((function, types))
    return out


def kernel_of(function: str) -> Any:
    """Return a kernel by `module:name`; raise ImportError or AttributeError if it does not exist."""
    module, _, name = function.partition(":")
    one = getattr(import_module(module), name)
    return getattr(one, "on_fields", one)  # type that Python's calls of a kernel with views have


def compile_listed(
    worlds: Sequence[str],
    share: int = 0,
    of: int = 1,
    backwards: bool = False,
    progress: Callable[[int, int], Any] | None = None,
) -> None:
    """Compile the listed kernels of these worlds, except kernels that another process has compiled or is
    compiling.

    If several processes do this, each begins with its own `share`, 0 … `of` - 1.
    """
    jit.FOLDER.shared = True
    lines = list(dict.fromkeys(line for world in worlds for line in listed(world)))
    first = len(lines) * share // of
    lines = lines[::-1] if backwards else lines[first:] + lines[:first]
    for done, (function, types) in enumerate(lines):
        if progress is not None:
            progress(done, len(lines))
        with suppress(Exception):  # a kernel that has changed is compiled when it is called
            kernel, signature = kernel_of(function), signatures.read(types)
            if not kernel.known(signature):
                kernel.compile(signature)
    for world in worlds:
        _mark(world).touch()


def warm(worlds: Sequence[str], processes: int, progress: Callable[[int, int], Any] | None = None) -> None:
    """Compile the listed kernels of these worlds, in so many processes."""
    others = [_start(["share", str(share), str(processes), *worlds]) for share in range(1, processes)]
    try:
        compile_listed(worlds, 0, processes, progress=progress)
        for other in others:
            other.wait()
    finally:
        for other in others:
            other.terminate()
            other.wait()


def known_to_list(world: str) -> str:
    """Return the name of a world in the list: its own for a shipped world, else "others"."""
    return world if world in shipped() else "others"


def _mark(world: str) -> Path:
    """Return the file that marks the listed kernels of a world as compiled."""
    return jit.FOLDER.path / f"{world}{MARK}"


def _start(arguments: Sequence[str]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        python(_HELPER, *arguments),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@contextmanager
def two_processes(world: str) -> Iterator[Compiled]:
    """Compile kernels in a second process during the context, if this is the first start of a world and
    there is a second core; afterwards store how many kernels were compiled."""
    path, helper, collecting = jit.FOLDER.path, None, gc.isenabled()
    out, there, own = Compiled(), len(list(path.glob("*.nbc"))), jit.FOLDER.compiled
    try:
        if not _mark(world).exists() and cores() > 1 and not plain() and jit.FOLDER.writable():
            jit.FOLDER.shared, out.processes = True, 2
            helper = _start(["backwards", world])
            gc.disable()  # until all is `loaded`: most objects of the compiler are permanent
        yield out
    finally:
        out.number = jit.FOLDER.compiled - own
        if helper is not None:
            jit.FOLDER.shared = False
            if collecting:
                gc.enable()
            helper.terminate()
            helper.wait()
            out.number = len(list(path.glob("*.nbc"))) - there


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def help_on(arguments: Sequence[str]) -> None:
    """Compile in this process, which another process started for this: `backwards WORLD`, or `share NUMBER
    OF WORLD…`."""
    with uncollected():
        if arguments[0] == "backwards":
            compile_listed(arguments[1:], backwards=True)
        else:
            compile_listed(arguments[3:], int(arguments[1]), int(arguments[2]))
