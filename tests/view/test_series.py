"""The curves of a watched world."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.view.curves import Curves, extremes, stretch
from ecs_eco.view.live import Live
from ecs_eco.view.recording import by_species
from ecs_eco.view.replay import Replay

MOSS = {"count": 3, "body": {"radius": 0.1}, "metabolism": {"energy": 0.5, "basal": 0.125}}
GARDEN = {
    "format": 1,
    "name": "garden",
    "space": {"size": [20.0, 20.0]},
    "species": {"moss": MOSS, "fern": MOSS | {"count": 2}},
    "reporters": {"energy": "mean(Metabolism.energy)", "ratio": "count(fern) / count(moss)"},
}


def test_increments_have_the_later_points_and_nulls_for_what_is_not_there():
    curves = Curves()
    curves.add(*points([1], {("n", "deer"): [4], ("light", ""): [1.0]}, {("births", "deer"): [6]}))
    levels = {("n", "deer"): [5], ("happiness", "deer"): [0.123456789]}
    curves.add(*points([3], levels, {("births", "deer"): [3], ("causes", "deer", "starved"): [4]}))
    assert curves.after(-1) == {
        "kind": "series",
        "tick": [1, 3],
        "n": {"deer": [4, 5]},
        "happiness": {"deer": [None, 0.123457]},
        "genes": {},
        "light": [1.0, None],
        "births": {"deer": [None, 1.5]},
        "causes": {"deer": {"starved": [None, 2]}},
    }
    later = curves.after(1)
    assert (later["tick"], later["births"], later["causes"]) == (
        [3],
        {"deer": [1.5]},
        {"deer": {"starved": [2]}},
    )
    assert curves.after(3) is None


def test_curves_are_thinned_and_stay_bounded():
    curves, n = Curves(most=60), np.random.default_rng(1).integers(0, 10**6, 500)
    for tick in range(500):
        curves.add(*points([tick], {("n", "deer"): [n[tick]]}, {("births", "deer"): [2]}))
    sent = curves.after(-1)
    assert len(sent["tick"]) <= 60
    assert sent["tick"] == sorted(sent["tick"])
    assert sent["n"]["deer"] == n[sent["tick"]].tolist()
    assert {n.min(), n.max()} <= set(sent["n"]["deer"])
    assert set(sent["births"]["deer"][1:]) == {2}  # of ticks without a point, too
    assert sent["tick"][0] == 0
    assert sent["tick"][-1] == 499


def test_of_many_ticks_the_extremes_of_each_species_are_kept():
    n = np.array([[0, 5, 1, 1, 1, 1, 1, 9, 1, 1], [3, 3, 3, 0, 3, 3, 8, 3, 3, 3]])
    ticks = np.arange(10)
    assert extremes(ticks, n, 5).tolist() == [0, 1, 3, 5, 6, 7, 9]
    assert extremes(ticks, n, 16).tolist() == [0, 3, 6, 7, 9]
    assert extremes(ticks, n, 1).tolist() == ticks.tolist()
    # two points of each of three species in 501 stretches of 8 ticks
    assert [stretch(ticks, 3, 4000) for ticks in (4000, 4001)] == [1, 8]


@pytest.mark.parametrize("seed", range(5))
def test_points_do_not_depend_on_samples_and_a_page_has_those_of_its_server(seed):
    rng, most = np.random.default_rng(seed), 60
    n, born = rng.integers(0, 50, (2, 700)), rng.integers(0, 9, 700)
    curves, page, at = Curves(most), {"tick": [], "n": [], "births": []}, 0
    curves.add(*points([0], {("n", "deer"): [25], ("n", "wolf"): [25]}, {("births", "deer"): [0]}))
    while at < 700:
        now = slice(at, at + int(rng.integers(1, 90)))
        ticks, at = np.arange(700)[now] + 1, min(700, now.stop)
        levels = {("n", name): n[s, now] for s, name in enumerate(("deer", "wolf"))}
        curves.add(*points(ticks, levels, {("births", "deer"): born[now].cumsum()}))
        if rng.random() < 0.3:
            continue  # the page was busy
        sent = curves.after(page["tick"][-1] if page["tick"] else -1)
        keep = int(np.searchsorted(page["tick"], sent["tick"][0]))
        for name, line in (
            ("tick", sent["tick"]),
            ("n", sent["n"]["deer"]),
            ("births", sent["births"]["deer"]),
        ):
            page[name][keep:] = line
        held = curves.after(-1)
        assert page == {"tick": held["tick"], "n": held["n"]["deer"], "births": held["births"]["deer"]}
        assert len(page["tick"]) <= most + 3  # besides the beginning and the end
    whole = np.union1d(0, extremes(np.arange(700), n, stretch(700, 2, most)))
    assert (np.array(curves.after(-1)["tick"])[1:] - 1).tolist() == whole.tolist()
    spans = np.diff(curves.after(-1)["tick"])
    assert np.dot(spans, curves.after(-1)["births"]["deer"][1:]) == pytest.approx(born.sum())


@pytest.mark.parametrize("most", [4000, 24])
def test_a_living_world_has_the_points_of_its_recording_however_rarely_it_is_sampled(
    tmp_path, monkeypatch, most
):
    small = load("predator-prey", {"species.grass.count": 200, "species.deer.count": 60})
    live = Live(World.from_config(small, seed=3, policies="random"))
    live.curves.most = most
    monkeypatch.setattr("ecs_eco.view.recording.MOST", most)
    for ticks in (0, 1, 17, 2, 30):
        live.world.run(ticks)
        live.sample()
    run_to_folder(small, 3, 50, tmp_path / "run", "random", report=False)
    shown, recorded = live.series(-1), Replay(tmp_path / "run").series(-1)
    # the founders, and the state after each tick, which has the number of the next tick
    assert shown["tick"] == [0, *(tick + 1 for tick in recorded["tick"])]
    assert recorded["tick"] == list(range(50)) if most > 50 else 6 < len(recorded["tick"]) < 27
    assert {name: n[1:] for name, n in shown["n"].items()} == recorded["n"]
    for group in ("happiness", "births", "deaths", "energy", "causes", "flows"):
        mine, theirs = (dict(lines(of[group])) for of in (shown, recorded))
        assert mine.keys() == theirs.keys(), group
        for name in mine:
            known = [
                [-1 if value is None else value for value in of] for of in (mine[name][1:], theirs[name])
            ]
            assert known[0] == pytest.approx(known[1], rel=1e-5), (group, name)


def lines(group, name=""):
    """Each line of a group of curves by its name."""
    for key, value in group.items():
        yield from lines(value, f"{name}{key} ") if isinstance(value, dict) else [(name + key, value)]


def points(ticks, levels, gains):
    """Points of `Curves.add` from lists."""
    return np.array(ticks), *(
        {key: np.array(of, float) for key, of in some.items()} for some in (levels, gains)
    )


def test_what_reporters_say_has_curves_in_a_living_world_and_in_a_recording(tmp_path):
    live = Live(World.from_config(GARDEN))
    live.sample()
    assert "reports" not in live.series(-1)  # nothing was said yet
    for _ in range(2):
        live.world.run(1)
        live.sample()
    said = live.series(-1)["reports"]
    assert said == {
        "energy": {"moss": [None, 0.375, 0.25], "fern": [None, 0.375, 0.25]},
        "ratio": {"": [None, 0.666667, 0.666667]},
    }
    run_to_folder(GARDEN, 1, 2, tmp_path / "run", report=False)
    assert Replay(tmp_path / "run").series(-1)["reports"] == {
        "energy": {"": [0.375, 0.25]},
        "ratio": {"": [0.666667, 0.666667]},
    }


def test_a_sea_without_a_recorder_has_curves_of_depth_and_one_point_per_tick():
    sea = load("diel-migration", {"species.phytoplankton.count": 30, "species.copepod.count": 9})
    live = Live(World.from_config(sea, seed=1, policies="random", record=False))
    live.world.run(2)
    live.sample()
    live.sample()
    shown, copepods = live.series(-1), live.world.table("copepod")
    assert shown["tick"] == [2]
    z = copepods[Position].z[copepods.rows()]
    deep = float(live.world.space.size[2]) - float(z.mean())
    assert shown["reports"]["mean depth [m]"]["copepod"] == [pytest.approx(-deep, rel=1e-4)]


def test_a_reporter_of_some_species_has_a_curve_for_each_of_them():
    said = by_species(
        {"deer": np.array([1.0, np.nan]), "wolf": np.array([2.0, 3.0]), "grass": np.array([np.nan, np.nan])}
    )
    assert said.keys() == {"deer", "wolf"}
    assert said["wolf"].tolist() == [2.0, 3.0]
