"""Output of the commands, and their exit codes."""

from __future__ import annotations

import json
import re
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

_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
# exit codes: a negative result or failed work; refused input; Ctrl-C
FAILED, REFUSED, INTERRUPTED = 1, 2, 130


def printable(text: str) -> str:
    """Return a text from a world, a file or an error, safe for terminals: control characters as \u001b,
    newlines and tabs unchanged.

    Control characters are C0, DEL and C1, line and paragraph separators, and the marks that change the
    direction of writing.
    """
    return _CONTROL.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def say(text: str) -> None:
    """Print a line on stdout; all output passes through this function or `printable`.

    Names that are not UTF-8 are escaped, as on stderr.
    """
    typer.echo(printable(text))


def complain(text: str) -> None:
    """Print a line on stderr."""
    typer.echo(printable(text), err=True)


def exits(command: Callable[..., None]) -> Callable[..., None]:
    """Wrap a command: refused input ends it with code 2 and one screen of text, Ctrl-C with code 130."""

    @wraps(command)
    def wrapped(*args: object, **kwargs: object) -> None:
        try:
            command(*args, **kwargs)
        except (ConfigError, RecordingError, CheckpointError) as error:
            complain(str(error))
            raise typer.Exit(FAILED if isinstance(error, Halted) else REFUSED) from None
        except MemoryError as error:
            complain(f"Not enough memory: {error or 'a smaller world needs less'}")
            raise typer.Exit(FAILED) from None
        except FloatingPointError as error:
            complain(
                f"{error}\nThe recording until then is complete; any checkpoints are in the folder "
                "checkpoints/ of the run."
            )
            raise typer.Exit(FAILED) from None
        except OSError as error:
            if isinstance(error, BrokenPipeError):
                raise  # the reader of the output has exited: click exits quietly
            if isinstance(error, FileNotFoundError) and error.filename is None:  # no run in this folder
                complain(str(error))
                raise typer.Exit(REFUSED) from None
            name = f"{error.filename}: " if error.filename else ""
            complain(f"{name}{error.strerror or error}; files written before are complete.")
            raise typer.Exit(FAILED) from None
        except KeyboardInterrupt:
            complain("Stopped before anything was recorded.")
            raise typer.Exit(INTERRUPTED) from None

    return wrapped


def refuse(source: str, fault: str, value: object, allowed: str, near: str = "") -> NoReturn:
    """Refuse an argument of the command line."""
    raise refusal((), fault, value, allowed, near, source)


def recorded(folder: Path) -> None:
    """Refuse a folder without a recorded run."""
    if not (folder / "manifest.json").is_file():
        fault = "has no manifest.json" if folder.is_dir() else "no such folder"
        refuse("DIR", fault, str(folder), "a folder written by `ecs-eco run`")


def whole(least: int, most: int = 10**12) -> Callable[[str | int], int]:
    """Return a parser for an integer from the command line; the error shows an invalid value."""

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
    """Return the path of a folder named on the command line; refuse ""."""
    # the last case: not UTF-8
    if not str(text).strip() or any(c == "\0" or "\ud800" <= c <= "\udfff" for c in str(text)):
        raise typer.BadParameter(f"{str(text)!r} is not valid; expected: the name of a folder")
    return Path(text)


class Progress:
    """The progress of a command: call it with the finished and the total number, which it keeps. After the
    first call, everything that the command needs exists."""

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
    """Show a progress bar on stderr if that is a terminal, else a line now and then; nothing if quiet."""
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
    """Yield a function that shows the progress of a command, in a `line` now and then or as the `state` of
    a bar on a terminal, whose columns are classes of rich or texts; None if quiet."""
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
    """Return a function that prints the line of its arguments, at most once in so many seconds."""
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
    if manifest.is_file():
        done = json.loads(manifest.read_text(encoding="utf-8")).get("done", done)
    kept = f"the recording until then is in {out}" if manifest.is_file() else "nothing was recorded"
    if any((out / "checkpoints").glob("tick-*")):
        kept += f"; continue with: ecs-eco resume {out}"
    complain(f"Stopped at tick {done} of {ticks}; {kept}.")
    raise typer.Exit(INTERRUPTED)


def numbers(result: dict[str, Any]) -> str:
    """Return the times of a run, a line each."""
    return "".join(
        f"\n  {word.replace('_', ' ')}: {result[word]:.1f}" for word in result if word.endswith("_seconds")
    )
