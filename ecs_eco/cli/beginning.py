"""Commands that write a world or a package to begin with: new, world from-raster."""

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
            help="A new folder; the world or the package has its name.",
        ),
    ],
    origin: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="WORLD",
            show_default=False,
            help="meadow (grass and rabbits; the default), blank (moss), or predator-prey, as shipped.",
        ),
    ] = None,
    package: Annotated[
        bool,
        typer.Option(
            "--package", help="A Python package instead: a component, a system, a world, and tests."
        ),
    ] = False,
) -> None:
    """Write a world of your own to begin with: a file, a system and its test."""
    if package and origin is not None:
        refuse("--from", "does not go with --package", origin, "one of the two")
    files = new_package(folder) if package else new_world(folder, origin or "meadow")
    for file in files:
        say(f"  {file}")
    how = (
        f'pip install -e "{folder}[test]", then python -m pytest {folder}'
        if package
        else f"ecs-eco run {folder / folder.name}.toml --trust --out my-run"
    )
    say(f"Go on with {folder / 'README.md'}, or at once: {how}")


world = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    help="Write a world file: world from-raster RASTER [FILE].",
)


@world.callback()
def _world() -> None:
    """Have commands below it, though there is one."""


@world.command("from-raster")
@exits
def from_raster(
    raster: Annotated[
        str,
        typer.Argument(
            metavar="RASTER",
            help="Elevations [m]: .npz, .asc (ESRI ASCII "
            "grid) or, with rasterio, GeoTIFF and all else that GDAL reads.",
        ),
    ],
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE",
            parser=path_of,
            show_default=False,
            help="The world file. Default: named as the raster, here.",
        ),
    ] = None,
    band: Annotated[
        str | None, typer.Option(metavar="N", help="The band, from 1, or its name. Default: the first one.")
    ] = None,
    cell: Annotated[
        float | None,
        typer.Option(
            metavar="METRES", help="Side of the cells of the height map. Default: that of the raster."
        ),
    ] = None,
    crs: Annotated[
        str | None,
        typer.Option(
            metavar="CODE", help="Coordinate system, where the raster does not say it: EPSG:4326 for degrees."
        ),
    ] = None,
) -> None:
    """Write a first world on real land: grass, and deer that climb."""
    number = int(band) if band is not None and band.isdecimal() else band
    path = world_from_raster(raster, file, band=number, cell=cell, crs=crs)
    say(f"  {path}")
    say(f"Look at it: ecs-eco watch {path}; or run it: ecs-eco run {path}")
