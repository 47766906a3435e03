"""Commands that describe and draw a run: report, why, lineage, tracks, draw, picture, video."""

from pathlib import Path
from typing import Annotated

import typer

from ecs_eco.cli.options import Quiet, Run, Set, Size, Trust, World
from ecs_eco.cli.terminal import exits, path_of, whole
from ecs_eco.cli.trust import allow


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
    from ecs_eco.cli.simulate import report_run

    report_run(folder, out, against, match or ())


@exits
def why(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="A folder written by `run`, finished or not.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            parser=path_of, metavar="PATH", help="Folder for why.html, why.json and the figure. Default: DIR."
        ),
    ] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print why.json instead of sentences.")] = False,
) -> None:
    """Explain what happened in a run, why, and which values to change."""
    from ecs_eco.cli.why import tell_why

    tell_why(folder, out, json_)


@exits
def lineage(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder written by `run`.")],
    csv: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a phylogeny in the ALife standard format.")
    ] = None,
    newick: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the tree along first parents.")
    ] = None,
    species: Annotated[str | None, typer.Option(metavar="NAME", help="One species alone.")] = None,
    living: Annotated[
        bool,
        typer.Option(
            "--living",
            help="Write only the living and their ancestors; in a tree, those along first parents.",
        ),
    ] = False,
) -> None:
    """Print and write the lineages of a run."""
    from ecs_eco.cli.lineage import tell_lineage

    tell_lineage(folder, csv, newick, species, living)


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
    from ecs_eco.cli.terminal import say
    from ecs_eco.record.geodata import write_tracks

    written = write_tracks(folder, file, species, lines)
    say(
        f"{written.places:,} places of {written.individuals:,} organisms in {file}, in "
        f"{written.crs or 'metres from the south-west corner of the world'}"
    )


@exits
def draw(
    world: World,
    species: Annotated[
        str | None, typer.Option(metavar="NAME", help="A species. Default: all that have a nervous system.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="A file ending in .png, .svg or .pdf. Default: WORLD-NAME.png here."
        ),
    ] = None,
    set_: Set = None,
) -> None:
    """Draw the nervous systems of a world's species."""
    from ecs_eco.cli.draw import draw_world

    draw_world(world, set_ or [], species, out)


@exits
def picture(
    folder: Run,
    out: Annotated[
        Path | None, typer.Argument(metavar="FILE", help="A PNG. Default: WORLD-TICK.png here.")
    ] = None,
    tick: Annotated[
        int | None, typer.Option(parser=whole(0), metavar="T", help="The tick. Default: the last one.")
    ] = None,
    organism: Annotated[
        int | None,
        typer.Option(
            parser=whole(1, 2**63 - 1),
            metavar="UID",
            help="Draw the nervous system of this organism at that tick.",
        ),
    ] = None,
    size: Size = "1280x720",
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Draw a tick of a recorded run."""
    allow(trust, folder)
    from ecs_eco.cli.picture import picture_run

    picture_run(folder, out, tick, organism, size, quiet)


@exits
def video(
    folder: Run,
    out: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE",
            help="Ends in .mp4, .mkv, .mov or .webm, which need ffmpeg, or in .gif. Default: WORLD.mp4 here.",
        ),
    ] = None,
    fps: Annotated[float, typer.Option(metavar="N", help="Frames a second.")] = 30.0,
    from_: Annotated[
        int | None, typer.Option("--from", parser=whole(0), metavar="T", help="First tick.")
    ] = None,
    to: Annotated[int | None, typer.Option(parser=whole(0), metavar="T", help="Last tick.")] = None,
    step: Annotated[
        int | None,
        typer.Option(
            parser=whole(1),
            metavar="N",
            help="Ticks between frames. Default: those of a film of at most a minute.",
        ),
    ] = None,
    size: Size = "1280x720",
    quiet: Quiet = False,
) -> None:
    """Make a film of a recorded run."""
    from ecs_eco.cli.picture import video_run

    video_run(folder, out, fps, from_, to, step, size, quiet)
