"""The order in which jobs begin: even over what they differ in, however many of them are done."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from ecs_eco.lab.design import design_of
from ecs_eco.lab.folder import begin
from ecs_eco.lab.plan import read_plan
from ecs_eco.lab.sweep import unfinished
from ecs_eco.lab.work import interleaved
from tests.lab.moss import PLAN, written


def spread(jobs: list[tuple[int, int]], which: int, of: int) -> int:
    """By how much the numbers of jobs differ."""
    counts = Counter(job[which] for job in jobs)
    return max(counts.values()) - min(counts[i] for i in range(of))


@pytest.mark.parametrize(("points", "seeds"), [(6, 5), (5, 6), (6, 4), (4, 6), (3, 3), (1, 4), (4, 1)])
def test_any_beginning_is_even_over_points_and_over_seeds(points: int, seeds: int) -> None:
    order = interleaved([[(point, seed) for seed in range(seeds)] for point in range(points)])
    assert sorted(order) == [(point, seed) for point in range(points) for seed in range(seeds)]
    for n in range(1, len(order)):
        assert spread(order[:n], 0, points) <= 1, n
        assert spread(order[:n], 1, seeds) <= 1, n


def test_groups_of_other_sizes_lose_nothing() -> None:
    groups = [["a1"], ["b1", "b2", "b3"], [], ["d1", "d2"]]
    assert sorted(interleaved(groups)) == ["a1", "b1", "b2", "b3", "d1", "d2"]
    assert interleaved([]) == []


def test_jobs_of_a_sweep_begin_evenly_over_points_treatments_and_seeds(tmp_path: Path) -> None:
    plan = PLAN.replace("world_seeds = 2", 'world_seeds = 5\ntreatments = ["species.moss.count=4"]')
    plan = plan.replace("[10, 30]", "[5, 10, 15, 20, 25, 30]")
    sweep = begin(tmp_path / "out", design_of(read_plan(written(tmp_path, plan))))
    numbers = unfinished(sweep)
    assert numbers == list(range(60))
    order = [sweep.jobs[number] for number in sweep.evenly(numbers)]
    assert sorted(job.number for job in order) == numbers
    for n in range(1, 60):
        done = order[:n]
        points = Counter(job.point for job in done)
        assert max(points.values()) - min(points[i] for i in range(6)) <= 1, n
        treatments = Counter(job.treatment for job in done)
        assert max(treatments.values()) - min(treatments[job.treatment] for job in sweep.jobs) <= 1, n
        seeds = Counter(job.world_seed for job in done)
        assert max(seeds.values()) - min(seeds[i] for i in range(1, 6)) <= 1, n
