"""The sandbox for malicious files: a folder with the `evil` module, payloads of all kinds, marks, and
harmless files to start from."""

from __future__ import annotations

import contextlib
import io
import os
import pickle  # noqa: TID251 # to write files that readers must not load
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.malicious.templates import PAYLOAD, world_of

TICKS, EVERY = 6, 2
MODULES = ("evil", "evilpackage")
REFUSED, UNNAMED, ACCEPTED, TRACEBACK = (
    "refused by name",
    "refused without a name",
    "accepted, harmless",
    "traceback",
)
KINDS = (REFUSED, ACCEPTED, UNNAMED, TRACEBACK)


@dataclass(frozen=True)
class Attack:
    """One malicious file or message: how it is used, and a list of words, at least one of which must appear
    in the refusal."""

    label: str
    words: Sequence[str]
    attempts: Sequence[tuple[str, Callable[[], Any]]]


class Shell:
    """An object that runs a shell command when it is unpickled."""

    def __init__(self, command: str) -> None:
        self.command = command

    def __reduce__(self) -> tuple[Any, ...]:
        return os.system, (self.command,)


class Ground:
    """A separate folder in which no code is allowed to run, with `evil` on Python's path."""

    def __init__(self, home: Path) -> None:
        self.home, self.marks = home, home / "marks"
        self.marks.mkdir()
        self.shell = f"touch {self.marks}/shell"
        self._number = 0
        self.text = PAYLOAD.format(mark=str(self.marks / "module"))
        self.put_evil(home / "path")

    def put_evil(self, folder: Path) -> Path:
        """Write the modules to a folder."""
        (folder / "evilpackage").mkdir(parents=True, exist_ok=True)
        for name in ("evil.py", "evilpackage/__init__.py", "evilpackage/inside.py"):
            (folder / name).write_text(self.text, encoding="utf-8")
        return folder

    def new(self) -> Path:
        """Return a path for a new folder."""
        self._number += 1
        return self.home / f"case-{self._number}"

    def beside(self) -> Path:
        """Return a new folder that contains the modules."""
        return self.put_evil(self.new())

    def marked(self) -> list[str]:
        """Return and remove all marks."""
        paths = sorted(self.marks.iterdir())
        for path in paths:
            path.unlink()
        return [path.name for path in paths]

    # --- carriers of payloads

    @cached_property
    def blobs(self) -> dict[str, bytes]:
        """Return files, by kind, that run a shell command when unpickled by Python, numpy or torch."""
        pickled = pickle.dumps(Shell(self.shell))
        array, arrays, torch_ = io.BytesIO(), io.BytesIO(), io.BytesIO()
        np.save(array, np.array([Shell(self.shell)], dtype=object), allow_pickle=True)
        np.savez(arrays, weight=np.array([Shell(self.shell)], dtype=object))
        with zipfile.ZipFile(torch_, "w") as file:
            file.writestr("archive/data.pkl", pickled)
            file.writestr("archive/version", "3")
        script = f"#!/bin/sh\n{self.shell}\n".encode()
        return {
            "a pickle": pickled,
            "an npy file of objects": array.getvalue(),
            "an npz file of objects": arrays.getvalue(),
            "a file of torch": torch_.getvalue(),
            "a Python file": self.text.encode(),
            "a script": script,
        }

    @cached_property
    def texts(self) -> list[str]:
        """Return texts that some parser would execute."""
        python = f"__import__('os').system('{self.shell}')"
        return [
            python,
            f"$({self.shell})",
            f"`{self.shell}`",
            f"|{self.shell}",
            f"; {self.shell};",
            "{" + python + "}",
            "{{" + python + "}}",
            f"!!python/object/apply:os.system ['{self.shell}']",
            f"file://{self.marks}/../path/evil.py",
            f"lambda: {python}",
            f"\\immediate\\write18{{{self.shell}}}",
            f"<script>fetch('{self.shell}')</script>",
            f"\x1b]0;{self.shell}\x07",
        ]

    # --- harmless files

    @cached_property
    def garden(self) -> dict[str, Any]:
        """Return a world that names no code."""
        return world_of("systems.*") | {"systems": []}

    @cached_property
    def run(self) -> Path:
        """Return a recorded run of the garden, with checkpoints."""
        from ecs_eco.record import run_to_folder

        run_to_folder(
            self.garden,
            ticks=TICKS,
            out=self.home / "run",
            report=False,
            snapshot_every=EVERY,
            checkpoint_every=EVERY,
        )
        return self.home / "run"

    @cached_property
    def checkpoint(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the metadata and arrays of its last checkpoint."""
        from ecs_eco.record import checkpoint as file

        return file.read(sorted((self.run / "checkpoints").iterdir())[-1])

    def copy_of_run(self) -> Path:
        """Return a copy of the run."""
        folder = self.new()
        shutil.copytree(self.run, folder)
        return folder


@contextlib.contextmanager
def ground() -> Iterator[Ground]:
    """Yield a ground for the duration of a `with` block: a user who allows no code, importable modules that
    would leave a mark, and none of the modules loaded from earlier worlds."""
    from ecs_eco.inputs import trust

    before, allowed, path, config = (
        Path.cwd(),
        set(trust._here),
        list(sys.path),
        os.environ.get("XDG_CONFIG_HOME"),
    )
    modules = {name: sys.modules.pop(name) for name in _loaded()}
    with tempfile.TemporaryDirectory(prefix="ecs-eco-malicious-") as folder:
        home = Path(folder).resolve()
        os.environ["XDG_CONFIG_HOME"] = str(home / "config")
        try:
            prepared = Ground(home)
            trust._here.clear()
            sys.path.insert(0, str(home / "path"))
            os.chdir(home / "path")
            yield prepared
        finally:
            _forgotten()
            sys.modules.update(modules)
            os.chdir(before)
            sys.path[:] = path
            trust._here.clear()
            trust.allow(allowed)
            if config is None:
                del os.environ["XDG_CONFIG_HOME"]
            else:
                os.environ["XDG_CONFIG_HOME"] = config


def cli(*words: Any) -> Callable[[], str]:
    """Run a command in this process; return its error message if it refused, "" if it did not."""

    def command() -> str:
        from typer.testing import CliRunner

        from ecs_eco.cli.app import app

        done = CliRunner().invoke(app, [str(word) for word in words])
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        if "Traceback" in done.output or done.exit_code not in (0, 1, 2):
            raise RuntimeError(f"ended with {done.exit_code}: {done.output[-300:]}")
        return (done.output or "no word") if done.exit_code else ""

    return command


def judged(ground: Ground, attack: Attack) -> dict[str, Any]:
    """Return the outcome of one attack: how its attempts ended, marks, loaded payload modules, and
    tracebacks."""
    import traceback

    counts, outputs = dict.fromkeys(KINDS, 0), []
    for name, attempt in attack.attempts:
        try:
            text = attempt() or ""
            kind = _kind(text, attack.words)
        except Exception as error:
            kind = _kind(str(error), attack.words) if _is_refusal(error) else TRACEBACK
            text = traceback.format_exc() if kind == TRACEBACK else str(error)
        counts[kind] += 1
        if kind in (UNNAMED, TRACEBACK):
            outputs.append([name, kind, text[-700:]])
    loaded = _forgotten()
    return {
        "label": attack.label,
        "counts": counts,
        "marks": ground.marked(),
        "imported": loaded,
        "said": outputs,
    }


def _forgotten() -> list[str]:
    """Unload the payload's modules, so that the next import runs them again; return their names."""
    loaded = _loaded()
    for module in loaded:
        del sys.modules[module]
    return loaded


def _loaded() -> list[str]:
    return [m for m in sys.modules if m.partition(".")[0] in MODULES or m.startswith("_ecs_eco_code_")]


def _is_refusal(error: Exception) -> bool:
    from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError

    return isinstance(error, ConfigError | CheckpointError | RecordingError)


def _kind(output: str, words: Sequence[str]) -> str:
    if not output:
        return ACCEPTED
    plain = "".join(output.split())
    return REFUSED if any("".join(word.split()) in plain for word in words) else UNNAMED
