"""lineage: descent in a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.runs import parts
from ecs_eco.cli.terminal import refuse, say
from ecs_eco.engine.errors import listed, nearest
from ecs_eco.record.archipelago import is_archipelago


def tell_lineage(
    folder: Path, csv: Path | None, newick: Path | None, species: str | None, living: bool
) -> None:
    """Print founders, births, generations and surviving founder lines of each species,
    and write the files requested."""
    islands = is_archipelago(folder)
    if not islands and not (folder / "manifest.json").is_file():
        fault = "has no manifest.json" if folder.is_dir() else "no such folder"
        refuse("DIR", fault, str(folder), "a folder written by `ecs-eco run`")
    if not islands and not parts(folder, "births"):
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
        lineage = Lineage.read(folder)
    except ValueError as error:
        refuse(
            "DIR",
            f"its births and deaths are inconsistent: {error}",
            str(folder),
            "a folder as `ecs-eco run` left it",
        )
    known = list(dict.fromkeys(lineage.species.tolist()))
    if species is not None:
        if species not in known:
            refuse(
                "--species", "no such species in this run", species, listed(known), nearest(species, known)
            )
        lineage = lineage.of_species(species)
    for name in known if species is None else [species]:
        say(summary(lineage.of_species(name), name))
    if csv is not None:
        say(f"written: {(lineage.living() if living else lineage).to_csv(csv)}")
    if newick is not None:
        lineage.to_newick(newick, living=living)
        say(f"written: {newick}")


def summary(lineage: Lineage, name: str) -> str:
    """A summary of a species' lineage, in a few lines."""
    founders, alive = int(lineage.founders.sum()), lineage.alive(lineage.end)
    mean = f"{lineage.generation()[alive].mean():.1f}" if alive.any() else "nobody lives"
    lines = [
        name,
        f"  without parents: {founders:,}",
        f"  born of parents: {len(lineage) - founders:,}",
        f"  alive at tick {lineage.end:,}: {int(np.count_nonzero(alive)):,}",
        f"  their mean generation: {mean}",
        f"  founders with surviving lines: {len(lineage.founders_left()):,}",
    ]
    return "\n".join(lines)
