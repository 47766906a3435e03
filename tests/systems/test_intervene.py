"""Interventions: who dies, who comes, and what is switched off and on."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Metabolism, Position
from ecs_eco.config import load
from ecs_eco.engine.random import draw
from ecs_eco.systems.intervene import Region
from ecs_eco.testing import arrange
from tests.systems.interventions import small, uids, world


def test_half_of_21_wolves_are_11_drawn_by_their_uids_and_they_die_at_the_end_of_the_phase_die():
    w = world(
        {"kind": "cull", "at": 2, "species": "wolf", "share": 0.5, "cause": "shot"},
        **{"species.wolf.reproduction.rate": 0.0},
    )
    w.run(2)
    before = sorted(uids(w.tables["wolf"]))
    by_draw = sorted(before, key=lambda u: draw(w.key, np.uint64(u), 12))
    half = int(0.5 * len(before) + 0.5)
    dead = []
    w.on_death.append(
        lambda t, rows: dead.extend(
            (w.causes[t.cause[r] - 1], int(t.uid[r])) for r in rows if t.name == "wolf"
        )
    )
    w.run(1)
    assert len(before) == 21
    assert half == 11
    assert {u for cause, u in dead if cause == "shot"} == set(by_draw[:11])
    assert w.intervened == [
        (2, {"at": 2, "kind": "cull", "species": "wolf", "share": 0.5, "which": "random", "cause": "shot"})
    ]


@pytest.mark.parametrize(
    ("which", "energy", "age", "chosen"),
    [
        ("richest", [0.2, 0.9, 0.5, 0.9], [1, 2, 3, 4], {(1, 3)}),
        ("poorest", [0.2, 0.9, 0.5, 0.9], [1, 2, 3, 4], {(0, 2)}),
        ("oldest", [0.5] * 4, [7, 3, 9, 7], {(0, 2), (2, 3)}),
        ("youngest", [0.5] * 4, [7, 3, 9, 7], {(0, 1), (1, 3)}),
    ],
)
def test_the_first_to_die_are_the_richest_or_oldest_and_of_equals_any(which, energy, age, chosen):
    died = set()
    for tick in range(12):
        w = world(
            {"kind": "cull", "at": tick, "species": "wolf", "count": 2, "which": which},
            **{"species.wolf.count": 4},
        )
        wolf, w.tick = arrange(w, "wolf", energy=energy, age=age), tick
        order = np.sort(wolf.uid[wolf.rows()])
        w.systems[0].process()
        died.add(tuple(np.searchsorted(order, np.sort(wolf.uid[wolf.doomed()])).tolist()))
    assert died == chosen


@pytest.mark.parametrize(("which", "chosen"), [("largest", {(1, 3)}), ("smallest", {(0, 2), (0, 4)})])
def test_the_first_to_die_are_the_largest_or_smallest_and_of_equals_any(which, chosen):
    died = set()
    for tick in range(12):
        w = world(
            {"kind": "cull", "at": tick, "species": "wolf", "count": 2, "which": which},
            **{"species.wolf.count": 5},
        )
        wolf, w.tick = arrange(w, "wolf", mass=[20.0, 41.0, 30.0, 45.0, 30.0]), tick
        order = np.sort(wolf.uid[wolf.rows()])
        w.systems[0].process()
        died.add(tuple(np.searchsorted(order, np.sort(wolf.uid[wolf.doomed()])).tolist()))
    assert died == chosen


def test_only_those_in_the_region_are_culled_and_a_circle_reaches_around_a_torus():
    w = world(
        {"kind": "cull", "at": 0, "species": "wolf", "share": 1.0, "region": [1.0, 30.0, 5.0]},
        **{"species.wolf.count": 4},
    )
    wolf = arrange(w, "wolf", x=[2, 57, 10, 59], y=[30, 30, 30, 36])  # 1, 4, 9 and √(4 + 36) m away
    order = np.sort(wolf.uid[wolf.rows()])
    w.systems[0].process()
    assert sorted(wolf.uid[wolf.doomed()]) == sorted(order[:2])
    square = Region(w.space, [0, 0, 10, 20])
    assert square.has(np.array([5.0, 5.0, 11.0]), np.array([5.0, 21.0, 5.0])).tolist() == [True, False, False]


def test_named_ones_are_culled_and_no_others_and_who_is_dead_already_does_not_matter():
    w = world(
        {"kind": "cull", "at": 0, "species": "wolf", "uids": [75, 10**9, 72], "cause": "removed"},
        **{"species.grass.count": 10, "species.wolf.count": 6},
    )
    wolf = w.tables["wolf"]
    assert uids(wolf) == {71, 72, 73, 74, 75, 76}  # after 10 tufts and 60 deer
    w.systems[0].process()
    assert sorted(wolf.uid[wolf.doomed()]) == [72, 75]
    assert {w.causes[c - 1] for c in wolf.cause[wolf.doomed()]} == {"removed"}


def test_newcomers_live_from_the_end_of_the_tick_with_the_next_uids_in_the_region_and_founders_energy():
    w = world(
        {"kind": "add", "at": 3, "species": "deer", "count": 40, "region": [10.0, 20.0, 30.0, 25.0]},
        **{"species.deer.reproduction.rate": 0.0},
    )
    w.run(3)
    first, deer = w.next_uid, w.tables["deer"]
    born = []
    w.on_birth.append(
        lambda t, rows, *_: (
            born.append(
                (
                    t.name,
                    t.uid[rows].tolist(),
                    t[Position].x[rows],
                    t[Position].y[rows],
                    t[Metabolism].energy[rows].copy(),
                )
            )
            if t.name == "deer"
            else None
        )
    )
    w.run(1)
    ((name, who, x, y, energy),) = born
    assert name == "deer"
    assert len(who) == 40
    assert who == list(range(who[0], who[0] + 40))
    assert who[0] >= first
    assert ((x >= 10) & (x <= 30) & (y >= 20) & (y <= 25)).all()
    assert len(np.unique(x)) == 40
    assert ((energy >= 0.375 - 1e-6) & (energy <= 0.625 + 1e-6)).all()
    assert energy.std() > 0.03
    assert (deer.born[np.isin(deer.uid, who)] == 3).all()
    assert not deer[Biology].age[np.isin(deer.uid, who)].any()


def test_newcomers_of_one_tick_come_to_different_places_and_not_to_those_of_the_founders():
    add = {"kind": "add", "at": 0, "species": "deer", "count": 60}
    w = world(add, add, **{"species.deer.reproduction.rate": 0.0})
    deer = w.tables["deer"]
    p, founders = deer[Position], deer.rows()
    places = [set(zip(p.x[founders].tolist(), p.y[founders].tolist(), strict=True))]
    for what in w.config.interventions:
        w.systems[0].add(w, what)
    places += [
        set(zip(v[Position, "x"].tolist(), v[Position, "y"].tolist(), strict=True)) for _, _, v in deer.births
    ]
    assert [len(x) for x in places] == [60, 60, 60]
    assert len(set().union(*places)) == 180


def test_plants_are_added_to_free_sites_only_and_no_more_than_max_count():
    more = {
        "species.grass.count": 390,
        "species.grass.reproduction.rate": 0.0,
        "species.grass.reproduction.seed_rain": 0.0,
        "species.deer.count": 1,
    }
    w = world(
        {"kind": "add", "at": 0, "species": "grass", "count": 30},
        {"kind": "add", "at": 0, "species": "deer", "count": 9},
        **more,
        **{"species.deer.max_count": 10, "training.set": {}},
    )
    w.config.interventions[1].__dict__["count"] = 50  # more than the file may say
    w.run(1)
    grass = w.tables["grass"]
    p, rows = grass[Position], grass.rows()
    sites = {(int(x // 3), int(y // 3)) for x, y in zip(p.x[rows], p.y[rows], strict=True)}
    assert grass.n >= 399  # 20 × 20 sites, and one deer that may have eaten
    assert len(sites) == grass.n
    assert w.tables["deer"].n <= 10


def test_all_come_to_the_place_that_is_named_objects_too(menagerie):
    w = World.from_config(
        load(
            menagerie(),
            {
                "interventions": [
                    {"kind": "add", "at": 1, "species": "boulder", "count": 2, "at_place": [3.0, 25.0]}
                ]
            },
        ),
        policies="untrained",
    )
    w.run(2)
    p, rows = w.tables["boulder"][Position], w.tables["boulder"].rows()
    assert sorted(zip(p.x[rows].tolist(), p.y[rows].tolist(), strict=True)) == [
        (3, 25),
        (3, 25),
        (20, 15),
        (33, 6),
    ]


def test_an_intervention_is_repeated_after_each_so_many_ticks_until_the_last():
    w = world({"kind": "cull", "at": 1, "every": 3, "until": 7, "species": "deer", "count": 1})
    w.run(12)
    assert [tick for tick, _ in w.intervened] == [1, 4, 7]
    assert w.series()["died: culled"].to_numpy().sum() == 3


# switches


def test_births_stop_and_go_on_for_one_species_or_for_all():
    more = {
        f"species.deer.reproduction.{key}": value
        for key, value in {"rate": 0.5, "energy_min": 0.0, "energy_given": 0.0}.items()
    }
    w = world(
        {"kind": "switch", "at": 2, "species": "deer", "reproduction": False},
        {"kind": "switch", "at": 4, "reproduction": True},
        {"kind": "switch", "at": 6, "reproduction": False},
        **more,
    )
    w.run(8)
    series = w.series().to_pydict()
    births = {
        s: [b for b, name in zip(series["births"], series["species"], strict=True) if name == s]
        for s in ("deer", "grass")
    }
    assert births["deer"][2:4] == [0, 0]
    assert births["deer"][6:] == [0, 0]
    assert min(births["deer"][:2] + births["deer"][4:6]) > 0
    assert sum(births["grass"][2:4]) > 0
    assert births["grass"][6:] == [0, 0]


@pytest.mark.parametrize("kind", ["shared", "individual"])
def test_learning_stops_and_goes_on(kind):
    more = {"species.deer.policy.kind": kind, "species.deer.policy.file": None, "species.deer.ppo.horizon": 4}
    w = world(
        {"kind": "switch", "at": 5, "learning": False, "species": "deer"},
        {"kind": "switch", "at": 9, "learning": True},
        **more,
        **{"species.deer.policy.learn": True},
    )
    nerves = w.tables["deer"].species.nerves
    learns = []
    for _ in range(11):
        w.run(1)
        learns.append(
            (nerves.learning, w.tables["wolf"].species.nerves.learning, w.config.species["deer"].policy.learn)
        )
    assert learns == [(True, False, True)] * 5 + [(False, False, False)] * 4 + [(True, True, True)] * 2


def test_a_world_that_was_built_to_learn_stops_when_told_to():
    w = World.from_config(small(), policies="untrained", learn=True, seed=4)
    w.intervene({"kind": "switch", "learning": False})
    w.run(1)
    assert not w.tables["deer"].species.nerves.learning
    assert w.tables["deer"].species.nerves.learner is None
