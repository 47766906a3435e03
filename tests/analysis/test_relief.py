"""The ground on maps: hills in the light of the upper left, water flat and blue, classes in their colours."""

import numpy as np
import pytest

from ecs_eco.analysis.relief import LAND, ROCK, WATER, Relief, draw_relief

HILL = np.maximum(0, 5 - np.hypot(*(np.mgrid[:21, :21] - 10.0))).astype(np.float32)
OPEN = np.zeros((21, 21), np.uint8)


def test_flat_ground_has_the_colour_of_land():
    colours = Relief(0 * HILL, OPEN, 1.0).colours()
    assert colours == pytest.approx(np.broadcast_to(LAND, (21, 21, 3)))


def test_slopes_towards_the_upper_left_are_lit_and_those_away_from_it_dark():
    shade = Relief(HILL, OPEN, 1.0).shade()
    north_west, south_east = shade[13, 7], shade[7, 13]  # the first row is in the south
    assert north_west > 0.1
    assert south_east < -0.1
    assert shade[0, 0] == pytest.approx(0)
    assert shade[13, 13] == pytest.approx(shade[7, 7], abs=0.02)  # both aslant to the sun


def test_steep_and_gentle_land_is_drawn_alike():
    one, two = (Relief(HILL * times, OPEN, 1.0).shade() for times in (0.01, 10.0))
    assert one == pytest.approx(two, abs=1e-6)


def test_water_rock_streams_and_classes_have_their_colours():
    ground, kinds, wet = OPEN.copy(), OPEN.copy(), np.zeros(OPEN.shape, bool)
    ground[0, :2], kinds[0, 1:4], wet[5, 5] = 1, 1, True
    ground[1, 0] = 2
    colours = Relief(
        0 * HILL, ground, 1.0, kinds=kinds, colors=["#ff0000", None], wet=wet, grounds=["water", "open"]
    ).colours()
    red = 0.35 * np.array(LAND) + 0.65 * np.array([1.0, 0, 0])
    assert colours[0, 0] == pytest.approx(WATER)
    assert colours[0, 1] == pytest.approx(red)  # water of a class that has a colour of its own
    assert colours[0, 3] == pytest.approx(red)
    assert colours[1, 0] == pytest.approx(ROCK)
    assert colours[5, 5] == pytest.approx(WATER)


@pytest.mark.parametrize(("ground", "number", "colour"), [("water", 1, WATER), ("rock", 2, ROCK)])
def test_lakes_and_rocks_on_a_class_with_a_colour_are_seen_unless_it_makes_them(ground, number, colour):
    kinds = np.repeat(np.array([[1, 2, 0]], np.uint8), 3, axis=0)
    there = np.full((3, 3), number, np.uint8)
    colours = Relief(
        np.zeros((3, 3), np.float32),
        there,
        1.0,
        kinds=kinds,
        colors=["#ff0000", "#ff0000"],
        grounds=["open", ground],
    ).colours()
    red = 0.35 * np.array(LAND) + 0.65 * np.array([1.0, 0, 0])
    assert colours[0] == pytest.approx(np.array([colour, red, colour]))


def test_the_relief_lies_below_all_else_in_the_extent_of_the_world():
    from matplotlib.figure import Figure

    ax = Figure().subplots()
    image = draw_relief(ax, Relief(HILL, OPEN, 2.0), [42.0, 42.0])
    assert image.get_extent() == [0, 42, 0, 42]
    assert image.get_zorder() < 0.5
    assert image.origin == "lower"


@pytest.mark.parametrize("world", ["island", "reflexes"])
def test_a_run_keeps_the_ground_for_its_report_where_there_is_any(tmp_path, world):
    from ecs_eco.record import run_to_folder

    counts = {"species.deer.count": 5} if world == "island" else {}
    from ecs_eco.config import load

    config = load(world, counts)
    run_to_folder(config, ticks=2, out=tmp_path / "run", report=False, policies="random")
    relief = Relief.kept(tmp_path / "run", config.resolved())
    if config.terrain is None:
        assert relief is None
    else:
        assert (relief.ground == 1).sum() == pytest.approx(np.pi * 26**2 / 4, rel=0.02)  # its lake
        assert relief.height.std() > 1
        assert relief.side == 2.0
