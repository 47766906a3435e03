"""Interventions by hand are those of the file: in a living world, a saved one and a fork."""

import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.engine.errors import ConfigError
from ecs_eco.testing import check_world
from tests.systems.interventions import small, world

CASES = {
    "a cull of half the wolves": {"kind": "cull", "species": "wolf", "share": 0.5},
    "newcomers": {"kind": "add", "species": "deer", "count": 12, "region": [10.0, 10.0, 8.0]},
    "a doubled birth rate": {"kind": "set", "set": {"species.deer.reproduction.rate": 0.028}},
    "a fence": {"kind": "fence", "line": [[5.0, 30.0], [55.0, 33.0]]},
    "no births": {"kind": "switch", "reproduction": False},
    "learning": {"kind": "switch", "learning": True},
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("tick", [0, 5])
def test_in_the_file_and_by_hand_at_the_same_tick_are_the_same(name, tick):
    what = CASES[name]
    planned = world(what | {"at": tick})
    by_hand, alone = world(), world()
    by_hand.run(tick)
    by_hand.intervene(what)
    for w in (planned, by_hand, alone):
        w.run(14 - w.tick)
    assert planned.digest() == by_hand.digest() != alone.digest()
    assert planned.intervened == by_hand.intervened
    again = world(*(done for _, done in by_hand.intervened)).run(14)
    assert again.digest() == by_hand.digest()


@pytest.mark.parametrize("name", CASES)
def test_a_world_saved_before_or_after_an_intervention_goes_on_the_same(name, tmp_path):
    planned = world(CASES[name] | {"at": 4})
    for tick in (3, 6):
        planned.run(tick - planned.tick)
        planned.save(tmp_path / f"{tick}.safetensors")
    asked = world().run(4)
    asked.intervene(CASES[name])
    asked.save(tmp_path / "asked.safetensors")
    end = planned.run(12 - planned.tick).digest()
    for file in sorted(tmp_path.iterdir()):
        restored = World.restore(file)
        assert restored.run(12 - restored.tick).digest() == end, file.name
        assert restored.intervened == planned.intervened


@pytest.mark.parametrize("name", ["a cull of half the wolves", "a doubled birth rate", "a fence"])
def test_in_the_file_and_in_a_fork_of_a_checkpoint_are_the_same(name, tmp_path):
    from ecs_eco.record import run_to_folder
    from ecs_eco.runs.run import fork

    what = CASES[name] | {"at": 6}
    run_to_folder(
        small(),
        seed=4,
        ticks=8,
        out=tmp_path / "burnt-in",
        policies="untrained",
        checkpoint_every=4,
        keep=9,
        report=False,
    )
    asked = {"interventions": [what]} if what["kind"] != "set" else what["set"]
    forked = fork(
        tmp_path / "burnt-in", tmp_path / "fork", from_tick=6, changes=asked, until=14, report=False
    )
    planned = run_to_folder(
        small(what), seed=4, ticks=14, out=tmp_path / "planned", policies="untrained", report=False
    )
    assert forked["digest"] == planned["digest"]
    assert planned["intervened"] == [[6, what | planned["intervened"][0][1]]]


def test_a_world_with_interventions_keeps_the_promises_of_worlds():  # among them: no fate depends on rows
    check_world(small(*(what | {"at": 1 + i} for i, what in enumerate(CASES.values()))), ticks=9)


def test_a_world_made_by_hand_intervenes_too_and_says_what_it_lacks():
    from ecs_eco.systems import Intervene

    w = World([20.0, 20.0])
    w.add_table("stone", Position)
    with pytest.raises(RuntimeError, match=r"add_system\(Intervene\(\)\)"):
        w.intervene({"kind": "cull", "species": "stone", "count": 1})
    w.add_system(Intervene())
    w.spawn("stone", n=3)
    w.flush()
    w.intervene({"kind": "cull", "species": "stone", "count": 1})
    w.intervene({"kind": "add", "species": "stone", "count": 3})
    w.run(1)
    assert w.tables["stone"].n == 5
    with pytest.raises(ValueError, match=r"unknown table 'ston'.*did you mean \"stone\""):
        w.intervene({"kind": "cull", "species": "ston", "count": 1})
    with pytest.raises(ValueError, match="has no configuration"):
        w.intervene({"kind": "set", "set": {"dt": 2.0}})


def test_by_hand_a_wrong_intervention_is_refused_as_in_a_file():
    w = world().run(2)
    with pytest.raises(ConfigError, match=r'species = "wofl"(.|\n)*did you mean "wolf"'):
        w.intervene({"kind": "cull", "species": "wofl", "share": 0.5})
    with pytest.raises(ConfigError, match="no such fence exists"):
        w.intervene({"kind": "fence", "line": [[1.0, 1.0], [2.0, 2.0]], "remove": True})
    with pytest.raises(ValueError, match="it is tick 2 now"):
        w.intervene({"kind": "cull", "species": "wolf", "share": 0.5, "at": 7})
    assert w.run(1).intervened == []
