"""What Python hands in is checked like the values of a file."""

import math

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.explain import Edit, take_out, write_explanation
from ecs_eco.explain.account import account
from ecs_eco.lab import search
from ecs_eco.lab.comparison import compare
from ecs_eco.lab.pretraining import pretrain
from ecs_eco.runs.repeat import repeat
from ecs_eco.runs.run import fork, resume, run_to_folder


@pytest.mark.parametrize("seed", [-1, 1.9, True, 2**64 + 7, 2**63, "1", None, np.float64(2), np.bool_(True)])
def test_a_wrong_seed_is_refused(seed):
    with pytest.raises(
        (TypeError, ValueError), match=r"seed is .*; expected a whole number from 0 to 9223372036854775807"
    ):
        World(seed=seed)


@pytest.mark.parametrize("seed", [0, 7, np.int64(7), np.uint8(3), 2**63 - 1])
def test_whole_numbers_of_numpy_are_seeds(seed):
    assert World(seed=seed).seed == int(seed)


@pytest.mark.parametrize("dt", [math.inf, math.nan, 0, -1.0, True, "1", None])
def test_a_wrong_dt_is_refused(dt):
    with pytest.raises(
        (TypeError, ValueError), match=r"dt is .*; expected a finite number of seconds above 0"
    ):
        World(dt=dt)


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, "2"])
def test_wrong_threads_are_refused(threads):
    with pytest.raises(
        (TypeError, ValueError), match=r"threads is .*; expected a whole number of at least 1"
    ):
        World(threads=threads)


@pytest.mark.parametrize("ticks", [-1, 1.5, True, "3", math.nan])
def test_wrong_ticks_are_refused(ticks):
    with pytest.raises((TypeError, ValueError), match=r"ticks is .*; expected a whole number of at least 0"):
        World().run(ticks)


WRONG = {
    "policies.dear": (
        {"policies": {"dear": "random"}},
        'no such species; expected: grass, deer, wolf; did you mean "deer"?',
    ),
    "learn.dear": (
        {"policies": "untrained", "learn": {"dear": True}},
        'no such species; expected: grass, deer, wolf; did you mean "deer"?',
    ),
    "learn.deer": (
        {"policies": "untrained", "learn": {"deer": "yes"}},
        "wrong type; expected: true or false",
    ),
    "learn": ({"policies": "untrained", "learn": "yes"}, "wrong type; expected: true or false"),
    "policies": (
        {"policies": 7},
        "wrong type; expected: trained, random, untrained, a folder, or in a dict a torch module",
    ),
    "policies.deer": (
        {"policies": {"deer": 7}},
        "wrong type; expected: trained, random, untrained, a folder, or in a dict a torch module",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_unknown_species_and_wrong_kinds_are_refused(case):
    how, message = WRONG[case]
    with pytest.raises(ConfigError) as error:
        World.from_config("predator-prey", **how)
    assert message in str(error.value)


@pytest.mark.parametrize("key", ["", ".", "species.", ".species", "species..count"])
def test_an_empty_key_is_refused(key):
    for changes in ({key: 5}, {"interventions": [{"kind": "set", "at": 3, "set": {key: 5}}]}):
        with pytest.raises(ConfigError, match=r"an empty key|is empty"):
            load("predator-prey", changes)


@pytest.mark.parametrize(
    ("progress", "why"),
    [
        (True, "True; expected a function that is called with done and (ticks|total|forks), or None"),
        (lambda done: None, "must accept 2 arguments.*expected a function that is called with done and "),
    ],
)
def test_what_cannot_be_called_is_no_progress_and_nothing_has_begun(progress, why, tmp_path):
    world = World()
    calls = [
        lambda: world.run(3, progress),
        lambda: run_to_folder("reflexes", ticks=3, out=tmp_path / "run", progress=progress),
        lambda: resume(tmp_path, progress=progress),
        lambda: fork(tmp_path, tmp_path / "fork", progress=progress),
        lambda: repeat(tmp_path, progress=progress),
        lambda: pretrain("reflexes", progress=progress),
        lambda: take_out(tmp_path, Edit("goat", "letter"), progress=progress),
        lambda: account(tmp_path, None, progress=progress),
        lambda: write_explanation(tmp_path, progress=progress),
        lambda: compare("reflexes", out=tmp_path / "compared", progress=progress),
    ]
    for call in calls:
        with pytest.raises(TypeError, match=why):
            call()
    assert (world.tick, list(tmp_path.iterdir())) == (0, [])
    with pytest.raises(TypeError, match="called with the search, or None"):
        search("reflexes", tmp_path / "search", progress=True)
