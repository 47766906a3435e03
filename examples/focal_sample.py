"""A focal sample records individual animals' readings and decisions in every tick, as columns of a table."""

import tempfile
from pathlib import Path

import pyarrow.compute as pc

from ecs_eco.record import run_to_folder
from ecs_eco.record.parquet import read_parts

if __name__ == "__main__":
    out = Path(tempfile.mkdtemp()) / "run"
    run_to_folder("lamb", seed=1, ticks=60, out=out, record="focal=6", report=False)
    table = read_parts(out / "details-lamb")
    print(f"{len(table)} rows for the lambs {sorted(set(table['uid'].to_pylist()))}")
    touching = table.filter(pc.greater(table["sensor: touch_udder"], 0.5))
    print(
        f"{len(touching)} with an udder at the mouth: lambs "
        f"suck in {pc.sum(touching['decision: suck.suck'])} of them,"
    )
    print(
        f"by reflex in {pc.sum(touching['reflex: suck.suck'])}, "
        f"and their policy chose to suck in {pc.sum(touching['chosen: suck.suck'])}"
    )
