"""Interventions in a world file: when they are due, how they are said, and what is wrong with wrong ones."""

import json

import pytest

from ecs_eco.config import for_training, load
from ecs_eco.config.models.interventions import Cull, describe
from ecs_eco.engine.errors import ConfigError

CULL = {"kind": "cull", "at": 5, "species": "deer", "share": 0.5}
ADD = {"kind": "add", "at": 5, "species": "deer", "count": 3}
FENCE = {"kind": "fence", "at": 5, "line": [[1.0, 1.0], [9.0, 9.0]]}


def planned(*interventions, **more):
    return load("predator-prey", more | {"interventions": list(interventions)})


def refusal(*interventions, **more):
    with pytest.raises(ConfigError) as caught:
        planned(*interventions, **more)
    return "\n".join(f"{p.path}: {p}" for p in caught.value.problems)


@pytest.mark.parametrize(
    ("more", "ticks"),
    [
        ({}, [5]),
        ({"every": 3}, [5, 8, 11, 14, 17]),
        ({"every": 3, "until": 12}, [5, 8, 11]),
        ({"every": 1, "until": 6}, [5, 6]),
    ],
)
def test_an_intervention_is_due_at_its_tick_and_after_each_so_many_until_the_last(more, ticks):
    cull = Cull.model_validate(CULL | more)
    assert [t for t in range(20) if cull.due(t)] == ticks


def test_a_plan_is_part_of_what_a_world_is_and_survives_json():
    config = planned(
        CULL,
        FENCE,
        {"kind": "set", "at": 7, "set": {"species.deer.diet.0.chance": 0.5}},
        ADD | {"at_place": [3.0, 4.0]},
    )
    again = load(json.loads(json.dumps(config.resolved())))
    assert again.interventions == config.interventions
    assert again.config_hash == config.config_hash != planned(CULL).config_hash


def test_policies_are_trained_without_interventions():
    assert for_training(planned(CULL)).interventions == []


def test_a_world_file_says_them_in_toml(tmp_path):
    path = tmp_path / "park.toml"
    path.write_text("""format = 1
name = "park"
space = { size = [20.0, 20.0] }
species.moss = { count = 3, body = { radius = 0.1 } }

[[interventions]]
kind = "cull"
at = 10
every = 5
species = "moss"
count = 1

[[interventions]]
kind = "cull"
at = 12
species = "mos"
share = 2
""")
    with pytest.raises(ConfigError) as caught:
        load(path)
    text = str(caught.value)
    assert "park.toml, line 17: interventions.1.share = 2\n" in text
    assert "at most 1" in text
    assert (
        load(path, {"interventions.1.share": 0.5, "interventions.1.species": "moss"}).interventions[0].count
        == 1
    )


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"kind": "cul"}, 'did you mean "cull"'),
        ({"species": "der"}, 'did you mean "deer"'),
        ({"share": 1.5}, "at most 1"),
        ({"count": 3}, "exactly one of share, count and uids"),
        ({"share": None}, "exactly one of share, count and uids"),
        ({"uids": [7]}, "exactly one of share, count and uids"),
        ({"share": None, "uids": [0]}, "at least 1"),
        ({"at": 10_000}, "a run has 10000 ticks; expected: 0 to 9999"),
        ({"at": -1}, "at least 0"),
        ({"until": 9}, "given without `every`"),
        ({"every": 2, "until": 4}, "earlier than `at`; expected: at least 5"),
        ({"every": 0}, "at least 1"),
        ({"which": "fattest"}, "random, oldest, youngest, richest, poorest, largest, smallest"),
        ({"region": [1.0, 2.0, 300.0, 4.0]}, "outside the world along x"),
        ({"region": [3.0, 2.0, 2.0, 4.0]}, "empty along x"),
        ({"region": [300.0, 2.0, 3.0]}, "its center is outside the world"),
        ({"region": [30.0, 2.0, 0.0]}, "its radius is 0 m"),
        ({"region": [30.0, 2.0, 130.0]}, "at most 120 m"),
        ({"region": [30.0, 2.0]}, "at least 3 entries"),
        ({"specie": "deer"}, 'did you mean "species"'),
    ],
)
def test_a_wrong_cull_is_refused_with_what_is_allowed(wrong, message):
    text = refusal({k: v for k, v in (CULL | wrong).items() if v is not None})
    assert message in text
    assert text.startswith("interventions.0.")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (ADD | {"at_place": [300.0, 1.0]}, "outside the world"),
        (ADD | {"at_place": [1.0, 2.0, 3.0]}, "2 numbers"),
        (ADD | {"at_place": [1.0, 2.0], "region": [1.0, 2.0, 3.0]}, "given together with region"),
        (ADD | {"species": "grass", "at_place": [1.0, 2.0]}, "a site holds only one grass"),
        (ADD | {"count": 0}, "at least 1"),
        (FENCE | {"region": [1.0, 2.0, 3.0]}, "given together with line"),
        ({"kind": "fence", "at": 5}, "neither line nor region is given"),
        (FENCE | {"line": [[1.0, 1.0], [1.0, 241.0]]}, "a corner outside the world"),
        (FENCE | {"line": [[1.0, 1.0]]}, "at least 2 entries"),
        (FENCE | {"remove": True}, "no such fence exists"),
        ({"kind": "switch", "at": 5}, "neither reproduction nor learning is given"),
        ({"kind": "switch", "at": 5, "species": "grass", "learning": True}, "grass cannot learn"),
        ({"kind": "switch", "at": 5, "species": "wof", "learning": True}, 'did you mean "wolf"'),
        ({"kind": "set", "at": 5, "set": {}}, "at least 1"),
        ({"kind": "set", "at": 5, "set": {"species.wof.fertility": 0.5}}, 'did you mean "wolf"'),
        ({"kind": "set", "at": 5, "set": {"species.wolf.fertilty": 0.5}}, 'did you mean "fertility"'),
        ({"kind": "set", "at": 5, "set": {"species.wolf.fertility": 1.5}}, "at most 1"),
        (
            {"kind": "set", "at": 5, "set": {"species.wolf.count": 5}},
            'expected: an intervention of kind "add" or "cull"',
        ),
        (
            {"kind": "set", "at": 5, "set": {"interventions.0.at": 7}},
            "interventions cannot change other interventions",
        ),
    ],
)
def test_wrong_newcomers_fences_switches_and_values_are_refused(wrong, message):
    text = refusal(wrong)
    assert message in text
    assert text.startswith("interventions.0.")


def test_nobody_is_put_into_a_lake(menagerie):
    with pytest.raises(ConfigError, match=r"within terrain.lakes.0"):
        load(
            menagerie(),
            {
                "interventions": [
                    {"kind": "add", "at": 1, "species": "ram", "count": 1, "at_place": [31.0, 21.0]}
                ]
            },
        )


def test_values_are_checked_in_the_order_of_time_each_with_those_before():
    energy_max, energy = (
        {"kind": "set", "set": {f"species.deer.metabolism.{k}": v}}
        for k, v in (("energy_max", 3.0), ("energy", 2.0))
    )
    planned(energy | {"at": 9}, energy_max | {"at": 4})
    text = refusal(energy | {"at": 4}, energy_max | {"at": 9})
    assert text.startswith("interventions.0.set")
    assert "more than energy_max" in text


def test_a_wrong_key_beside_one_that_is_named_as_the_kind_is_named_itself():
    assert refusal({"kind": "set", "at": -1, "set": {"species.deer.fertility": 0.5}}).startswith(
        "interventions.0.at:"
    )


def test_a_fence_may_be_taken_away_once_for_each_time_it_was_put_up():
    planned(FENCE, FENCE | {"at": 7, "remove": True})
    assert refusal(FENCE, FENCE | {"at": 7, "remove": True}, FENCE | {"at": 8, "remove": True}).startswith(
        "interventions.2.remove"
    )


@pytest.mark.parametrize(
    ("what", "line"),
    [
        (CULL, "cull 50% of deer"),
        (
            CULL | {"share": 0.125, "which": "oldest", "cause": "caught", "region": [1.0, 2.0, 3.5]},
            "cull 12.5% of deer in [1, 2, 3.5], the oldest first (caught)",
        ),
        (
            {"kind": "cull", "species": "deer", "uids": [7, 12], "cause": "removed"},
            "cull #7 and #12 deer (removed)",
        ),
        ({"kind": "cull", "species": "deer", "uids": [1, 2, 3, 4]}, "cull 4 chosen deer"),
        (ADD, "add 3 deer"),
        (FENCE, "fence along [1, 1] [9, 9]"),
        ({"kind": "fence", "remove": True}, "remove fences"),
        ({"kind": "set", "set": {"species.deer.fertility": 0.5}}, "species.deer.fertility = 0.5"),
        ({"kind": "switch", "species": "deer", "reproduction": False}, "reproduction off for deer"),
        ("as it was", "as it was"),
    ],
)
def test_each_has_a_line_of_words(what, line):
    assert describe(what) == line
