"""The commands report, why, lineage and tracks, which describe what happened in a run."""

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from ecs_eco.analysis.archipelago import write_archipelago
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.report import write_report
from ecs_eco.analysis.runs import parts
from ecs_eco.analysis.why import write_why
from ecs_eco.cli.folders import pages
from ecs_eco.cli.options import Of, Run, new_folder
from ecs_eco.cli.terminal import exits, path_of, printable, recorded, refuse, say
from ecs_eco.config.models.archipelago import Archipelago
from ecs_eco.engine.errors import listed, nearest
from ecs_eco.record import archipelago
from ecs_eco.record.geodata import write_tracks


@exits
def report(
    folder: Run,
    out: Annotated[Path | None, new_folder("Folder for report.html and the figures. Default: DIR.")] = None,
    against: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="CSV of measurements to show alongside: time in the first column, then numbers.",
        ),
    ] = None,
    match: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COLUMN=SPECIES",
            help="Compare a column of FILE with this species. Repeatable. Default: the column's name.",
        ),
    ] = None,
) -> None:
    """Draw a run's figures and write its report."""
    pairs = dict(text.partition("=")[::2] for text in match or ())
    if wrong := next((text for text in match or () if text.count("=") != 1), None):
        refuse("--match", "is not a pair", wrong, "COLUMN=SPECIES")
    if match and against is None:
        refuse("--match", "needs --against", match[0], "both options")
    if archipelago.is_archipelago(folder):
        if against is not None:
            refuse("--against", "cannot be used with an archipelago", str(against), "an island's folder")

        pages(out, folder)
        return say(f"written: {write_archipelago(folder, out)}")
    recorded(folder)

    pages(out, folder)
    say(f"written: {write_report(folder, out, against, pairs)}")


@exits
def why(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="A folder written by `run`; the run may be unfinished.")
    ],
    out: Annotated[
        Path | None, new_folder("Folder for why.html, why.json and the figure. Default: DIR.")
    ] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print why.json instead of sentences.")] = False,
) -> None:
    """Explain what happened in a run and why, and suggest values to change."""
    if archipelago.is_archipelago(folder):
        names = Archipelago.model_validate(archipelago.read(folder)["config"]["archipelago"]).names
        refuse(
            "DIR",
            "is an archipelago; name one of its islands",
            str(folder),
            f"a run folder, such as {folder}/islands/{names[0]}",
        )
    recorded(folder)

    if not parts(folder, "series"):
        refuse("DIR", "contains no series", str(folder), "a run of at least one tick")
    pages(out, folder)
    findings = write_why(folder, out)
    if json_:
        return say(
            json.dumps({k: v for k, v in findings.items() if k != "sentences"}, indent=1, ensure_ascii=False)
        )
    _print_blocks(findings["sentences"])
    say(f"\nwritten: {(out or folder) / 'why.html'}")


def _print_blocks(blocks: dict[str, list[str]]) -> None:
    """Print sentences under their headings, wrapped to the terminal's width."""
    console: Any = Console(file=sys.stdout, highlight=False, width=None if sys.stdout.isatty() else 110)
    for head, lines in blocks.items():
        console.print(Text(printable(f"\n{head}" if head != next(iter(blocks)) else head), style="bold"))
        for line in lines:
            console.print(Padding(Text(printable(line)), (0, 0, 0, 2)))


@exits
def lineage(
    folder: Run,
    csv: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the phylogeny in the ALife standard format.")
    ] = None,
    newick: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the tree of first parents in the Newick format."),
    ] = None,
    species: Of = None,
    living: Annotated[
        bool,
        typer.Option(
            "--living", help="Write only living organisms and their ancestors; in a tree, only first parents."
        ),
    ] = False,
) -> None:
    """Summarize the lineages of a run, and write them to files."""
    if not archipelago.is_archipelago(folder):
        recorded(folder)
        if not parts(folder, "births"):
            refuse("DIR", "contains no births", str(folder), "a run with organisms")
    for option, file in (("--csv", csv), ("--newick", newick)):
        if file is not None and (file.is_dir() or not file.parent.is_dir()):
            refuse(
                option,
                "is a folder" if file.is_dir() else "its folder does not exist",
                str(file),
                "a file in an existing folder",
            )
    try:
        descent = Lineage.read(folder)
    except ValueError as error:
        refuse(
            "DIR",
            f"contains inconsistent births and deaths: {error}",
            str(folder),
            "an unmodified folder written by `ecs-eco run`",
        )
    known = list(dict.fromkeys(descent.species.tolist()))
    if species is not None:
        if species not in known:
            refuse(
                "--species", "no such species in this run", species, listed(known), nearest(species, known)
            )
        descent = descent.of_species(species)
    for name in known if species is None else [species]:
        say(_summary(descent.of_species(name), name))
    if csv is not None:
        say(f"written: {(descent.living() if living else descent).to_csv(csv)}")
    if newick is not None:
        descent.to_newick(newick, living=living)
        say(f"written: {newick}")


def _summary(lineage: Lineage, name: str) -> str:
    """Return a short summary of a species' lineage."""
    founders, alive = int(lineage.founders.sum()), lineage.alive(lineage.end)
    mean = f"{lineage.generation()[alive].mean():.1f}" if alive.any() else "none alive"
    return "\n".join(
        [
            name,
            f"  without parents: {founders:,}",
            f"  born to parents: {len(lineage) - founders:,}",
            f"  alive at tick {lineage.end:,}: {int(alive.sum()):,}",
            f"  their mean generation: {mean}",
            f"  founders with living descendants: {len(lineage.founders_left()):,}",
        ]
    )


@exits
def tracks(
    folder: Run,
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            parser=path_of,
            help="A .gpkg (GeoPackage; needs pyogrio), .parquet (GeoParquet) or .csv file.",
        ),
    ],
    species: Of = None,
    lines: Annotated[
        bool, typer.Option("--lines", help="Write each organism's path as a line instead of points.")
    ] = False,
) -> None:
    """Export the positions of organisms as geographic data."""
    recorded(folder)
    written = write_tracks(folder, file, species, lines)
    say(
        f"{written.places:,} positions of {written.individuals:,} organisms in {file}, in "
        f"{written.crs or 'meters from the southwest corner of the world'}"
    )
