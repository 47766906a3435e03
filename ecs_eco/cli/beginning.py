"""The commands new and world from-raster, which write a starter world or package."""

import shlex
from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.terminal import exits, path_of, refuse, say
from ecs_eco.templates import new_package, new_world, world_from_raster


@exits
def new(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="NAME",
            parser=path_of,
            show_default=False,
            help="New folder; its name becomes the name of the world or package.",
        ),
    ],
    origin: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="WORLD",
            show_default=False,
            help="meadow (grass and rabbits; the default), blank (moss), or predator-prey (the shipped world).",
        ),
    ] = None,
    package: Annotated[
        bool,
        typer.Option(
            "--package", help="Write a Python package instead: a component, a system, a world and tests."
        ),
    ] = False,
) -> None:
    """Write a starter world: a world file, a system and its test."""
    if package and origin is not None:
        refuse("--from", "cannot be used with --package", origin, "only one of these options")
    files = new_package(folder) if package else new_world(folder, origin or "meadow")
    for file in files:
        say(f"  {file}")
    how = (
        f'pip install -e "{folder}[test]", then python -m pytest {shlex.quote(str(folder))}'
        if package
        else f"ecs-eco run {shlex.quote(f'{folder / folder.name}.toml')} --trust --out my-run"
    )
    say(f"Continue with {folder / 'README.md'}, or run it now: {how}")


world = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    help="Write a world file: world from-raster RASTER [FILE].",
)


@world.callback()
def _world() -> None:
    """Make `world` a command group, although it has only one command."""


@world.command("from-raster")
@exits
def from_raster(
    raster: Annotated[
        str,
        typer.Argument(
            metavar="RASTER",
            help="Elevations [m]: .npz, .asc (ESRI ASCII grid) or, with rasterio, GeoTIFF or any other "
            "GDAL format.",
        ),
    ],
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE",
            parser=path_of,
            show_default=False,
            help="World file to write. Default: named after the raster, in the current folder.",
        ),
    ] = None,
    band: Annotated[
        str | None,
        typer.Option(metavar="N", help="Band number, from 1, or band name. Default: the first band."),
    ] = None,
    cell: Annotated[
        float | None,
        typer.Option(metavar="METERS", help="Cell size of the height map. Default: as in the raster."),
    ] = None,
    crs: Annotated[
        str | None,
        typer.Option(
            metavar="CODE", help="Coordinate system, if the raster has none, such as EPSG:4326 for degrees."
        ),
    ] = None,
) -> None:
    """Write a starter world on real land, with grass and climbing deer."""
    number = int(band) if band is not None and band.isdecimal() else band
    path = world_from_raster(raster, file, band=number, cell=cell, crs=crs)
    say(f"  {path}")
    say(f"Watch it: ecs-eco watch {path}; or run it: ecs-eco run {path}")
