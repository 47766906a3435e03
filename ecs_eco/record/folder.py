"""A run that leaves a folder: manifest, Parquet series, births, deaths and snapshots, figures and a report."""

import json
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.engine import files

VERSIONS = ("ecs-eco", "esper", "numpy", "numba", "torch", "pyarrow")


class Folder:
    """The folder of one run. Every file in it is whole: written beside, synced, renamed."""

    def __init__(self, path: Path, world: Any) -> None:
        from ecs_eco.record.parquet import to_arrow, write_part

        self.path, self.world = path, world
        self.parts = dict.fromkeys(("series", "births", "deaths", "snapshots"), 0)
        self._to_arrow, self._write_part = to_arrow, write_part

    def sink(self, kind: str, columns: dict[str, np.ndarray]) -> None:
        """Write one block of rows as a Parquet part."""
        words = {"species": self.world.recorder.names} if "species" in columns else {}
        if kind == "deaths":
            columns = columns | {"cause": columns["cause"].astype(np.int32) - 1}
            words["cause"] = self.world.causes
        folder = self.path / kind
        folder.mkdir(exist_ok=True)
        self.parts.setdefault(kind, 0)
        self._write_part(self._to_arrow(columns, words), folder / f"part-{self.parts[kind]:05d}.parquet")
        self.parts[kind] += 1

    def forget_later(self) -> None:
        """Remove parts from the next number on, and what was half-written: they are of ticks that will be recorded again."""
        kinds = self.parts | {folder.name: 0 for folder in self.path.glob("details-*") if folder.name not in self.parts}
        for kind, number in kinds.items():
            for part in (self.path / kind).glob("part-*.parquet"):
                if not part.stem.removeprefix("part-").isdecimal() or int(part.stem.removeprefix("part-")) >= number:
                    part.unlink()
        for half in self.path.rglob("*.tmp"):
            half.unlink()


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file so that it is whole or as it was before."""
    files.write(path, json.dumps(content, indent=1, allow_nan=False))


def versions() -> dict[str, str]:
    """Return the versions of what decides a result."""
    import platform

    found = {"python": platform.python_version()}
    for name in VERSIONS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def git_commit() -> str | None:
    """Return the commit of the checkout that the package runs from; None outside of one."""
    try:
        done = subprocess.run(["git", "rev-parse", "HEAD"], cwd=Path(__file__).parent, capture_output=True, text=True,
                              timeout=5, check=False)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None if done.returncode == 0 else None


def genes_of(table: Any) -> dict[str, Any] | None:
    """Return what a species' genome says: alphabet, strings (ploidy), genes; None where nothing is said of it.

    A gene has its name, first locus `at`, number of `letters`, `trait` (null for a neutral marker), and `values` where it
    lists them: one for each codon in their order.
    """
    layout: Any = getattr(table.traits.get("heredity"), "layout", None)
    if layout is None:
        return None
    genes = [{"name": code.name, "at": int(code.first), "letters": int(code.stop - code.first), "trait": code.gene.trait}
             for code in layout.genes]  # fmt: skip
    for gene, code in zip(genes, layout.genes, strict=True):
        if code.gene.values is not None:
            gene["values"] = [float(v) for v in code.gene.values]
    return {"alphabet": layout.alphabet.letters, "ploidy": int(layout.ploidy), "genes": genes}
