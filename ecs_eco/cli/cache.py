"""cache: what is kept of compiled kernels, and where."""

from __future__ import annotations

from pathlib import Path

from ecs_eco.cli.terminal import complain, progress, say
from ecs_eco.config import load
from ecs_eco.config.shipped import shipped
from ecs_eco.engine.kernel_cache import CLAIM, cache_folder
from ecs_eco.worlds.first_start import MARK, cores, known_to_list, two_processes, warm

OURS = ("*.nbc", f"*{CLAIM}", f"*{MARK}", "*.nbc.*.tmp")  # what is in a folder of kernels


def show_cache() -> None:
    """Print the folder of compiled kernels, how many they are, and what is left of other versions."""
    folder = cache_folder()
    say(f"{folder}\n  {_content(folder)}")
    known = sorted(mark.stem for mark in folder.glob(f"*{MARK}"))
    say(f"  all that is listed of {', '.join(known)}" if known else "  of no world all that is listed")
    for other in _others(folder):
        say(f"{other}, of another version, or of other switches of the compiler\n  {_content(other)}")


def clear_cache(others: bool) -> None:
    """Remove compiled kernels, of all versions or of all but this one."""
    folder = cache_folder()
    folders = _others(folder) if others else [*_others(folder), folder]
    removed = sum(_clear(one) for one in folders)
    say(f"{removed} kernels removed below {folder.parent}")


def warm_cache(worlds: list[str], workers: int | None, quiet: bool) -> None:
    """Compile what worlds need, in several processes; without worlds that of all shipped ones."""
    configs = {world: load(world) for world in worlds}
    folder, names = cache_folder(), list(dict.fromkeys(known_to_list(c.name) for c in configs.values()))
    before = len(list(folder.glob("*.nbc")))
    with progress("kernels", quiet, "kernels") as bar:
        warm(names or sorted(shipped()), workers or cores(), bar)
        for world, config in configs.items():
            if world not in shipped():
                _try(config)
    say(
        f"{len(list(folder.glob('*.nbc'))) - before} kernels compiled, "
        f"{len(list(folder.glob('*.nbc')))} are in {folder}"
    )


def _try(config: object) -> None:
    """Let a world live for some ticks, which compiles what it calls then."""
    from ecs_eco.ecosystem import World

    with two_processes("others"):
        World.from_config(config, record=False).run(3)


def _others(folder: Path) -> list[Path]:
    return [other for other in sorted(folder.parent.glob("kernels-*")) if other != folder and other.is_dir()]


def _content(folder: Path) -> str:
    sizes = [file.stat().st_size for file in folder.glob("*.nbc")]
    return f"{len(sizes)} kernels, {sum(sizes) / 1e6:.1f} MB"


def _clear(folder: Path) -> int:
    removed = len(list(folder.glob("*.nbc")))
    for file in [path for pattern in OURS for path in folder.glob(pattern)]:
        file.unlink(missing_ok=True)
    try:
        folder.rmdir()
    except FileNotFoundError:
        pass
    except OSError as error:
        complain(f"{folder} stays: {error.strerror}")
    return removed
