"""The curves of a watched world."""

import numpy as np

from ecs_eco import World
from ecs_eco.record import run_to_folder
from ecs_eco.view.curves import Curves, Point
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
    curves.add(Point(1, {("n", "deer"): 4, ("light", ""): 1.0}, {("births", "deer"): 6.0}))
    levels = {("n", "deer"): 5, ("happiness", "deer"): 0.123456789, ("light", ""): float("nan")}
    curves.add(Point(3, levels, {("births", "deer"): 9.0, ("causes", "deer", "starved"): 4.0}))
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
    curves = Curves(most=8)
    for tick in range(100):
        curves.add(Point(tick, {("n", "deer"): tick}, {("births", "deer"): 2 * tick}))
    points = curves.after(-1)
    assert len(points["tick"]) <= 8
    assert points["tick"] == sorted(points["tick"]) == points["n"]["deer"]
    assert set(points["births"]["deer"][1:]) == {2}  # of ticks without a point, too
    assert points["tick"][0] == 0
    assert points["tick"][-1] == 99


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


def test_a_reporter_of_some_species_has_a_curve_for_each_of_them():
    said = by_species(
        {"deer": np.array([1.0, np.nan]), "wolf": np.array([2.0, 3.0]), "grass": np.array([np.nan, np.nan])}
    )
    assert said.keys() == {"deer", "wolf"}
    assert said["wolf"].tolist() == [2.0, 3.0]
