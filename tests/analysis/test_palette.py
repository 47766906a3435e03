"""Colours stand out from their grounds, and are told apart by everybody, everywhere the same."""

from itertools import combinations

import numpy as np
import pytest

from ecs_eco.analysis.palette import GREY, SAFE, UNSET, safe
from ecs_eco.analysis.style import colors
from ecs_eco.config.models.species import Species

GROUNDS = {
    False: ["#f3f5f3", "#ffffff", "#e4f3d6", "#f6efdf"],  # the last two: land
    True: ["#0e1315", "#161c1f", "#14251a", "#22221a"],
}
DEUTERANOPIA = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)  # Machado, Oliveira & Fernandes 2009, severity 1
XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
THEMES = pytest.mark.parametrize("dark", [False, True])


def linear(colour):
    share = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    x = XYZ @ np.clip(rgb, 0, 1) / [0.95047, 1, 1.08883]
    f = np.where(x > 0.008856, np.cbrt(x), 7.787 * x + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def contrast(a, b):
    low, high = sorted(0.05 + XYZ[1] @ linear(colour) for colour in (a, b))
    return high / low


@THEMES
def test_every_colour_has_a_contrast_of_three_with_every_ground(dark):
    for pair in SAFE:
        for ground in GROUNDS[dark]:
            assert contrast(pair[dark], ground) >= 3, (pair[dark], ground)
    assert contrast("#ffffff", "#000000") == pytest.approx(21)


@THEMES
@pytest.mark.parametrize("sees", [np.eye(3), DEUTERANOPIA], ids=["all cones", "deuteranopia"])
def test_any_two_colours_differ_to_everybody(dark, sees):
    seen = {pair[dark]: lab(sees @ linear(pair[dark])) for pair in SAFE}
    for a, b in combinations(seen, 2):
        assert np.linalg.norm(seen[a] - seen[b]) > 20, (a, b)


@THEMES
def test_a_shaded_deer_is_no_wolf(dark):
    """The page shades facets down to 0.88 of their colour."""
    hues = safe({"grass": "#4d9221", "deer": "#b8860b", "wolf": "#67001f"}, dark=dark)
    for sees in (np.eye(3), DEUTERANOPIA):
        levels = {
            name: [lab(sees @ (linear(hue) * share**2.2)) for share in (0.88, 1.0)]
            for name, hue in hues.items()
        }
        for a, b in combinations(levels, 2):
            assert min(np.linalg.norm(x - y) for x in levels[a] for y in levels[b]) > 12, (a, b)


def test_each_gets_the_colour_nearest_to_its_own_and_greys_stay_grey():
    hues = safe({"grass": "#4d9221", "deer": "#b8860b", "wolf": "#67001f"}, {"stone": "#888888"})
    assert hues == {"grass": "#069b6d", "deer": "#6f3e00", "wolf": "#de640a", "stone": GREY}
    many = safe({f"s{i}": "#d7191c" for i in range(10)})
    assert len(set(many.values())) == 10
    assert {light for light, _, _ in SAFE} < set(many.values())


def test_those_without_a_colour_take_the_rest_in_order_and_plants_come_first():
    assert safe({"grass": UNSET, "rabbit": UNSET}) == {"grass": "#069b6d", "rabbit": "#6f3e00"}
    hues = safe({"grass": UNSET, "fox": "#67001f", "moss": "#4d9221"}, {"stone": UNSET})
    assert hues == {"grass": "#6f3e00", "fox": "#de640a", "moss": "#069b6d", "stone": "#2992c2"}
    assert Species.model_fields["color"].default == UNSET


def test_things_take_no_colour_from_a_species():
    alone = safe({"deer": "#b8860b"})["deer"]
    assert safe({"deer": "#b8860b"}, {"box": "#b8860b"})["deer"] == alone


def test_reports_have_the_colours_of_the_page():
    own = {"grass": "#4d9221", "deer": "#b8860b", "wolf": "#67001f"}
    assert colors(list(own), own) == safe(own)
    assert colors(["wolf"], own)["wolf"] == safe(own)["wolf"]  # however many are drawn
