"""The curves of a watched world."""

from ecs_eco.view.series import Curves


def test_increments_have_the_later_points_and_nulls_for_what_is_not_there():
    curves = Curves()
    curves.add(1, {("n", "deer"): 4, ("light", ""): 1.0})
    curves.add(3, {("n", "deer"): 5, ("happiness", "deer"): 0.123456789, ("light", ""): float("nan")})
    assert curves.after(-1) == {"kind": "series", "tick": [1, 3], "n": {"deer": [4, 5]},
                                "happiness": {"deer": [None, 0.123457]},
                                "genes": {}, "light": [1.0, None]}  # fmt: skip
    assert curves.after(1)["tick"] == [3]
    assert curves.after(3) is None


def test_curves_are_thinned_and_stay_bounded():
    curves = Curves(most=8)
    for tick in range(100):
        curves.add(tick, {("n", "deer"): tick})
    points = curves.after(-1)
    assert len(points["tick"]) <= 8
    assert points["tick"] == sorted(points["tick"]) == points["n"]["deer"]
    assert points["tick"][0] == 0
    assert points["tick"][-1] == 99
