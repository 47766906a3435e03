"""Sensitivity indices, against the Ishigami function, which has known ones."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab import plan as plans
from ecs_eco.lab.design import design_of
from ecs_eco.lab.plan import points_of, read_plan
from ecs_eco.lab.response import Outcome, indices_of
from ecs_eco.lab.table import _sensitivity
from tests.lab.moss import WORLD, written

KEYS = {
    "species.moss.metabolism.basal": [0.0, 0.01],
    "species.moss.reproduction.rate": [0.1, 0.2],
    "species.moss.reproduction.seed_rain": {"search": [0.001, 0.1], "scale": "log"},
}
OUTCOME = Outcome("y", "y")
ENDS = np.array([(0.0, 0.01), (0.1, 0.2), (-3.0, -1.0)]).T


def rows_of(points: int, design: str, folder: Path) -> tuple[Any, list[dict[str, Any]]]:
    """The points of a plan, with Ishigami's function of their values for a result: a = 7, b = 0.1."""
    plan = {"world": "moss.toml", "sample": {"points": points, "ranges": KEYS}}
    (folder / "moss.toml").write_text(WORLD)
    cube = read_plan(plan, design).plan.sample
    rows = []
    for i, point in enumerate(points_of(read_plan(plan, design).plan, load(folder / "moss.toml"))):
        values = np.array([entry.value for entry in point.values()])
        values[2] = np.log10(values[2])
        a, b, c = (2 * (values - ENDS[0]) / (ENDS[1] - ENDS[0]) - 1) * np.pi
        y = np.sin(a) + 7 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)
        rows += [
            {"point": i, "treatment": "world", "training_seed": None, "world_seed": seed, "y": y + d}
            for seed, d in ((1, 0.1), (2, -0.1))
        ]
    return cube, rows


def test_the_indices_of_sobol_are_those_of_the_ishigami_function(tmp_path: Path) -> None:
    pytest.importorskip("SALib")
    cube, rows = rows_of(1024, "sobol", tmp_path)
    assert len(rows) == 2 * cube.size == 2 * 1024 * 5
    [(_, _, found)] = indices_of(cube, rows, [OUTCOME])
    known = {"basal": (0.314, 0.558), "rate": (0.442, 0.442), "seed_rain": (0.0, 0.244)}
    for key, both in found.items():
        for x, index in zip(both, known[key.rpartition(".")[2]], strict=True):
            assert x.value == pytest.approx(index, abs=0.04)
            assert x.low - 0.02 < index < x.high + 0.02
    assert not list(indices_of(cube, rows[:-2], [OUTCOME]))  # a point is missing


def test_a_page_shows_the_effects_of_morris(tmp_path: Path) -> None:
    pytest.importorskip("SALib")
    cube, rows = rows_of(20, "morris", tmp_path)
    sweep: Any = SimpleNamespace(folder=tmp_path)
    (tmp_path / "figures").mkdir()
    known = list(indices_of(cube, rows, [OUTCOME]))
    text = "".join(_sensitivity(sweep, "morris", known, tmp_path / "figures"))
    assert "μ*" in text
    assert (tmp_path / "sensitivity.parquet").exists()
    assert (tmp_path / "figures" / "sensitivity.svg").exists()
    [(_, _, found)] = known
    assert found["species.moss.reproduction.rate"][0].value == pytest.approx(7 * 0.75 * 1.5, rel=0.02)


def test_a_plan_without_what_its_design_needs_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ranges = "[sample]\npoints = 6\n[sample.ranges]\nspecies.moss.count = [1, 9]\n"
    plan = written(tmp_path, f'world = "moss.toml"\nticks = 6\n{ranges}[grid]\ndt = [0.5, 1.0]\n')
    monkeypatch.setattr(plans, "find_spec", lambda name: None)
    with pytest.raises(ConfigError) as error:
        design_of(read_plan(plan, "sobol"))
    for words in ('pip install -e ".[sensitivity]"', "cannot be combined with [grid]", "is not a power of 2"):
        assert words in str(error.value)
    with pytest.raises(ConfigError, match='did you mean "sobol"'):
        read_plan(plan, "sobl")
