"""Who ate how much of whom in a run: hand-counted means, and a drawing for light and dark pages."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from ecs_eco.analysis.flows import Budget, Meal, draw, flows, levels
from ecs_eco.analysis.runs import Series

SPECIES = ("grass", "deer", "wolf")


def run(**columns):
    """Two ticks of grass, deer and wolves; columns by name, (ticks, species), else 0."""
    names = (
        "taken_in",
        "burnt",
        "given",
        "lost",
        "eaten: grass",
        "eaten: deer",
        "died: eaten by deer",
        "died: eaten by wolf",
    )
    table = {name: np.zeros((2, 3)) for name in names} | {"n": np.ones((2, 3))}
    table |= {
        name.replace("_by_", ": eaten by ").replace("ate_", "eaten: "): np.array(values, float)
        for name, values in columns.items()
    }
    return Series(np.arange(2), SPECIES, table, {"colors": {"grass": "#4d9221", "wolf": "#d7191c"}})


MEALS = {
    "ate_grass": [[0, 4, 0], [0, 2, 0]],
    "died_by_deer": [[8, 0, 0], [4, 0, 0]],
    "ate_deer": [[0, 0, 1], [0, 0, 0]],
    "died_by_wolf": [[0, 1, 0], [0, 0, 0]],
    "taken_in": [[5, 4, 1], [5, 2, 0.5]],
    "burnt": [[0, 1, 1], [0, 1, 1]],
    "lost": [[3.5, 2, 0], [3.5, 2, 0]],
}


def test_means_of_a_tick_are_those_counted_by_hand():
    found = flows(run(**MEALS))
    assert found.meals == (Meal("grass", "deer", 3.0, 6.0), Meal("deer", "wolf", 0.5, 0.5))
    assert found.budgets == {
        "grass": Budget(5.0, 0.0, 0.0, 0.5),
        "deer": Budget(0.0, 0.0, 1.0, 1.5),
        "wolf": Budget(0.0, 0.25, 1.0, 0.0),
    }
    assert not found.shared
    assert levels(found) == {"grass": 0, "deer": 1, "wolf": 2}


def test_an_animal_without_a_meal_takes_in_no_light():
    series = run(**MEALS | {"died_by_wolf": np.zeros((2, 3)), "ate_deer": np.zeros((2, 3))})
    series.manifest["config"] = {"species": {"grass": {}, "wolf": {"diet": [{"eats": "deer"}]}}}
    budget = flows(series).budgets["wolf"]
    assert (budget.light, budget.other) == (0.0, 0.75)


def test_without_columns_of_foods_energy_is_shared_by_number():
    series = run(**MEALS)
    for name in [name for name in series.columns if name.startswith("eaten: ")]:
        del series.columns[name]
    found = flows(series)
    assert found.shared
    assert [meal.energy for meal in found.meals] == [3.0, 0.75]  # a wolf eats deer alone


def test_where_nobody_eats_there_is_nothing_to_draw():
    assert flows(run()) is None
    assert flows(Series(np.arange(2), SPECIES, {"n": np.ones((2, 3))})) is None


def test_bands_are_as_wide_as_energy_what_harms_is_dashed_and_what_nobody_ate_dotted():
    harmed = MEALS | {"ate_deer": [[0, 0, -1], [0, 0, 0]]}
    svg = ElementTree.fromstring(draw(run(**harmed), flows(run(**harmed))))
    paths = {path[0].text.split(":")[0]: path for path in svg.iter("path")}
    grass, deer = paths["deer eats 6 grass per tick"], paths["wolf eats 0.5 deer per tick"]
    assert float(grass.get("stroke-width")) == pytest.approx(6 * float(deer.get("stroke-width")), rel=0.01)
    assert grass.get("stroke-dasharray") is None
    assert (deer.get("stroke-dasharray"), deer.get("class")) == ("3 3", "harm")
    unfed = run(**MEALS | {"ate_deer": [[0, 0, 0], [0, 0, 0]]})
    assert 'stroke-dasharray="1 4"' in draw(unfed, flows(unfed))


def test_a_drawing_has_colours_for_light_and_dark_and_no_word_of_a_stranger_as_markup():
    series = run(**MEALS)
    strange = Series(series.ticks, ("<b>", "deer", "wolf"), series.columns, series.manifest)
    drawn = draw(strange, flows(strange))
    assert "<b>" not in drawn
    rules = re.search(r"<style>(.*)@media \(prefers-color-scheme:dark\)\{(.*)\}</style>", drawn)
    light, dark = rules.groups()
    of = [dict(re.findall(r"\.flows \.(s\d)\{fill:(#\w+)\}", rules)) for rules in (light, dark)]
    assert of[0].keys() == of[1].keys() == {"s0", "s1", "s2"}
    assert of[0]["s2"] != of[1]["s2"]
