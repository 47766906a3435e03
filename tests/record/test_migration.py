"""What islands record of migrants: who left somewhere arrived elsewhere, and books close."""

from pathlib import Path

import numpy as np
import pyarrow.dataset as ds
import pytest

from ecs_eco.analysis.archipelago import load_islands, places
from ecs_eco.analysis.runs import load_series
from ecs_eco.config import load
from ecs_eco.lab.archipelago import Archipelago
from tests.lab.newts import written


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Archipelago:
    place = tmp_path_factory.mktemp("newts")
    made = Archipelago.from_config(load(str(written(place))), seed=3, ticks=16, out=place / "run")
    made.run(report=False)
    return made


def table(folder: Path, kind: str) -> dict[str, list]:
    return ds.dataset(folder / kind).to_table().to_pydict()


def test_who_leaves_one_island_arrives_on_its_neighbour_with_all_it_has(run: Archipelago) -> None:
    left = {
        (name, uid): (to, energy)
        for name, folder in run.islands.items()
        for uid, to, energy in zip(
            *(table(folder, "departures")[c] for c in ("uid", "target", "energy")), strict=True
        )
    }
    came = {
        (origin, uid): (name, energy)
        for name, folder in run.islands.items()
        for uid, origin, energy in zip(
            *(table(folder, "arrivals")[c] for c in ("uid", "origin", "energy")), strict=True
        )
    }
    assert len(came) > 10
    assert left == came
    ring = ["north", "east", "south"]
    assert all(to != origin and to in ring for (origin, _), (to, _) in left.items())


def test_leaving_is_no_death_and_numbers_add_up(run: Archipelago) -> None:
    for folder in run.islands.values():
        series = load_series(folder)
        of = {key: series.of("newt", key) for key in ("n", "births", "deaths", "immigrants", "emigrants")}
        change = of["births"] + of["immigrants"] - of["emigrants"] - of["deaths"]
        assert (np.diff(of["n"]) == change[1:]).all()
        assert of["emigrants"].any()


def test_the_record_of_the_archipelago_counts_the_same_migrants(run: Archipelago) -> None:
    islands = load_islands(run.folder)
    arrived = sum(len(table(folder, "arrivals")["uid"]) for folder in run.islands.values())
    assert islands.moved().sum() == islands.moved("newt").sum() == arrived
    assert not islands.moved().diagonal().any()
    ticks, count = islands.over_time("newt")
    assert ticks.tolist() == [4, 8, 12]
    assert count.sum() == arrived


def test_islands_stand_apart_on_the_map(run: Archipelago) -> None:
    at = places(load_islands(run.folder).plan)
    gaps = np.linalg.norm(at[:, None] - at[None], axis=2)[~np.eye(3, dtype=bool)]
    assert gaps.min() > 0.3
    assert ((at > 0) & (at < 1)).all()
