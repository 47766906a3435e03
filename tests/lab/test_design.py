"""The design of a sweep: points, jobs and trainings, and worlds that are refused at the plan's lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab.design import design_of
from ecs_eco.lab.folder import begin
from ecs_eco.lab.plan import points_of, read_plan
from tests.lab.moss import PLAN, written

SMALL = {"species.grass.count": 60, "species.deer.count": 12, "species.wolf.count": 2}


def design(**plan: object):  # type: ignore[no-untyped-def]
    return design_of(read_plan({"world": "predator-prey", "set": SMALL, **plan}))


def test_jobs_cross_points_treatments_training_seeds_and_world_seeds() -> None:
    made = design(grid={"dt": [1.0, 0.5]}, treatments=["random-policy"], training_seeds=2, world_seeds=[4, 6])
    # the world as it is with 2 training seeds, random policies without: (2 + 1) rows of 2 seeds, twice
    assert len(made.jobs) == 12
    assert [job.number for job in made.jobs] == list(range(12))
    first = [(job.treatment, job.training_seed, job.world_seed) for job in made.jobs[:6]]
    assert first == [
        ("", 1, 4),
        ("", 1, 6),
        ("", 2, 4),
        ("", 2, 6),
        ("random-policy", None, 4),
        ("random-policy", None, 6),
    ]
    assert [job.values for job in made.jobs] == [{"dt": 1.0}] * 6 + [{"dt": 0.5}] * 6
    assert len(made.trainings) == 2  # in the world as it is, for all points
    assert {one.config_hash for one in made.trainings} == {load("predator-prey", SMALL).config_hash}


def test_policies_are_trained_anew_for_each_set_of_values_where_the_plan_says_so() -> None:
    made = design(grid={"dt": [1.0, 0.5]}, training_seeds=2, retrain=True)
    assert len(made.trainings) == 4
    assert {one.config_hash for one in made.trainings} == {job.config_hash for job in made.jobs}


def test_a_hypercube_has_one_point_in_each_share_of_every_range() -> None:
    ranges = {"dt": [0.2, 1.0], "species.deer.metabolism.basal": {"search": [0.001, 0.1], "scale": "log"}}
    plan = read_plan(
        {"world": "predator-prey", "set": SMALL, "sample": {"points": 8, "seed": 3, "ranges": ranges}}
    )
    points = [
        {name: entry.value for name, entry in point.items()}
        for point in points_of(plan.plan, load("predator-prey", SMALL))
    ]
    dt = np.array([point["dt"] for point in points])
    basal = np.log10([point["species.deer.metabolism.basal"] for point in points])
    assert sorted(((dt - 0.2) / 0.8 * 8).astype(int)) == list(range(8))
    assert sorted(((basal + 3) / 2 * 8).astype(int)) == list(range(8))


def test_the_hash_is_that_of_the_plan_and_not_of_its_place(tmp_path: Path) -> None:
    longer = PLAN.replace("ticks = 6", "ticks = 7")
    plans = [written(tmp_path / "a"), written(tmp_path / "b"), written(tmp_path / "c", longer)]
    one, two, other = (begin(plan.parent / "out", design_of(read_plan(plan))).hash for plan in plans)
    assert one == two != other


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ('until = "mss == 0"\n', ["line 4", 'unknown name "mss" at character 1', 'did you mean "moss"']),
        ('until = ["moss == 0",\n"moss >"]\n', ["line 5", "not an expression", '"moss >"']),
        ("from_tick = 6\n", ["line 4", "is not before the end of the runs", "less than 6"]),
        ("[grid]\nspecies.mos.count = [1]\n", ["line 5", 'no species named "mos"', 'did you mean "moss"']),
        ("[grid]\nspecies.moss.count = [1,\n-4]\n", ["line 6", "-4", "at least 0"]),
        ("[grid]\nspecies.moss.cuont = [1]\n", ["line 5", "unknown key", 'did you mean "count"']),
        ("[set]\nspecies.moss.count = 1.5\n", ["line 5", "a whole number"]),
        (
            "[sample]\npoints = 2\n[sample.ranges]\nspecies.moss.cuont = [1, 2]\n",
            ["line 7", 'did you mean "count"'],
        ),
        ("[sample]\npoints = 2\n[sample.ranges]\nspecies.moss.count = [3, 2]\n", ["line 7", "low < high"]),
        ('treatments = ["random-polisy"]\n', ["line 4", "no such treatment", 'did you mean "random-policy"']),
        ('treatments = ["no-reflexes"]\n', ["line 4", "no species has a reflex"]),
        ("training_seeds = 2\n", ["line 4", "no species has a policy to train"]),
        ('policies = "ramdom"\n', ["line 4", "no such folder", 'did you mean "random"']),
        ("[grid]\ntraining.ticks = [10, 20]\n", ["line 5", "retrain = true"]),
        ("world_seeds = 90000\n[grid]\nspecies.moss.count = [1, 2]\n", ["180,000 jobs", "at most 100,000"]),
        ('[reporters]\nn = "cuont(moss)"\n', ["line 5", "reporters.n"]),
    ],
)
def test_a_world_that_is_refused_is_told_at_the_line_of_the_plan(
    tmp_path: Path, more: str, words: list[str]
) -> None:
    plan = written(tmp_path, f'world = "moss.toml"\n# the moss\nticks = 6\n{more}')
    with pytest.raises(ConfigError) as error:
        design_of(read_plan(plan))
    for word in ["plan.toml", *words]:
        assert word in str(error.value), str(error.value)


def test_a_world_that_is_not_there_is_told_with_the_nearest(tmp_path: Path) -> None:
    plan = written(tmp_path, 'world = "mos.toml"\n')
    wanted = r'plan\.toml, line 1: world = "mos\.toml"\n.*did you mean "moss\.toml"'
    with pytest.raises(ConfigError, match=wanted):
        design_of(read_plan(plan))


def test_a_sample_that_is_no_table_is_refused_with_a_design(tmp_path: Path) -> None:
    plan = written(tmp_path, 'world = "moss.toml"\nticks = 6\nsample = 5\n')
    with pytest.raises(ConfigError, match="sample"):
        read_plan(plan, "sobol")
