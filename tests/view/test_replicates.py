"""Pairs of worlds with other seeds: their command, their outcome against `compare`, and what cannot be run."""

import time

import pytest

from ecs_eco import World
from ecs_eco.analysis.runs import load_series
from ecs_eco.config import load
from ecs_eco.lab import compare
from ecs_eco.record import run_to_folder
from ecs_eco.view.branch import Start
from ecs_eco.view.live import Live
from ecs_eco.view.pair import Pair
from ecs_eco.view.replay import Replay
from ecs_eco.view.replicates import SUSTAINED, command_of, first_differences

MOSS = """
format = 1
name = "moss"
ticks = 12
[space]
size = [12.0, 12.0]
[species.moss]
count = 20
body = { radius = 0.1, mass = 0.1 }
metabolism = { energy = 0.8, energy_max = 1.0, basal = 0.0001 }
reproduction = { kind = "asexual", rate = 0.2, energy_min = 0.5, energy_given = 0.2 }
lethal = [{ property = "energy", min = 0.0, cause_below = "starved" }]
"""
HALVED = {"kind": "cull", "species": "moss", "share": 0.5}
ASKED = {"kind": "pairs", "tick": 4, "what": HALVED, "seeds": 3, "ticks": 10}


@pytest.fixture
def world(tmp_path):
    (tmp_path / "moss.toml").write_text(MOSS)
    return str(tmp_path / "moss.toml")


def pair(world):
    live = Live(World.from_config(load(world), seed=1, record=False))
    return Pair(live, start=Start(["run", world, "--seed", "1", "--ticks", "12"]))


def outcome(pair):
    """The last message about the pairs."""
    until = time.monotonic() + 120
    while time.monotonic() < until:
        for message in pair.news():
            if message["kind"] == "pairs" and ("html" in message or "problem" in message):
                return message
        time.sleep(0.05)
    raise TimeoutError


def test_the_command_keeps_the_options_of_the_world_and_adds_the_change_to_what_was_done():
    start = Start(["run", "moss", "--seed", "7", "--ticks", "9", "--set", "a=1"], [{"at": 2, "kind": "x"}])
    words = command_of(start, [{"at": 3, "kind": "y"}], 5, {"kind": "z"}, 20, 99)
    both = 'interventions=[{ at = 2, kind = "x" }, { at = 3, kind = "y" }'
    assert words == [
        *("compare", "moss", "--set", "a=1", "--set", f"{both}]"),
        *("--treatment", f'{both}, {{ at = 5, kind = "z" }}]', "--seeds", "20", "--ticks", "99"),
    ]
    with pytest.raises(ValueError, match="--no-learn applies to one run"):
        command_of(Start(["run", "moss", "--no-learn"]), [], 5, {"kind": "z"}, 20, 99)


def test_pairs_have_the_numbers_of_a_comparison_of_the_same_change(world, tmp_path):
    shown = pair(world)
    assert [message["done"] for message in shown.handle(ASKED)] == [0]
    place = shown.replicates.place
    told = outcome(shown)
    assert (told.get("problem"), told["done"], told["of"]) == (None, 6, 6)
    assert not place.exists()
    assert shown.replicates is None
    treated = 'interventions=[{ at = 4, kind = "cull", species = "moss", share = 0.5 }]'
    wanted = compare(world, [treated], out=tmp_path / "out", seeds=3, ticks=10, workers=1)
    (effects,) = wanted["effects"].values()
    mean, _, high = effects["per_species"]["moss"]["mean_number"]
    assert high < 0
    assert told["html"] == (tmp_path / "out" / "compare.html").read_text()
    assert told["lines"][2].startswith(f"moss: mean number −{abs(mean):.3g} (95%")
    assert told["command"].startswith(f"ecs-eco compare {world} --treatment 'interventions=")


def test_of_a_recorded_run_too(world, tmp_path):
    by_hand = f"ecs-eco run {world} --seed 1 --out DIR"
    run_to_folder(world, seed=1, out=tmp_path / "run", report=False, command=by_hand)
    shown = Pair(Replay(tmp_path / "run"))
    shown.handle({"kind": "seek", "tick": 3})
    shown.handle(ASKED | {"tick": None})
    assert " at = 4," in shown.replicates.command
    shown.handle({"kind": "pairs", "stop": True})
    assert shown.replicates is None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"what": None}, "what = null"),
        ({"seeds": 1}, "seeds = 1"),
        ({"ticks": 4}, "ticks = 4"),
        ({"what": {"kind": "cull", "species": "mos"}}, "mos"),
    ],
)
def test_a_request_that_cannot_be_run_names_the_value(world, change, words):
    shown = pair(world)
    with pytest.raises(ValueError, match=words):
        shown.handle(ASKED | change)
    assert shown.replicates is None


def test_a_world_without_a_command_cannot_have_other_seeds(world):
    shown = pair(world)
    shown.begun = None
    with pytest.raises(ValueError, match="no command started this world"):
        shown.handle(ASKED)


@pytest.mark.parametrize("option", ["--trust", "--on=ray", "--record=full"])
def test_the_command_in_a_strangers_recording_cannot_allow_code(world, tmp_path, option):
    by_hand = f"ecs-eco run {world} --seed 1 {option} --out DIR"
    run_to_folder(world, seed=1, out=tmp_path / "run", report=False, command=by_hand)
    shown = Pair(Replay(tmp_path / "run"))
    with pytest.raises(ValueError, match="no command started this world"):
        shown.handle(ASKED)


def test_a_comparison_that_fails_gives_its_reason(world, tmp_path):
    shown = pair(world)
    shown.begun = Start(["run", str(tmp_path / "mos.toml")])
    shown.handle(ASKED)
    assert "mos.toml" in outcome(shown)["problem"]


def test_the_first_difference_is_the_first_that_lasts():
    ticks = 3 * SUSTAINED
    same = [[10] * ticks, [12] * ticks, [11] * ticks]
    late = [[n + (t >= SUSTAINED) * (5 + k) for t, n in enumerate(run)] for k, run in enumerate(same)]
    brief = [[n + (20 <= t < 20 + SUSTAINED - 1) for t, n in enumerate(run)] for run in same]
    noisy = [[n + (-1) ** k * 9 for n in run] for k, run in enumerate(same)]
    one = [load_series({"owl": a, "hare": a, "lynx": a, "newt": a}) for a in same]
    other = [
        load_series({"owl": late[k], "hare": brief[k], "lynx": noisy[k], "newt": [n + 1 for n in same[k]]})
        for k in range(3)
    ]
    assert first_differences(one, other) == {"newt": 0, "owl": SUSTAINED}
