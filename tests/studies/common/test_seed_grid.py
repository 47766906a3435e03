"""The grid of training seeds and world seeds: which cells there are, what they depend on,
what is made of them."""

from pathlib import Path
from typing import Any

import pytest

from studies.common import seed_grid

FEW = {"species.grass.count": 60, "species.deer.count": 12, "species.wolf.count": 2, "training.ticks": 4}


def entry(training: int, seed: int, persisted: bool, p: float = 0.002, **case: Any) -> dict[str, Any]:
    lags = {pair: {"share": share} for pair, share in (("deer→wolf", 0.3), ("grass→deer", 0.4))}
    cycles = {"period": 1000.0 + 100 * training + 7 * seed, "period_of": ["deer", "wolf"], "lags": lags}
    cycles["p_ar1"] = {"deer": 0.002, "wolf": p}
    result = {
        "persisted": persisted,
        "lived": 2000.0 if persisted else 500.0,
        "extinct": None if persisted else "wolf",
        "cycles": cycles,
        "periods": 60.0,
        "numbers": {s: {"mean log": 5.0 + training} for s in ("grass", "deer", "wolf")},
    }
    return {"case": {"arm": "a", "training": training, "seed": seed, **case}, "result": result}


def test_cells_come_world_by_world_so_that_no_policy_is_trained_twice() -> None:
    cells = seed_grid.cells(["a", "b"], [1, 2], [8, 9])
    assert [(c["seed"], c["arm"], c["training"]) for c in cells] == [
        (8, "a", 1),
        (8, "a", 2),
        (8, "b", 1),
        (8, "b", 2),
        (9, "a", 1),
        (9, "a", 2),
        (9, "b", 1),
        (9, "b", 2),
    ]


def test_a_new_arm_leaves_the_others_as_they_are() -> None:
    short = seed_grid.crossed_study("x", "…", {"a": {"set": FEW}}, [1], [2], ticks=20)
    more = seed_grid.crossed_study("x", "…", {"a": {"set": FEW}, "b": {"learn": True}}, [1, 3], [2], ticks=20)
    longer = seed_grid.crossed_study("x", "…", {"a": {"set": FEW}}, [1], [2], ticks=30)
    case = {"arm": "a", "training": 1, "seed": 2}
    assert (
        short._hash(short.config, case) == more._hash(more.config, case) != longer._hash(longer.config, case)
    )
    assert short._hash(short.config, case | {"ticks": 30}) == longer._hash(longer.config, case)
    with pytest.raises(ValueError, match="arm 'a': unknown key 'lern'"):
        seed_grid.crossed_study("x", "…", {"a": {"lern": True}}, [1], [2])


def test_what_is_said_of_a_grid_is_counted_over_its_cells() -> None:
    cells = [
        entry(t, w, persisted=t != 3, p=0.2 if (t, w) == (1, 1) else 0.01) for t in (1, 2, 3) for w in (1, 2)
    ]
    verdicts = seed_grid.summarise([*cells, entry(1, 1, True, ticks=60_000)], ["a"], 0.6)
    values = {line["statement"]: (line["value"], line["met"]) for line in verdicts["verdicts"]}
    # by hand: two effective runs, times (1.96 / 4.30)² for two degrees of freedom; Wilson's ends of 2/3 over 0.415
    assert values["a: runs in which all species persist"] == ("4 of 6 (67%, 4% to 99%)", True)
    assert values["a: of these, runs with peaks of all consumers beyond AR(1), p < 0.05"] == ("3 of 4", True)
    assert values["a: median lag deer→wolf, as a share of the period"][1]
    assert values["a, training seed 1, world seed 1: periods in one run of 60,000 ticks"] == (60.0, True)
    line = verdicts["table"]["rows"][0]
    assert (line[1], line[3], line[4], line[5], line[6]) == (6, "2/2, 2/2, 0/2", "wolf 2", "3 of 4", 1160.5)
    assert line[2][0] == pytest.approx(2 / 3)
    assert verdicts["variance"]["a"]["persisted"]["training seed"][0] == pytest.approx(1)
    assert "persisted: training seed 100%, world seed 0%, rest 0%" in verdicts["notes"]


@pytest.mark.slow
def test_a_grid_is_run_and_gone_on_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    says = {"set": FEW, "train": {"training.set": {}}}
    arms = {
        "frozen": says,
        "in life": {**says, "life": {"species.deer.ppo.learning_rate": 1e-4}, "learn": True},
    }
    study = seed_grid.crossed_study("grid", "…", arms, [1], [5], ticks=6)
    first = study.execute(results=tmp_path)
    assert [e["result"]["lived"] for e in first["cases"]] == [6.0, 6.0]
    assert len(list((tmp_path / "ecs-eco-policies").iterdir())) == 1  # both arms live with the same policies
    assert first["cases"][0]["result"]["cycles"]["period_of"] == ["deer", "wolf"]
    again = seed_grid.crossed_study("grid", "…", arms, [1], [5, 6], ticks=6).execute(results=tmp_path)
    assert [e["case"]["seed"] for e in again["cases"]] == [5, 5, 6, 6]
    assert again["cases"][:2] == first["cases"]
    assert set(again["cases"][0]) == {"case", "result", "seconds", "commit", "dirty", "depends_hash"}


@pytest.mark.parametrize("learn", [True, False])
def test_species_that_learn_in_life_do_so_at_a_constant_rate(
    learn: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def live(config: Any, *_: object) -> None:
        assert [config.species[name].ppo["anneal"] for name in ("deer", "wolf")] == [0 if learn else 3000] * 2
        raise StopIteration

    monkeypatch.setattr(seed_grid, "live", live)
    study = seed_grid.crossed_study("x", "…", {"a": {"learn": learn, "policies": "random"}}, [1], [2])
    with pytest.raises(StopIteration):
        seed_grid.cell(study.config, {"arm": "a", "training": 1, "seed": 2})
