"""The command lineage: descent in a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ecs_eco.cli.terminal import exits, recorded, refuse, say

if TYPE_CHECKING:
    from ecs_eco.analysis.lineage import Lineage


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
    from ecs_eco.analysis.lineage import Lineage
    from ecs_eco.analysis.runs import parts
    from ecs_eco.engine.errors import listed, nearest
    from ecs_eco.record.archipelago import is_archipelago

    if not is_archipelago(folder):
        recorded(folder)
        if not parts(folder, "births"):
            refuse("DIR", "holds no births", str(folder), "a run with organisms")
    for option, file in (("--csv", csv), ("--newick", newick)):
        if file is not None and (file.is_dir() or not file.parent.is_dir()):
            refuse(
                option,
                "is a folder" if file.is_dir() else "its folder does not exist",
                str(file),
                "a file in a folder that exists",
            )
    try:
        descent = Lineage.read(folder)
    except ValueError as error:
        refuse(
            "DIR",
            f"its births and deaths are inconsistent: {error}",
            str(folder),
            "a folder as `ecs-eco run` left it",
        )
    known = list(dict.fromkeys(descent.species.tolist()))
    if species is not None:
        if species not in known:
            refuse(
                "--species", "no such species in this run", species, listed(known), nearest(species, known)
            )
        descent = descent.of_species(species)
    for name in known if species is None else [species]:
        say(summary(descent.of_species(name), name))
    if csv is not None:
        say(f"written: {(descent.living() if living else descent).to_csv(csv)}")
    if newick is not None:
        descent.to_newick(newick, living=living)
        say(f"written: {newick}")


def summary(lineage: Lineage, name: str) -> str:
    """A summary of a species' lineage, in a few lines."""
    founders, alive = int(lineage.founders.sum()), lineage.alive(lineage.end)
    mean = f"{lineage.generation()[alive].mean():.1f}" if alive.any() else "nobody lives"
    lines = [
        name,
        f"  without parents: {founders:,}",
        f"  born of parents: {len(lineage) - founders:,}",
        f"  alive at tick {lineage.end:,}: {int(alive.sum()):,}",
        f"  their mean generation: {mean}",
        f"  founders with surviving lines: {len(lineage.founders_left()):,}",
    ]
    return "\n".join(lines)
