"""The command doctor: the settings that affect results, and whether results agree with the release."""

import os
import platform
import shutil
import stat
import tempfile
import warnings
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ecs_eco import __version__
from ecs_eco.cli.cache import content_of
from ecs_eco.cli.docs import graphical
from ecs_eco.cli.options import Quiet
from ecs_eco.cli.terminal import FAILED, complain, exits, progress, say
from ecs_eco.compiled import jit, numba_version, portable
from ecs_eco.testing import self_test
from ecs_eco.testing.browser import chromium
from ecs_eco.testing.target import OTHERS, Target, instructions, target, versions

Facts = list[tuple[str, str]]


@exits
def doctor(
    test: Annotated[
        bool, typer.Option("--test/--no-test", help="Run the self-test, which takes up to a minute.")
    ] = True,
    quiet: Quiet = False,
) -> None:
    """Print the settings that affect results, and compare results with the release; exit code 1 if any differ."""
    here = target()
    console = Console(highlight=False, soft_wrap=True)
    sections = {
        "Versions": _versions(here),
        "Processor": _processor(here),
        "Kernels and disk": _disk(),
        "Viewer": _viewer(),
    }
    for title, facts in sections.items():
        table = Table(
            title=title, title_justify="left", title_style="bold", box=None, show_header=False, pad_edge=False
        )
        table.add_column(style="dim")
        table.add_column(overflow="fold")
        for name, value in facts:
            table.add_row(name, escape(value))
        console.print(table, end="\n\n")
    if test:
        _self_test(here, quiet, console)


def _self_test(here: Target, quiet: bool, console: Console) -> None:
    with progress("self-test", quiet, "worlds") as bar:
        outcomes = self_test.examine_all(self_test.cases(), bar)
    other = self_test.differing(outcomes, here)
    console.print(_table(outcomes, other), end="\n\n")
    failed = [outcome.case.name for outcome in outcomes if not outcome.holds]
    if failed:
        complain(
            f"On this machine, results depend on threads or checkpoints: {'; '.join(failed)}. Please report "
            "this together with all output above."
        )
    if other is None:
        say(
            "Unknown target: this release was not tested on this kind of machine with these package versions.\n"
            f"Target: {here.key}"
        )
    elif other:
        complain(
            f"Results differ from those of the release on this kind of machine: {'; '.join(other)}. "
            f"The source code may have been changed, or the installation damaged.\nTarget: {here.key}"
        )
    if failed or other:
        raise typer.Exit(FAILED)
    compared = "" if other is None else ", and agree with the release"
    say(f"All results are the same with one thread, with two, and from a checkpoint{compared}.")


def _table(outcomes: list[self_test.Outcome], other: list[str] | None) -> Table:
    table = Table(
        title=f"Self-test: {len(outcomes)} short runs",
        title_justify="left",
        title_style="bold",
        box=None,
        pad_edge=False,
    )
    for name in ("world", "two threads", "from a checkpoint", "as released", "digest"):
        table.add_column(name, header_style="dim")
    word = {True: "[green]same[/]", False: "[red]DIFFERENT[/]"}
    for outcome in outcomes:
        known = "unknown" if other is None else word[outcome.case.name not in other]
        same = (
            word[other_digest == outcome.digest] for other_digest in (outcome.two_threads, outcome.resumed)
        )
        table.add_row(outcome.case.name, *same, known, outcome.digest[:12])
    return table


def _versions(here: Target) -> Facts:
    inside = {**here.versions, "python": platform.python_version(), **versions(OTHERS)}
    return [("ecs-eco", f"{__version__}, in {Path(__file__).parents[1]}"), *inside.items()]


def _processor(here: Target) -> Facts:
    triple, _, features = instructions()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    variables = [
        f"{name}={os.environ[name]}"
        for name in sorted(os.environ)
        if name.startswith(("OMP_", "MKL_", "NUMBA_", "ECS_ECO_"))
    ]
    return [
        (
            "mode",
            "portable: the same bytes on every x86-64 machine"
            if portable.on()
            else "native: the fastest code for this processor; --portable computes the same bytes on every "
            "x86-64 machine",
        ),
        ("system", f"{platform.system()} {platform.release()}"),
        ("numba", f"{here.cpu}, {triple}, {len(features)} features ({here.features})"),
        ("kernels", numba_version.summary()),
        ("torch", here.torch),
        ("cores", f"{cores} of {os.cpu_count()} available to this process"),
        ("threads", "1, or as set by --threads; results do not depend on it"),
        ("variables", ", ".join(variables) or "none that affect compilers or threads"),
    ]


def _disk() -> Facts:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        usable = jit.FOLDER.usable()
    path, facts = jit.FOLDER.path, []
    if path.is_dir():
        about = f"owner {_owner(path)}, mode {stat.S_IMODE(path.lstat().st_mode):04o}"
        facts += [("cache", str(path)), ("", f"{about}, {content_of(path)}")]
    if not usable:
        facts.append(("cache", f"NOT USED: {caught[0].message if caught else path}"))
    places = {
        "cache": path if path.is_dir() else Path.home(),
        "here": Path.cwd(),
        "temporary": Path(tempfile.gettempdir()),
    }
    for name, place in places.items():
        try:
            facts.append((f"free, {name}", f"{shutil.disk_usage(place).free / 1e9:.1f} GB in {place}"))
        except OSError as error:
            facts.append((f"free, {name}", f"{place}: {error.strerror or error}"))
    return facts


def _owner(path: Path) -> str:
    try:
        return path.owner()
    except (KeyError, NotImplementedError):  # the user has no name, or the system has no user names
        return str(path.lstat().st_uid)


def _viewer() -> Facts:
    return [
        (
            "browser",
            "opened by `ecs-eco watch`"
            if graphical()
            else "cannot be opened here; `ecs-eco watch` prints an address",
        ),
        ("Chromium", chromium() or "not installed; only tests and screenshots need it"),
    ]
