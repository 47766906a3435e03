"""The commands report and tracks: figures and places of a run."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.terminal import exits, path_of, recorded, refuse, say


@exits
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder written by `run`.")],
    out: Annotated[
        Path | None,
        typer.Option(
            parser=path_of, metavar="PATH", help="Folder for report.html and the figures. Default: DIR."
        ),
    ] = None,
    against: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Show measurements beside it: a CSV, time and then numbers."),
    ] = None,
    match: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COLUMN=SPECIES",
            help="The species that a column of FILE stands beside. Repeatable. Default: that of its name.",
        ),
    ] = None,
) -> None:
    """Draw the figures of a run."""
    from ecs_eco.cli.folders import pages
    from ecs_eco.record.archipelago import is_archipelago

    pairs = dict(text.partition("=")[::2] for text in match or ())
    if wrong := next((text for text in match or () if text.count("=") != 1), None):
        refuse("--match", "is no pair", wrong, "COLUMN=SPECIES")
    if match and against is None:
        refuse("--match", "is given without --against", match[0], "both")
    if is_archipelago(folder):
        if against is not None:
            refuse("--against", "is not possible for an archipelago", str(against), "the folder of an island")
        from ecs_eco.analysis.report.archipelago import write_archipelago

        pages(out, folder)
        return say(f"written: {write_archipelago(folder, out)}")
    recorded(folder)
    from ecs_eco.analysis.report import write_report

    pages(out, folder)
    say(f"written: {write_report(folder, out, against, pairs)}")


@exits
def tracks(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder written by `run`.")],
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            parser=path_of,
            help="Ends in .gpkg (GeoPackage, needs pyogrio), .parquet (GeoParquet) or .csv.",
        ),
    ],
    species: Annotated[str | None, typer.Option(metavar="NAME", help="One species alone.")] = None,
    lines: Annotated[
        bool, typer.Option("--lines", help="Write the way of each organism, not its places.")
    ] = False,
) -> None:
    """Write where organisms were, as geographic data."""
    from ecs_eco.record.geodata import write_tracks

    written = write_tracks(folder, file, species, lines)
    say(
        f"{written.places:,} places of {written.individuals:,} organisms in {file}, in "
        f"{written.crs or 'metres from the south-west corner of the world'}"
    )
