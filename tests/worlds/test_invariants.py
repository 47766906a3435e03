"""What holds in every world: on small worlds drawn at random, and in the one with everything."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from ecs_eco import World
from ecs_eco.testing import all_threads, check_world, difference, shuffle, state, watch
from ecs_eco.testing.world import note


def _number(low, high):
    return st.floats(low, high, width=32, allow_nan=False).map(lambda v: float(v) if abs(v) > 1e-4 else 0.0)


@st.composite
def _plant(draw, name, room):
    spacing = draw(st.sampled_from([1.0, 2.0, 3.0]))
    near = draw(st.booleans())
    way = {
        "kind": "spread",
        "rate": draw(_number(0, 0.25)),
        "seed_rain": draw(_number(0, 0.125)),
        "spacing": spacing,
    }
    return {
        "count": draw(st.integers(1, max(1, room // int(spacing**2) // 2))),
        "body": {"radius": draw(_number(0.125, 0.5)), "opaque": draw(st.booleans())},
        "metabolism": {"energy": 0.25, "energy_max": 0.5, "photosynthesis": draw(_number(0, 0.25))},
        "emits": draw(st.sampled_from([{}, {"smell": 1.0}])),
        "reproduction": draw(
            st.sampled_from([None, way | ({"place": "near", "dispersal": 4.0} if near else {})])
        ),
    }


def _sensors(draw, kinds):
    sensors = [
        {"kind": "own", "property": "energy"},
        {"kind": "smell", "field": "smell", "at": [1.0, draw(_number(-1, 1))]},
    ]
    sensors += [
        {
            "kind": "nearest",
            "target": target,
            "range": draw(_number(1, 6)),
            "occlusion": draw(st.booleans()),
            "fov": draw(st.sampled_from([2.0, 6.283185])),
        }
        for target in draw(st.lists(st.sampled_from(kinds), max_size=3, unique=True))
    ]
    if draw(st.booleans()):
        sensors.append(
            {"kind": "rays", "count": 3, "range": 4.0, "targets": [draw(st.sampled_from(kinds)), "wall"]}
        )
    if draw(st.booleans()):
        sensors.append({"kind": "touch", "target": draw(st.sampled_from([*kinds, "any", "wall"]))})
    return sensors


def _reproduction(draw):
    place = draw(st.sampled_from(["anywhere", "near", None]))
    return place and {
        "kind": "asexual",
        "place": place,
        "rate": draw(_number(0, 0.125)),
        "energy_min": 0.5,
        "energy_given": draw(_number(0, 0.5)),
        "spacing": draw(st.sampled_from([0.0, 1.0])),
    }


@st.composite
def _animal(draw, name, kinds, dims, dt):
    actions = {"speed": ["still", "go"], "turn": ["left", "none", "right"], "eat": ["eat"]} | (
        {"climb": ["up", "none", "down"]} if dims == 3 else {}
    )
    return {
        "count": draw(st.integers(1, 30)),
        "max_count": draw(st.sampled_from([None, 60])),
        "body": {
            "radius": draw(_number(0.25, 1)),
            "solid": draw(st.booleans()),
            "opaque": draw(st.booleans()),
        },
        "sex": draw(st.sampled_from(["none", "random"])),
        "substances": {"salt": 0.1},
        "metabolism": {
            "energy": draw(_number(0.25, 1)),
            "basal": draw(_number(0, 0.0625)),
            "handling_time": draw(st.sampled_from([0.0, 3.0])),
        },
        "locomotion": {
            "speed": {"still": 0.0, "go": draw(_number(0, 3)) / dt},
            "cost": {"go": draw(_number(0, 0.125))},
            "turn": 1.0,
            "climb": 1.0,
        },
        "emits": draw(st.sampled_from([{}, {"smell": 0.5}])),
        "diet": [
            {
                "eats": food,
                "reach": draw(_number(0, 1)),
                "chance": draw(_number(0, 1)),
                "gain": draw(_number(0, 0.5)),
            }
            for food in draw(st.lists(st.sampled_from(kinds), min_size=1, max_size=2, unique=True))
        ],
        "sensors": _sensors(draw, kinds),
        "actions": actions,
        "default_action": {"speed": draw(st.sampled_from(["still", "go"])), "turn": "none"},
        "always_on": draw(st.sampled_from([[], ["eat"]])),
        "reflex": draw(st.sampled_from([None, {"formulas": {"go": "0.5 - energy", "left": "smell - 0.25"}}])),
        "happiness": {"formula": "energy + 0.125 * smell", "minimum": -1.0},
        "policy": draw(st.sampled_from([{"kind": "none"}, {"kind": "shared", "hidden": [4]}])),
        "reproduction": _reproduction(draw),
        "lethal": [
            {"property": "energy", "min": 0.0, "cause_below": "starved"},
            {"property": "age", "max": draw(_number(8, 64)), "cause_above": "too old"},
        ],
        "remains": draw(st.sampled_from([None, "carcass"])),
    }


@st.composite
def _worlds(draw):
    size = draw(st.sampled_from([[12.0, 12.0], [20.0, 13.0], [15.0, 12.0, 12.0]]))
    dt = draw(st.sampled_from([0.25, 1.0, 2.0]))
    plants = ["moss", "fern"][: draw(st.integers(0, 2))]
    animals = ["ant", "bee", "cat"][: draw(st.integers(1, 3))]
    kinds = [*plants, *animals]
    rocks = {
        "cell": 1.0,
        "rocks": [{"at": [5.0, 5.0], "radius": 2.0}],
        "hills": {"amplitude": 1.0, "scale": 6.0},
    }
    species = {name: draw(_plant(name, int(size[0] * size[1]))) for name in plants}
    species |= {name: draw(_animal(name, kinds, len(size), dt)) for name in animals}
    if draw(st.booleans()):
        species = dict(reversed(species.items()))
    return {
        "format": 1,
        "name": "drawn",
        "dt": dt,
        "seed": draw(st.integers(0, 2**40)),
        "space": {
            "size": size,
            "edges": draw(st.sampled_from(["torus", "walls"])),
            "cell": draw(st.sampled_from([None, 1.0, 5.0, 12.0])),
        },
        "terrain": draw(st.sampled_from([None, rocks])),
        "substances": {"salt": ""},
        "fields": {"smell": {"cell": 1.5, "diffusion": 0.5, "decay": draw(_number(0, 1))}},
        "objects": {"carcass": {"count": 1, "body": {"radius": 0.25, "opaque": False}}},
        "species": species,
    }


@pytest.mark.slow
@settings(max_examples=30, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
@given(config=_worlds(), policies=st.sampled_from(["untrained", "random"]))
def test_every_world_keeps_its_promises(config, policies):
    """Ids, bounds, books, numbers; the same bytes again and with two threads; no fate depends on rows.

    See check_world.
    """
    check_world(lambda threads: World.from_config(config, policies=policies, threads=threads), ticks=50)


def test_the_world_with_everything_keeps_its_promises(menagerie):
    check_world(
        lambda threads: World.from_config(menagerie(), policies="untrained", threads=threads), ticks=80
    )


def test_rows_in_any_order_change_no_fate(menagerie):
    plain, lives = World.from_config(menagerie(), policies="untrained", seed=9), []
    note(plain, lives)
    plain.run(70)
    for seed in (1, 2):
        mixed, lives_too = shuffle(World.from_config(menagerie(), policies="untrained", seed=9), seed), []
        assert (mixed.tables["ram"].uid[:40] != np.sort(mixed.tables["ram"].uid[:40])).any()
        note(mixed, lives_too)
        mixed.run(70)
        assert difference(state(plain), state(mixed)) == ""
        assert lives_too == lives
    assert len(lives) > 60


def test_another_seed_is_another_world(menagerie):
    one, two = (World.from_config(menagerie(), policies="untrained", seed=s).run(5) for s in (1, 2))
    assert difference(state(one), state(two))


@pytest.mark.slow
def test_learning_is_the_same_on_two_threads_and_in_any_order_of_rows(menagerie):
    """Weights, optimiser states and rollouts too, over several updates."""
    config = menagerie(species={"ram": {"count": 150, "ppo": {"horizon": 8, "minibatch_size": 300}}})

    def make(threads=1):
        return World.from_config(config, policies="untrained", learn=True, threads=threads)

    one = make()
    watch(one, 30)
    learner = one.tables["ram"].species.nerves.learner
    assert learner.updates >= 3
    with all_threads():
        two = make(2).run(30)
    assert two.digest() == one.digest()
    weights, others = learner.state(), two.tables["ram"].species.nerves.learner.state()
    assert all((weights[k] == others[k]).all() for k in weights)
    mixed = shuffle(make()).run(30)
    assert difference(state(one), state(mixed)) == ""
    others = mixed.tables["ram"].species.nerves.learner.state()
    differ = [k for k in weights if weights[k].shape != others[k].shape or (weights[k] != others[k]).any()]
    assert set(differ) <= {"rollout.row", "rollout.last"}  # rows are what was shuffled


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_are_used_when_they_are_tested(menagerie, threads):
    used = set()
    with all_threads():
        world = World.from_config(menagerie(), policies="untrained", threads=threads)
        take_turns, divide = world.workers._take_turns, world.workers.team.run

        def watched(first, others):
            used.add(getattr(getattr(first, "func", first), "__name__", ""))
            return take_turns(first, others)

        def in_parts(kernel, *arguments):
            used.add(kernel.__name__)
            return divide(kernel, *arguments)

        world.workers._take_turns, world.workers.team.run = watched, in_parts
        world.run(1)
    # the last: of what is done together, fields
    assert {"move", "burn", "propose", "grow", "push_apart", "_bearings", "infer_shared", "spread"} <= used
