"""A run that leaves a folder: manifest, Parquet series, births, deaths and snapshots, figures and a report."""

import json
import os
import subprocess
import time
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

VERSIONS = ("ecs-eco", "esper", "numpy", "numba", "torch", "pyarrow")


class Folder:
    """The folder of one run. Every file in it is whole: written beside, synced, renamed."""

    def __init__(self, path: Path, world: Any) -> None:
        from ecs_eco.record.arrow import to_arrow, write_part

        self.path, self.world = path, world
        self.parts = dict.fromkeys(("series", "births", "deaths", "snapshots"), 0)
        self._to_arrow, self._write_part = to_arrow, write_part

    def sink(self, kind: str, columns: dict[str, np.ndarray]) -> None:
        """Write one block of rows as a Parquet part."""
        words = {"species": self.world.recorder.names}
        if kind == "deaths":
            columns = columns | {"cause": columns["cause"].astype(np.int32) - 1}
            words["cause"] = self.world.causes
        folder = self.path / kind
        folder.mkdir(exist_ok=True)
        self._write_part(self._to_arrow(columns, words), folder / f"part-{self.parts[kind]:05d}.parquet")
        self.parts[kind] += 1


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file so that it is whole or as it was before."""
    temporary = path.with_suffix(".tmp")
    with open(temporary, "w", encoding="utf-8") as file:
        json.dump(content, file, indent=1, allow_nan=False)
        file.flush()
        os.fsync(file.fileno())
    os.replace(temporary, path)


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


def run_to_folder(config: Any, seed: int | None = None, ticks: int | None = None, out: str | Path = "run", policies: Any = "trained",
                  learn: bool | None = None, progress: Callable[[int, int], None] | None = None, *, threads: int = 1,
                  snapshot_every: int | None = None, report: bool = True, command: str | None = None,
                  controls: Sequence[str] = ()) -> dict[str, Any]:
    """Run a world, with these controls of `ecs_eco.worlds.controls`, and leave a folder; return its manifest.

    An interrupted run leaves what was recorded, with `finished` false. Raises FileExistsError where `out` holds something.
    """
    from ecs_eco.config import WorldConfig, load
    from ecs_eco.record.recorder import Recorder
    from ecs_eco.world import World

    begin = time.perf_counter()
    config = config if isinstance(config, WorldConfig) else load(config)
    ticks = config.ticks if ticks is None else ticks
    path = Path(out)
    if path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise FileExistsError(f"{path} exists and is not an empty folder; name another with --out")
    world = World.from_config(config, seed=seed, policies=policies, threads=threads, learn=learn, controls=controls, record=False)
    folder = Folder(path, world)
    Recorder(world, folder.sink, snapshot_every=max(1, ticks // 100) if snapshot_every is None else snapshot_every)
    manifest = {
        "format": 1, "world": config.name, "title": config.title, "config": config.resolved(), "config_hash": config.config_hash,
        "seed": world.seed, "ticks": ticks, "dt": config.dt, "policies": str(policies), "learn": learn,
        "controls": list(controls), "command": command, "versions": versions(),
        "git_commit": git_commit(), "species": world.recorder.names, "causes": world.causes, "finished": False, "done": 0,
        "colors": {name: world.tables[name].traits.get("color", "#888888") for name in world.recorder.names},
        "genomes": {name: found for name in world.recorder.names if (found := genes_of(world.tables[name]))},
    }  # fmt: skip
    path.mkdir(parents=True, exist_ok=True)
    write_json(path / "manifest.json", manifest)
    try:
        if ticks:
            world.run(1)
        manifest["startup_seconds"] = time.perf_counter() - begin
        start = time.perf_counter()
        world.run(max(ticks - 1, 0), None if progress is None else lambda done, _: progress(done + 1, ticks))
        manifest["finished"] = True
        manifest["wall_seconds"] = time.perf_counter() - start
    finally:
        world.recorder.flush()
        manifest |= {"done": world.tick, "causes": world.causes, "digest": world.digest()}
        write_json(path / "manifest.json", manifest)
    if report:
        from ecs_eco.record.report import write_report

        write_report(path)
    return manifest
