"""The commands' output and exit codes."""

import re
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any, NoReturn

import typer

from ecs_eco.compiled.garbage import loaded
from ecs_eco.engine.errors import CheckpointError, ConfigError, Halted, RecordingError, refusal
from ecs_eco.engine.files import read_note
from ecs_eco.record.claim import stopped_early

_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
# exit codes for a negative result or failed work, for rejected input and for Ctrl-C
FAILED, REFUSED, INTERRUPTED = 1, 2, 130


def printable(text: str) -> str:
    """Return text from a world, a file or an error, made safe for terminals: control characters are escaped
    as in \u001b; newlines and tabs are unchanged.

    Control characters are C0, DEL, C1, line and paragraph separators, and bidirectional marks.
    """
    return _CONTROL.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def say(text: str) -> None:
    """Print a line on stdout; all output passes through this function or `printable`.

    File names that are not UTF-8 are escaped, as on stderr.
    """
    typer.echo(printable(text))


def complain(text: str) -> None:
    """Print a line on stderr."""
    typer.echo(printable(text), err=True)


def exits(command: Callable[..., None]) -> Callable[..., None]:
    """Wrap a command: rejected input ends it with code 2 and at most one screen of text, and Ctrl-C ends it
    with code 130."""

    @wraps(command)
    def wrapped(*args: object, **kwargs: object) -> None:
        try:
            command(*args, **kwargs)
        except (ConfigError, RecordingError, CheckpointError) as error:
            complain(str(error))
            raise typer.Exit(FAILED if isinstance(error, Halted) else REFUSED) from None
        except MemoryError as error:
            complain(f"Not enough memory: {error or 'try a smaller world'}")
            raise typer.Exit(FAILED) from None
        except FloatingPointError as error:
            complain(
                f"{error}\nThe recording up to that point is complete; any checkpoints are in the run's "
                "folder checkpoints/."
            )
            raise typer.Exit(FAILED) from None
        except OSError as error:
            if isinstance(error, BrokenPipeError):
                raise  # the reader of the output has exited; click exits quietly
            if isinstance(error, FileNotFoundError) and error.filename is None:  # not a run's folder
                complain(str(error))
                raise typer.Exit(REFUSED) from None
            name = f"{error.filename}: " if error.filename else ""
            complain(f"{name}{error.strerror or error}; files written earlier are complete.")
            raise typer.Exit(FAILED) from None
        except KeyboardInterrupt:
            complain("Stopped.")
            raise typer.Exit(INTERRUPTED) from None

    return wrapped


def refuse(source: str, fault: str, value: object, allowed: str, near: str = "") -> NoReturn:
    """Reject a command-line argument."""
    raise refusal((), fault, value, allowed, near, source)


def recorded(folder: Path) -> None:
    """Reject a folder without a recorded run."""
    if not (folder / "manifest.json").is_file():
        fault = "has no manifest.json" if folder.is_dir() else "no such folder"
        again = (
            f"; a run was killed there before it started: run it again with --out {shlex.quote(str(folder))}"
        )
        early = again if stopped_early(folder) else ""
        refuse("DIR", fault + early, str(folder), "a folder written by `ecs-eco run`")


def whole(least: int, most: int = 10**12) -> Callable[[str | int], int]:
    """Return a parser for command-line integers that quotes an invalid value in its error message."""

    def read(text: str | int) -> int:
        try:
            number = int(text)
        except ValueError:
            number = least - 1
        if not least <= number <= most:
            raise typer.BadParameter(
                f"{str(text)[:40]!r} is not valid; expected: an integer from {least} to {most}"
            )
        return number

    read.__name__ = "number"
    return read


def path_of(text: str | Path) -> Path:
    """Return the path of a file or folder named on the command line; reject invalid names."""
    # surrogates: the name is not UTF-8
    if not str(text).strip() or any(c == "\0" or "\ud800" <= c <= "\udfff" for c in str(text)):
        raise typer.BadParameter(f"{str(text)!r} is not valid; expected: the name of a file or folder")
    return Path(text)


class Progress:
    """A command's progress. Call it with the number of finished items and the total; it stores both. By the
    first call, the command must have loaded everything that it needs."""

    def __init__(self, show: Callable[[int, int], None] | None = None) -> None:
        self.done = self.total = 0
        self._show = show

    def __call__(self, done: int, total: int) -> None:
        if not self.done:
            loaded()
        self.done, self.total = done, total
        if self._show:
            self._show(done, total)


@contextmanager
def progress(word: str, quiet: bool, unit: str = "ticks") -> Iterator[Progress]:
    """Show progress on stderr: a bar on a terminal, otherwise an occasional line; show nothing if quiet."""
    columns = ("MofNCompleteColumn", unit, "TimeRemainingColumn")
    with shown(
        word,
        quiet,
        lambda done, total: f"{word}: {done} of {total} {unit}",
        lambda done, total: {"completed": done, "total": total},
        columns,
    ) as show:
        yield Progress(show)


@contextmanager
def shown(
    name: str,
    quiet: bool,
    line: Callable[..., str],
    state: Callable[..., dict[str, Any]],
    columns: Sequence[str],
) -> Iterator[Callable[..., None] | None]:
    """Yield a function that shows a command's progress: on a terminal as the `state` of a bar with `columns`
    (names of rich's classes, or texts), elsewhere as an occasional `line`. Yield None if quiet."""
    if quiet:
        yield None
    elif not sys.stderr.isatty():
        yield now_and_then(line)
    else:
        from rich import progress as rich
        from rich.console import Console

        made = [
            getattr(rich, of)() if of.endswith("Column") else rich.TextColumn(of, markup=False)
            for of in ("{task.description}", "BarColumn", *columns)
        ]
        with rich.Progress(*made, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(printable(name), total=None, text="")
            yield lambda *told: bar.update(task, **state(*told))


def now_and_then(line: Callable[..., str], every: float = 30.0) -> Callable[..., None]:
    """Return a function that prints `line(*arguments)`, at most once every `every` seconds."""
    last = time.monotonic()

    def show(*told: object) -> None:
        nonlocal last
        if time.monotonic() - last >= every:
            last = time.monotonic()
            complain(line(*told))

    return show


def stopped(done: int, ticks: int, out: Path) -> NoReturn:
    """End a command after Ctrl-C."""
    manifest = out / "manifest.json"
    done = read_note(manifest).get("done", done)
    kept = f"the recording up to that point is in {out}" if manifest.is_file() else "nothing was recorded"
    if any((out / "checkpoints").glob("tick-*")):
        kept += f"; resume with: ecs-eco resume {shlex.quote(str(out))}"
    complain(f"Stopped at tick {done} of {ticks}; {kept}")
    raise typer.Exit(INTERRUPTED)


def numbers(result: dict[str, Any]) -> str:
    """Return the run's timings, one per line."""
    return "".join(
        f"\n  {word.replace('_', ' ')}: {result[word]:.1f}" for word in result if word.endswith("_seconds")
    )
