"""Who starves for lack of what: plants find no food and need none, and some food never was there."""

import numpy as np
import pytest

from ecs_eco.analysis.runs import DIED
from ecs_eco.analysis.why import Case, diagnose, explain, sentences
from tests.analysis.test_why import HUNGER, PLANT, TICKS, animal, case, course, grazed


def test_plants_that_starve_did_not_fail_to_find_food() -> None:
    n = {"a": course((0, 500), (50, 0), (99, 0)), "b": course((0, 100), (99, 100))}
    fell = np.maximum(-np.diff(n["a"], append=0), 0)
    plant = PLANT | {
        "lethal": [{"property": "energy", "min": 0.0, "max": None, "cause_below": HUNGER, "cause_above": ""}]
    }
    run = case(
        n,
        {("a", HUNGER): fell},
        {"a": plant, "b": animal("a")},
        burnt={"a": 0.02 * n["a"]},
        taken_in={"a": 0.005 * n["a"]},
    )
    findings = explain(run)
    assert (findings["verdict"], findings["species"]) == ("energy ran out", "a")
    said = " ".join(line for lines in sentences(run, findings).values() for line in lines)
    assert "they took in 0.005 energy per capita per tick and burned 0.02. They eat no other species" in said
    assert "not found" not in said


def test_grazers_whose_plants_never_were_there_were_not_poisoned_by_a_few_others() -> None:
    n = {
        "green": np.zeros(TICKS),
        "red": course((0, 100), (99, 100)),
        "goat": course((0, 100), (80, 0), (99, 0)),
    }
    fell = np.maximum(-np.diff(n["goat"], append=0), 0)
    goat = animal("green")
    goat["diet"].append({"eats": "red", "gain": 0.0, "chance": 0.5, "deadly": True})
    died = {
        ("goat", HUNGER): 0.8 * fell,
        ("goat", "poisoned by red"): 0.2 * fell,
        ("red", "eaten by goat"): 0.2 * fell,
        ("green", "eaten by goat"): 0 * fell,
    }
    diagnosis = diagnose(
        case(n, died, {"green": PLANT, "red": PLANT, "goat": goat}, burnt={"goat": 0.01 * n["goat"]})
    )
    assert (diagnosis["verdict"], diagnosis["species"]) == ("food failed", "green")
    assert diagnosis["victim"] == "goat"
    assert diagnosis["runner_up"]["verdict"] == "poisoned"
    assert diagnosis["confidence"] == pytest.approx(0.8, abs=0.02)


@pytest.mark.parametrize("counted", [True, False])
def test_food_that_gives_a_share_of_what_it_held_is_food(counted: bool) -> None:
    run = grazed(0.05)
    (line,) = run.config["species"]["grass"]["diet"]
    line |= {"gain": 0.0, "efficiency": 0.8}
    run.series.columns["energy_mean"] = np.full_like(run.series.n, 0.125)
    if counted:
        gained = 0.07 * run.series.columns[DIED + "eaten by grass"][:, ::-1]
        run.series.columns["eaten: wolf"] = gained
    (food,) = Case(run.series, run.config).diet("grass")
    assert food.gain == pytest.approx(0.07 if counted else 0.1)
    assert diagnose(Case(run.series, run.config))["verdict"] == "overgrazing"
