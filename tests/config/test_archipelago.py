"""[archipelago]: what islands are, who is whose neighbour, and what is refused."""

import pytest

from ecs_eco.config import load
from ecs_eco.config.loading import island_of
from ecs_eco.engine.errors import ConfigError


def islands(menagerie, **more):
    return menagerie(
        archipelago={"islands": 3, "migration_interval": 5, "migration_probability": {"ram": 0.1}} | more
    )


def test_a_number_of_islands_are_so_many_alike(menagerie):
    plan = load(islands(menagerie)).archipelago
    assert plan.islands == {"island_1": {}, "island_2": {}, "island_3": {}}
    assert [plan.meets(tick) for tick in (0, 4, 5, 10)] == [False, False, True, True]


def test_an_island_has_values_of_its_own_and_a_seed(menagerie):
    own = {"a": {"species.ram.count": 7}, "b": {"species": {"lynx": {"count": 3}}, "seed": 99}, "c": {}}
    config = load(islands(menagerie, islands=own))
    a, b, c = (island_of(config, name) for name in "abc")
    assert (a.species["ram"].count, b.species["ram"].count, b.species["lynx"].count) == (7, 40, 3)
    assert len({a.seed, b.seed, c.seed, config.seed}) == 4
    assert b.seed == 99
    assert a.seed < 2**53
    assert [w.archipelago.first_uid >> 48 for w in (a, b, c)] == [0, 1, 2]
    assert load(b.resolved()).config_hash == b.config_hash


def test_a_world_without_islands_has_the_hash_that_it_had(menagerie):
    assert "archipelago" not in load(menagerie()).resolved()


@pytest.mark.parametrize(
    ("graph", "neighbours"),
    [
        ({"graph": "ring"}, [[1, 4], [0, 2], [1, 3], [2, 4], [0, 3]]),
        ({"graph": "full"}, [[1, 2, 3, 4], [0, 2, 3, 4], [0, 1, 3, 4], [0, 1, 2, 4], [0, 1, 2, 3]]),
        ({"graph": "grid"}, [[1, 3], [0, 2, 4], [1], [0, 4], [1, 3]]),
        (
            {"graph": "own", "edges": [["island_1", "island_5"], ["island_5", "island_2"]]},
            [[4], [], [], [], [1]],
        ),
    ],
)
def test_neighbours_by_hand(menagerie, graph, neighbours):
    assert load(islands(menagerie, islands=5, **graph)).archipelago.neighbours() == neighbours


def test_two_islands_in_a_ring_are_one_neighbour_each(menagerie):
    assert load(islands(menagerie, islands=2)).archipelago.neighbours() == [[1], [0]]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"islands": 1}, "at least 2"),
        ({"islands": 33}, "at most 32"),
        ({"every": 0}, "at least 1"),
        ({"migration_probability": {"ram": 1.5}}, "at most 1"),
        (
            {"migration_probability": {"rams": 0.5}},
            'no such species; expected: moss, ram, lynx; did you mean "ram"?',
        ),
        ({"migration_probability": {"moss": 0.5}}, "plants that spread keep their sites"),
        ({"graph": "star"}, "star"),
        ({"graph": "own"}, "is missing"),
        ({"edges": [["island_1", "island_2"]]}, 'graph = "own", or remove edges'),
        ({"graph": "own", "edges": [["island_1", "islnd_2"]]}, 'did you mean "island_2"?'),
        ({"graph": "own", "edges": [["island_1", "island_1"]]}, "to itself"),
        ({"graph": "own", "edges": [["island_1", "island_2"]] * 2}, "is already listed"),
        ({"here": "atlantis"}, "no such island"),
        ({"islands": {"a": {"species.ram.count": -1}, "b": {}}}, 'archipelago.islands.a."species.ram.count"'),
        ({"islands": {"a": {"species.ramm.count": 1}, "b": {}}}, 'did you mean "ram"?'),
        ({"islands": {"a": {"dt": 2.0}, "b": {}}}, "must be the same on all islands"),
        ({"islands": {"a": {}, "b": {"species.ram.policy.hidden": [4]}}}, "migrants take it with them"),
        (
            {"islands": {"a": {}, "b": {"substances": {"glucose": "", "oxygen": "", "hydron": "", "x": ""}}}},
            "differs from the other islands",
        ),
    ],
)
def test_a_bad_archipelago_is_refused_with_its_place(menagerie, wrong, said):
    with pytest.raises(ConfigError) as error:
        load(islands(menagerie, **wrong))
    assert said in str(error.value)
    assert "archipelago" in str(error.value)
