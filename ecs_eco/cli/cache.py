"""The commands cache show, warm and clear, for compiled kernels kept between runs."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.options import Quiet, Trust, number
from ecs_eco.cli.terminal import complain, exits, progress, say
from ecs_eco.cli.trust import allow
from ecs_eco.compiled import kernel_folder
from ecs_eco.compiled.numba_version import plain
from ecs_eco.config import load
from ecs_eco.config.shipped import shipped
from ecs_eco.ecosystem import World
from ecs_eco.worlds import first_start

cache = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    help="Manage the cache of compiled kernels: show, warm and clear.",
)


@cache.command()
@exits
def show() -> None:
    """Print each folder of compiled kernels, the number of kernels and their size."""
    folder = kernel_folder.cache_folder()
    say(f"{folder}\n  {content_of(folder)}")
    known = sorted(mark.stem for mark in folder.glob(f"*{first_start.MARK}"))
    say(f"  complete for {', '.join(known)}" if known else "  not complete for any shipped world")
    for other in _others(folder):
        say(f"{other}, from another version or with different compiler settings\n  {content_of(other)}")


@cache.command()
@exits
def warm(
    worlds: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="WORLD...",
            show_default=False,
            help="Names of shipped worlds or TOML files. Default: all shipped worlds.",
        ),
    ] = None,
    workers: Annotated[
        int | None, number("Number of processes. Default: the number of cores.", most=1024)
    ] = None,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Compile the kernels of worlds in advance, so that their first start is as quick as later ones."""
    for world in worlds or []:
        allow(trust, world, None)

    listed = [] if plain() else shipped()  # worlds with listed kernels; other worlds run for a few ticks
    configs = {world: load(world) for world in worlds or (sorted(shipped()) if plain() else [])}
    folder, names = (
        kernel_folder.cache_folder(),
        list(dict.fromkeys(first_start.known_to_list(c.name) for c in configs.values())),
    )
    before = len(_kernels(folder))
    with progress("kernels", quiet, "kernels") as bar:
        if listed:
            first_start.warm(names or sorted(listed), workers or first_start.cores(), bar)
        for world, config in configs.items():
            if world not in listed:
                with first_start.two_processes("others"):
                    World.from_config(config, record=False).run(3)  # compiles its kernels
    after = len(_kernels(folder))
    say(f"{after - before} kernels compiled, {after} in total in {folder}")


@cache.command()
@exits
def clear(
    others: Annotated[bool, typer.Option("--others", help="Remove only kernels of other versions.")] = False,
) -> None:
    """Remove compiled kernels; they are recompiled when needed."""
    folder = kernel_folder.cache_folder()
    folders = _others(folder) if others else [*_others(folder), folder]
    removed = sum(_clear(one) for one in folders)
    say(f"{removed} kernels removed from {folder.parent}")


def _others(folder: Path) -> list[Path]:
    return [other for other in sorted(folder.parent.glob("kernels-*")) if other != folder and other.is_dir()]


def _kernels(folder: Path) -> list[Path]:
    return list(folder.rglob("*.nbc"))


def content_of(folder: Path) -> str:
    """Return the number and size of the kernels in a folder, in words."""
    sizes = [file.stat().st_size for file in _kernels(folder)]
    return f"{len(sizes)} kernels, {sum(sizes) / 1e6:.1f} MB"


def _clear(folder: Path) -> int:
    removed = len(_kernels(folder))
    ours = (
        "*.nbc",
        "*.nbi",
        f"*{kernel_folder.CLAIM}",
        f"*{first_start.MARK}",
        "*.nbc.*.tmp",
    )  # the contents of a kernel folder
    for file in [path for pattern in ours for path in folder.rglob(pattern)]:
        file.unlink(missing_ok=True)
    try:
        for part in sorted(
            filter(Path.is_dir, folder.rglob("*")), reverse=True
        ):  # numba's own cache may contain folders
            part.rmdir()
        folder.rmdir()
    except FileNotFoundError:
        pass
    except OSError as error:
        complain(f"{folder} was not removed: {error.strerror}")
    return removed
