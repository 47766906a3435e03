"""The command that writes a world or a package to begin with: new."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.terminal import exits, path_of, refuse, say


@exits
def new(
    folder: Annotated[Path, typer.Argument(metavar="NAME", parser=path_of, show_default=False,
                                           help="A new folder; the world or the package has its name.")],
    origin: Annotated[str | None, typer.Option(
        "--from", metavar="WORLD", show_default=False,
        help="meadow (grass and rabbits; the default), blank (moss), or predator-prey, as shipped.")] = None,
    package: Annotated[bool, typer.Option(
        "--package", help="A Python package instead: a component, a system, a world, and tests.")] = False,
) -> None:
    """Write a world of your own to begin with: a file, a system and its test."""
    from ecs_eco.templates import new_package, new_world

    if package and origin is not None:
        refuse("--from", "does not go with --package", origin, "one of the two")
    files = new_package(folder) if package else new_world(folder, origin or "meadow")
    for file in files:
        say(f"  {file}")
    how = (f'pip install -e "{folder}[test]", then python -m pytest {folder}' if package
           else f"ecs-eco run {folder / folder.name}.toml --trust --out my-run")
    say(f"Go on with {folder / 'README.md'}, or at once: {how}")
