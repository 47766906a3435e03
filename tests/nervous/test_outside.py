"""Policies that are functions, and what of their choices cannot be carried out."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Motor, Nervous
from ecs_eco.engine.errors import ConfigError
from ecs_eco.nervous.outside import options_of, taken
from ecs_eco.runs.run import run_to_folder
from ecs_eco.view.inspect import nerves as inspected

CONTINUOUS = {"actions": {"speed": {"continuous": [0.0, 2.0]}}, "default_action": {"speed": 0.5}}


def by_uid(x, uid):
    """The odd run to the left, the even stand still."""
    odd = (uid % 2).astype(np.int64)
    return np.stack([2 * odd, 1 - odd], 1)


def function_of(meadow, act, **more):
    return meadow(policy={"kind": "function", "function": act}, **more)


def test_a_function_decides_by_what_is_sensed_and_by_uids(meadow):
    world = function_of(meadow, by_uid, count=6).run(1)
    table = world.tables["deer"]
    rows = table.by_uid()
    odd = table.uid[rows] % 2 == 1
    decision = table[Nervous].decision[rows]
    assert decision[odd].tolist() == [[0, 0, 1, 1, 0, 0, 1]] * int(odd.sum())
    assert decision[~odd].tolist() == [[1, 0, 0, 0, 1, 0, 1]] * int((~odd).sum())


def test_a_function_gets_what_the_species_senses(meadow):
    seen = []
    world = function_of(meadow, lambda x, uid: seen.append((x.copy(), uid.copy())) or by_uid(x, uid))
    world.run(1)
    nerves = world.tables["deer"].species.nerves
    assert seen[0][0].shape == (2, len(nerves.channels))
    assert seen[0][1].tolist() == world.tables["deer"].uid[nerves.rows].tolist()


def test_a_world_with_a_function_goes_on_from_a_checkpoint_as_without(meadow, tmp_path):
    world = function_of(meadow, by_uid, count=8).run(3)
    path = world.save(tmp_path / "half")
    restored = World.restore(path, config=world.config)
    assert restored.run(4).digest() == world.run(4).digest()


def test_the_inspector_shows_what_was_chosen_and_no_probabilities(meadow):
    world = function_of(meadow, lambda x, uid: np.tile([1, 2], (len(uid), 1))).run(1)
    table = world.tables["deer"]
    shown = inspected(table, int(table.rows()[0]))
    chosen = {a["name"]: (a["chosen"], a["probability"]) for a in shown["actions"]}
    assert chosen["walk"] == (1, None)
    assert chosen["still"] == (0, None)


def test_reflexes_have_their_say_over_a_function(meadow):
    blocked = {"connections": [{"sensor": "energy", "action": "run", "weight": -1, "above": -1.0}]}
    world = function_of(meadow, lambda x, uid: np.tile([2, 1], (len(uid), 1)), reflex=blocked).run(1)
    table = world.tables["deer"]
    assert not table[Nervous].decision[table.rows(), 2].any()


def test_numbers_of_a_continuous_group_are_carried_out(meadow):
    world = function_of(
        meadow, lambda x, uid: np.linspace(0, 2, len(uid))[:, None], count=5, always_on=[], **CONTINUOUS
    )
    nerves = world.tables["deer"].species.nerves
    assert options_of(nerves) == {"turn": ("left", "none", "right"), "eat": ("no eat", "eat"), "speed": ()}
    alone = taken(nerves, world.tables["deer"], np.arange(3), [[0, 0, 0.0], [0, 0, 1.5], [0, 0, 2.0]], "test")
    assert alone.numbers[:, 0].tolist() == [-1.0, 0.5, 1.0]
    with pytest.raises(ConfigError, match="a column for each of turn, eat, speed"):
        world.run(1)


def test_a_continuous_choice_reaches_the_motor(meadow):
    world = function_of(
        meadow, lambda x, uid: np.tile([0, 1, 1.25], (len(uid), 1)), always_on=[], **CONTINUOUS
    ).run(1)
    table = world.tables["deer"]
    assert table[Motor].command[table.rows(), 0].tolist() == [1.25, 1.25]


@pytest.mark.parametrize(
    ("chosen", "says"),
    [
        (lambda n: np.zeros((n, 1)), r"float64\[2, 1\].*expected: numbers \[2, 2\]"),
        (lambda n: np.array([["a", "b"]] * n), "expected: numbers"),
        (lambda n: np.full((n, 2), 3), r"speed = 3\n.*no such option.*0 \(still\), 1 \(walk\), 2 \(run\)"),
        (lambda n: np.full((n, 2), -1), r"turn = -1"),
        (lambda n: np.full((n, 2), 0.5), r"speed = 0.5"),
        (lambda n: np.full((n, 2), np.nan), r"speed = nan\n.*not a number"),
        (lambda n: None, "expected: numbers"),
    ],
)
def test_what_cannot_be_carried_out_is_refused_with_organism_group_and_value(meadow, chosen, says):
    world = function_of(meadow, lambda x, uid: chosen(len(uid)))
    with pytest.raises(ConfigError, match=says) as error:
        world.run(1)
    assert "tick 0" in str(error.value)


def test_a_species_whose_policy_is_external_waits_for_somebody(meadow):
    world = meadow(policy={"kind": "external"})
    with pytest.raises(ConfigError, match=r'species.deer.policy.kind.*\n.*world.external\("deer"\)'):
        world.run(1)
    assert world.tick == 0
    world.external("deer")
    with pytest.raises(ConfigError, match="in the middle of a tick"):
        world.run(1)
    assert world.underway is None


def test_a_run_of_such_a_world_is_refused_before_there_is_a_folder(meadow, tmp_path):
    with pytest.raises(ConfigError, match="no program controls it"):
        run_to_folder(meadow(policy={"kind": "external"}).config, ticks=2, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_number_within_the_range_of_an_animal_is_carried_out_as_it_is(meadow):
    """The file's range is 0 to 2 m/s, and each animal's own range ends at 1 m/s."""
    gene = {"name": "v", "trait": "actions.speed.continuous.1", "letters": 1, "values": [1.0, 1.0]}
    world = function_of(
        meadow,
        lambda x, uid: np.tile([0, 1, 0.75], (len(uid), 1)),
        always_on=[],
        genome={"alphabet": "01", "genes": [gene]},
        **CONTINUOUS,
    ).run(1)
    table = world.tables["deer"]
    assert table[Motor].command[table.rows(), 0].tolist() == [0.75, 0.75]
