"""The story of a world: who booms, crashes, dies out and comes back, and by what."""

import numpy as np

from ecs_eco.view.story import Story, foods_of

CAUSES = ["eaten by wolf", "starved"]
FOODS = {"deer": ["grass"], "wolf": ["deer"]}


def told(deer, wolf=None, grass=None, starved=None, eaten=None):
    """The story of numbers by tick; deaths of deer by cause are sums."""
    k = len(deer)
    story = Story(["grass", "deer", "wolf"], FOODS, CAUSES.__getitem__)
    for tick in range(k):
        n = np.array([(grass or [500] * k)[tick], deer[tick], (wolf or [5] * k)[tick]])
        deaths = np.zeros((3, 2), np.int64)
        deaths[1] = (eaten or [0] * k)[tick], (starved or [0] * k)[tick]
        story.note(tick, n, np.zeros(3, np.int64), deaths, np.zeros(3, bool))
    return [entry for entry in story.entries if entry["species"] == "deer"]


def test_a_boom_and_a_crash_are_told_once_each_when_numbers_doubled_and_halved():
    entries = told([40, 50, 79, 80, 120, 200, 190, 101, 100, 60, 30, 31])
    assert [(e["tick"], e["kind"], e["before"]) for e in entries] == [(3, "boom", 40), (8, "crash", 200)]
    assert entries[1]["text"] == "Deer crash: 50% as many as at tick 5"


def test_small_numbers_double_by_chance():
    assert told([2, 4, 8, 16, 8, 4]) == []


def test_an_extinction_is_told_with_the_deaths_since_the_last_high_and_a_return_too():
    entries = told(
        [100, 60, 40, 10, 0, 0, 3],
        starved=[0, 30, 40, 60, 70, 70, 70],
        eaten=[5, 10, 20, 30, 35, 35, 35],
        grass=[500, 400, 300, 100, 90, 90, 90],
    )
    assert [e["kind"] for e in entries] == ["crash", "extinct", "return"]
    assert entries[1]["tick"] == 4
    assert entries[1]["cause"].startswith(
        "Deaths since tick 0 (last high): 100 (70% starved, 30% eaten by wolf)."
    )
    assert entries[1]["cause"].endswith("Meanwhile, its food (grass) went from 500 to 90.")


def test_food_that_was_never_there_is_told_as_that():
    entries = told([100, 60, 45], starved=[0, 30, 55], grass=[0, 0, 0])
    assert entries[0]["cause"].endswith("There was no grass.")


def test_who_was_eaten_has_its_enemy_named_where_that_grew():
    entries = told([100, 70, 45], eaten=[0, 30, 55], wolf=[5, 9, 20])
    assert entries[0]["cause"].endswith("Meanwhile, its enemy (wolf) went from 5 to 20.")


def test_a_first_birth_is_told_once():
    story, nobody = Story(["deer"], {}, CAUSES.__getitem__), np.zeros((1, 2), np.int64)
    for tick in range(20):
        story.note(tick, np.array([10]), np.array([tick]), nobody, np.array([tick > 9]))
    assert [(e["tick"], e["kind"]) for e in story.entries] == [(10, "birth")]


def test_foods_are_what_somebody_gains_by():
    diet = [
        {"eats": "red", "gain": -1},
        {"eats": "green", "gain": 2},
        {"eats": "box", "gain": 1, "deadly": True},
    ]
    config = {"species": {"goat": {"diet": diet}, "green": {}}}
    assert foods_of(config) == {"goat": ["green"], "green": []}
    assert foods_of(config, harmful=True) == {"goat": ["red", "green", "box"], "green": []}
