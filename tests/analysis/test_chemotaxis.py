"""Who leaves a smell, against a slow loop over the recorded moves."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from ecs_eco.analysis.escapes import leaving, noses
from ecs_eco.analysis.runs import load_series
from ecs_eco.config import load
from ecs_eco.record import run_to_folder

DAY = 48
SMALL = {
    "species.phytoplankton.count": 60,
    "species.copepod.count": 25,
    "species.krill.count": 12,
    "space.size": [16.0, 16.0, 16.0],
    "sun.day": float(DAY),
}


def test_who_leaves_a_smell_is_counted_as_a_slow_loop_counts_it(tmp_path: Path):
    small = load("diel-migration", SMALL)
    run_to_folder(
        small, seed=6, ticks=DAY, out=tmp_path / "run", policies="untrained", record="full", report=False
    )
    assert noses(load_series(tmp_path / "run").manifest) == [("copepod", "krill_smell_gradient")]
    rows = [
        r
        for file in sorted((tmp_path / "run" / "details-copepod").iterdir())
        for r in pq.read_table(file).to_pylist()
    ]
    last, down, up = {}, 0, 0
    for r in sorted(rows, key=lambda r: r["tick"]):
        was, last[r["uid"]] = last.get(r["uid"]), r
        gradient = np.array(
            [r[f"sensor: krill_smell_gradient_{way}"] for way in ("forward", "left", "up")], float
        )
        if was is None or was["tick"] != r["tick"] - 1 or np.linalg.norm(gradient) <= 0.1:
            continue
        dx, dy = ((r[a] - was[a] + 8) % 16 - 8 for a in "xy")  # around the edge of 16 m
        cos, sin = np.cos(was["heading"]), np.sin(was["heading"])
        part = np.dot(gradient, [dx * cos + dy * sin, dy * cos - dx * sin, r["z"] - was["z"]])
        down, up = down + (part < 0), up + (part > 0)
    departures = leaving(tmp_path / "run", "copepod", "krill_smell_gradient")
    assert down + up > 100
    assert (departures.n, departures.index) == (down + up, pytest.approx((down - up) / (down + up)))
    assert 0 < departures.n_night < departures.n
    assert leaving(tmp_path / "run", "copepod", "krill_smell_gradient", least=2.0) is None
