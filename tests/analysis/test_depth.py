"""How depth follows the day: series of known waves, and snapshots by hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from ecs_eco import World
from ecs_eco.analysis import depth as depths
from ecs_eco.analysis.compare import compare
from ecs_eco.analysis.runs import Series, load_series, mean_of_there
from ecs_eco.components import Position
from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.runs.run import snapshots

DAY = 48
SMALL = {
    "species.phytoplankton.count": 60,
    "species.copepod.count": 25,
    "species.krill.count": 12,
    "space.size": [16.0, 16.0, 16.0],
    "sun.day": float(DAY),
}


@pytest.fixture(scope="module")
def small():
    return load("diel-migration", SMALL)


def wave(small, amplitude: float = 4.0, lag: float = 0.0, days: int = 6, alive: int | None = None) -> Series:
    """Depths on a cosine of the day, `lag` days behind noon."""
    ticks = np.arange(days * DAY)
    manifest = {"config": small.resolved(), "dt": 1.0}
    series = Series(ticks, ("copepod",), {}, manifest)
    depth = 8 + amplitude * np.cos(2 * np.pi * (depths.hours_of(series, ticks) - 0.5 - lag))
    n = np.where(ticks < (len(ticks) if alive is None else alive), 9, 0)
    return replace(
        series, columns={"n": n[:, None].astype(float), "depth_mean": np.where(n > 0, depth, 0)[:, None]}
    )


def test_a_wave_of_depth_is_found_again_with_its_lag(small):
    cycle = depths.depth_cycle(wave(small, lag=0.125), "copepod")
    assert cycle.fit.amplitude == pytest.approx(4.0)
    assert cycle.share == pytest.approx(0.25)
    assert cycle.lag == pytest.approx(0.125)
    assert cycle.fit.mesor == pytest.approx(8.0)
    assert cycle.p < 0.02
    assert cycle.days == 5
    on_time, late = (depths.depth_cycle(wave(small, lag=x), "copepod") for x in (0.0, 0.5))
    assert on_time.r > 0.9 > cycle.r > 0
    assert late.r < -0.9


def test_who_died_is_looked_at_as_long_as_it_lived_and_two_days_are_needed(small):
    cycle = depths.depth_cycle(wave(small, alive=3 * DAY), "copepod")
    assert cycle.days == 2
    assert cycle.fit.amplitude == pytest.approx(4.0)
    assert np.isnan(cycle.p)
    assert depths.depth_cycle(wave(small, alive=2 * DAY - 1), "copepod") is None


def test_the_day_by_hours_leaves_the_first_one_out_and_knows_when_nobody_lived(small):
    cycle = depths.day_by_hour(wave(small, alive=2 * DAY + DAY // 2), "copepod")  # begins at six
    hours = np.arange(DAY) / DAY
    depth = 8 + 4 * np.cos(2 * np.pi * (hours - 0.5))
    assert cycle == pytest.approx(depth.reshape(24, 2).mean(1), abs=1e-6)
    # of the second day only from six to eighteen
    gone = depths.day_by_hour(wave(small, alive=DAY + DAY // 2), "copepod")
    assert np.isfinite(gone).tolist() == [6 <= h < 18 for h in range(24)]
    assert mean_of_there(np.array([[1.0, np.nan, np.nan], [3.0, 5.0, np.nan]])) == pytest.approx(
        [2, 5, np.nan], nan_ok=True
    )


def test_depths_over_time_are_means_of_snapshots(small, tmp_path: Path) -> None:
    at = [
        (0, "copepod", 15.9),
        (0, "copepod", 0.1),
        (0, "krill", 8.1),
        (5, "copepod", 15.5),
        (10, "krill", 7.9),
        (15, "krill", 16.0),
    ]
    folder = tmp_path / "snapshots"
    folder.mkdir()
    for k, rows in enumerate((at[:4], at[4:])):
        tick, name, z = zip(*rows, strict=True)
        pq.write_table(
            pa.table(
                {
                    "tick": pa.array(tick),
                    "species": pa.array(name).dictionary_encode(),
                    "z": pa.array(z, pa.float32()),
                }
            ),
            folder / f"part-{k:05d}.parquet",
        )
    series = wave(small)
    edges, numbers = depths.depths_over_time(tmp_path, series, ["copepod", "krill"], layers=2, most=2)
    assert edges.tolist() == [0, 10, 20]  # two snapshots each
    assert numbers["copepod"].tolist() == [[1.0, 0.0], [0.5, 0.0]]  # the upper half, the lower
    assert numbers["krill"].tolist() == [[0.5, 0.5], [0.0, 0.5]]
    assert depths.depths_over_time(tmp_path / "none", series, ["krill"])[0].tolist() == [0]


def test_arms_are_compared_by_depth(small, tmp_path):
    def runs(amplitude, lag):
        return [wave(small, a, lag) for a in amplitude]

    comparison = compare(
        {"sea": runs((4.0, 4.2, 3.8), 0.0), "inverted": runs((2.0, 2.0, 2.0), 0.5)}, tmp_path, n_boot=19
    )
    one, two = (comparison["arms"][arm]["per_species"]["copepod"]["depth"] for arm in ("sea", "inverted"))
    assert one["n"] == 3
    value, low, high = one["along_day"]
    assert value == pytest.approx(0.25)
    # Student's t of two degrees of freedom
    assert high - low == pytest.approx(2 * 4.303 * (0.2 / 16) / 3**0.5, rel=1e-3)
    assert two["along_day"][0] == pytest.approx(-0.125)
    assert two["r"][0] < -0.9
    assert "Depth over the day" in (tmp_path / "compare.html").read_text()
    assert (tmp_path / "figures" / "depth.svg").is_file()


def test_a_world_without_sun_or_depth_has_no_day(small):
    series = wave(small)
    assert depths.day_of(series) == DAY
    assert depths.day_of(replace(series, columns={"n": series.n})) == 0
    assert depths.day_of(replace(series, manifest={"config": {}})) == 0


def test_snapshots_fall_on_all_hours_of_the_day(small):
    every = snapshots(small, 40 * DAY)
    assert every == 19
    assert len({tick % DAY for tick in range(0, 100 * every, every)}) == DAY
    assert snapshots(load("predator-prey"), 5000) == 50


def test_mean_depth_is_recorded_in_a_volume_and_is_that_of_the_living(small):
    world = World.from_config(small, policies="untrained", seed=2, learn=False).run(5)
    series = load_series(world.series())
    for name, table in world.tables.items():
        z = [float(table[Position].z[row]) for row in table.rows()]
        assert series.of(name, "depth_mean")[-1] == pytest.approx(16.0 - sum(z) / len(z), rel=1e-6)
    flat = World.from_config("predator-prey", policies="random").run(1)
    assert "depth_mean" not in flat.series().column_names


@pytest.mark.slow
def test_a_run_of_two_days_is_reported_with_depths_hours_and_escapes(small, tmp_path: Path):
    run_to_folder(
        small, seed=4, ticks=2 * DAY + 10, out=tmp_path / "run", policies="untrained", record="full"
    )
    text = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    for words in ("Depth by time of day", "r with light", "approaches of krill to 1.5 m"):
        assert words in text
    assert {"depth.svg", "depths.svg", "hours.svg", "escape-1-2.svg"} <= {
        p.name for p in (tmp_path / "run" / "figures").iterdir()
    }
    shares = depths.depths_by_hour(tmp_path / "run", load_series(tmp_path / "run"))["copepod"]
    sums = shares.sum(0)
    assert np.isfinite(sums).any()
    assert sums[np.isfinite(sums)] == pytest.approx(1.0)
