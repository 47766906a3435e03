"""Interventions: who dies, who comes, what is fenced off, what changes – and that by file and
by hand are the same."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Metabolism, Nervous, Position
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.engine.random import draw
from ecs_eco.space.terrain import FENCE
from ecs_eco.systems.intervene import Region
from ecs_eco.testing import arrange, check_world

SMALL = {
    "space.size": [60.0, 60.0], "species.grass.count": 250, "species.deer.count": 60,
    "species.wolf.count": 21,
    "species.deer.reproduction.energy_min": 0.4,
}  # fmt: skip


def small(*interventions, **more):
    return load("predator-prey", SMALL | more | {"interventions": list(interventions)})


def world(*interventions, **more):
    return World.from_config(small(*interventions, **more), policies="untrained", seed=4)


def uids(table):
    return set(table.uid[table.rows()].tolist())


def test_half_of_21_wolves_are_11_drawn_by_their_uids_and_they_die_at_the_end_of_the_phase_die():
    w = world({"kind": "cull", "at": 2, "species": "wolf", "share": 0.5, "cause": "shot"},
              **{"species.wolf.reproduction.rate": 0.0})
    w.run(2)
    before = sorted(uids(w.tables["wolf"]))
    by_draw = sorted(before, key=lambda u: draw(w.key, np.uint64(u), 12))
    half = int(0.5 * len(before) + 0.5)
    dead = []
    w.on_death.append(lambda t, rows: dead.extend((w.causes[t.cause[r] - 1], int(t.uid[r]))
                                                  for r in rows if t.name == "wolf"))
    w.run(1)
    assert len(before) == 21
    assert half == 11
    assert {u for cause, u in dead if cause == "shot"} == set(by_draw[:11])
    assert w.intervened == [(2, {"at": 2, "kind": "cull", "species": "wolf", "share": 0.5, "which": "random",
                                 "cause": "shot"})]


@pytest.mark.parametrize(("which", "energy", "age", "chosen"), [
    ("richest", [0.2, 0.9, 0.5, 0.9], [1, 2, 3, 4], [1, 3]),
    ("poorest", [0.2, 0.9, 0.5, 0.9], [1, 2, 3, 4], [0, 2]),
    ("oldest", [0.5] * 4, [7, 3, 9, 7], [2, 0]), ("youngest", [0.5] * 4, [7, 3, 9, 7], [1, 0]),
])  # fmt: skip
def test_the_first_to_die_are_the_richest_or_oldest_and_equals_go_by_the_lower_uid(which, energy,
                                                                                   age, chosen):
    w = world({"kind": "cull", "at": 0, "species": "wolf", "count": 2, "which": which},
              **{"species.wolf.count": 4})
    wolf = arrange(w, "wolf", energy=energy, age=age)
    order = np.sort(wolf.uid[wolf.rows()])
    w.systems[0].process()
    doomed = {int(u) for u in wolf.uid[wolf.doomed()]}
    assert doomed == {int(order[i]) for i in chosen}


def test_only_those_in_the_region_are_culled_and_a_circle_reaches_around_a_torus():
    w = world({"kind": "cull", "at": 0, "species": "wolf", "share": 1.0, "region": [1.0, 30.0, 5.0]},
              **{"species.wolf.count": 4})
    wolf = arrange(w, "wolf", x=[2, 57, 10, 59], y=[30, 30, 30, 36])  # 1, 4, 9 and √(4 + 36) m away
    order = np.sort(wolf.uid[wolf.rows()])
    w.systems[0].process()
    assert sorted(wolf.uid[wolf.doomed()]) == sorted(order[:2])
    square = Region(w.space, [0, 0, 10, 20])
    assert square.has(np.array([5.0, 5.0, 11.0]), np.array([5.0, 21.0, 5.0])).tolist() == [True, False, False]


def test_named_ones_are_culled_and_no_others_and_who_is_dead_already_does_not_matter():
    w = world({"kind": "cull", "at": 0, "species": "wolf", "uids": [75, 10**9, 72], "cause": "removed"},
              **{"species.grass.count": 10, "species.wolf.count": 6})  # fmt: skip
    wolf = w.tables["wolf"]
    assert uids(wolf) == {71, 72, 73, 74, 75, 76}  # after 10 tufts and 60 deer
    w.systems[0].process()
    assert sorted(wolf.uid[wolf.doomed()]) == [72, 75]
    assert {w.causes[c - 1] for c in wolf.cause[wolf.doomed()]} == {"removed"}


def test_newcomers_live_from_the_end_of_the_tick_with_the_next_uids_in_the_region_and_founders_energy():
    w = world({"kind": "add", "at": 3, "species": "deer", "count": 40, "region": [10.0, 20.0, 30.0, 25.0]},
              **{"species.deer.reproduction.rate": 0.0})
    w.run(3)
    first, deer = w.next_uid, w.tables["deer"]
    born = []
    w.on_birth.append(lambda t, rows, *_: born.append((t.name, t.uid[rows].tolist(), t[Position].x[rows],
                                                       t[Position].y[rows],
                                                       t[Metabolism].energy[rows].copy()))
                      if t.name == "deer" else None)
    w.run(1)
    (name, who, x, y, energy), = born
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
    places += [set(zip(v[Position, "x"].tolist(), v[Position, "y"].tolist(), strict=True))
               for _, _, v in deer.births]
    assert [len(x) for x in places] == [60, 60, 60]
    assert len(set().union(*places)) == 180


def test_plants_are_added_to_free_sites_only_and_no_more_than_max_count():
    more = {"species.grass.count": 390, "species.grass.reproduction.rate": 0.0,
            "species.grass.reproduction.seed_rain": 0.0, "species.deer.count": 1}  # fmt: skip
    w = world({"kind": "add", "at": 0, "species": "grass", "count": 30},
              {"kind": "add", "at": 0, "species": "deer", "count": 9},
              **more, **{"species.deer.max_count": 10, "training.set": {}})  # fmt: skip
    w.config.interventions[1].__dict__["count"] = 50  # more than the file may say
    w.run(1)
    grass = w.tables["grass"]
    p, rows = grass[Position], grass.rows()
    sites = {(int(x // 3), int(y // 3)) for x, y in zip(p.x[rows], p.y[rows], strict=True)}
    assert grass.n >= 399  # 20 × 20 sites, and one deer that may have eaten
    assert len(sites) == grass.n
    assert w.tables["deer"].n <= 10


def test_all_come_to_the_place_that_is_named_objects_too(menagerie):
    w = World.from_config(load(menagerie(),
                               {"interventions": [{"kind": "add", "at": 1, "species": "boulder", "count": 2,
                                                   "at_place": [3.0, 25.0]}]}),
                          policies="untrained")  # fmt: skip
    w.run(2)
    p, rows = w.tables["boulder"][Position], w.tables["boulder"].rows()
    assert sorted(zip(p.x[rows].tolist(), p.y[rows].tolist(), strict=True)) == [(3, 25), (3, 25),
                                                                                (20, 15), (33, 6)]


def test_an_intervention_is_repeated_after_each_so_many_ticks_until_the_last():
    w = world({"kind": "cull", "at": 1, "every": 3, "until": 7, "species": "deer", "count": 1})
    w.run(12)
    assert [tick for tick, _ in w.intervened] == [1, 4, 7]
    assert w.series()["died: culled"].to_numpy().sum() == 3


# fences


def walkers(w, x, y, heading):
    """Deer that run straight on, and nobody else."""
    deer = arrange(w, "deer", x=x, y=y, heading=heading)
    nerves = deer.species.nerves
    decision = deer[Nervous].decision
    decision[:] = 0
    decision[:, nerves.column("speed.run")] = 1
    decision[:, nerves.column("turn.none")] = 1
    return deer


def go(w, ticks):
    from ecs_eco.systems import Move

    move = next(s for s in w.systems if isinstance(s, Move))
    for _ in range(ticks):
        move.process()


@pytest.mark.parametrize("speed", [0.3, 1.0, 7.0])
def test_nobody_gets_out_of_a_round_fence_in_any_direction_and_who_is_outside_does_not_get_in(speed):
    n = 60
    more = {"species.deer.count": n, "species.deer.locomotion.speed.run": speed}
    w = world({"kind": "fence", "at": 0, "region": [50.0, 30.0, 15.0]}, **more)
    angle = 2 * np.pi * (np.arange(n) + 0.37) / n
    inside = np.arange(n) % 2 == 0
    r = np.where(inside, 2.0, 20.0)
    deer = walkers(w, (50 + r * np.cos(angle)) % 60, 30 + r * np.sin(angle),
                   np.where(inside, angle, angle + np.pi).astype(np.float32))
    order = deer.by_uid()
    w.systems[0].process()
    go(w, int(120 / speed))
    p = deer[Position]
    dx = p.x[order] - 50
    away = np.hypot(dx - 60 * np.round(dx / 60), p.y[order] - 30)
    assert (away[inside] < 15.5).all()
    assert (away[~inside] > 14.5).all()
    w.systems[0].fence(w, type(w.config.interventions[0]).model_validate({"kind": "fence", "at": 0,
                                                                          "remove": True}))
    go(w, int(120 / speed))
    assert not w.terrain.ground.any()


def test_who_stands_where_a_fence_is_put_up_walks_off_it_and_not_back():
    w = world({"kind": "fence", "at": 0, "line": [[30.0, 0.0], [30.0, 60.0]]}, **{"species.deer.count": 2})
    deer = walkers(w, [30.3, 30.3], [20, 40], np.array([0, np.pi], np.float32))
    order = deer.by_uid()
    w.systems[0].process()
    assert (w.terrain.ground[20:41, 50] == FENCE).all()  # cells of 0.6 m
    go(w, 3)
    p = deer[Position]
    assert p.x[order].tolist() == pytest.approx([33.3, 27.3], abs=1e-3)
    p.heading[order] = [np.pi, 0]
    go(w, 10)
    assert p.x[order][0] >= 30.6
    assert p.x[order][1] <= 30.0


def test_a_fence_changes_nothing_for_those_who_do_not_meet_it():
    fence = {"kind": "fence", "at": 0, "region": [29.0, 29.0, 29.6, 29.6]}
    plain, fenced = world(), world(fence)
    for w in (plain, fenced):  # nobody is near, and plants sprout on it as elsewhere
        deer, wolf = w.tables["deer"], w.tables["wolf"]
        for t in (deer, wolf):
            x = t[Position].x[t.rows()]
            t[Position].x[t.rows()] = np.where((x > 20) & (x < 40), 5, x)
            t.version += 1
        w.run(8)
    grass = [w.tables["grass"] for w in (plain, fenced)]
    assert uids(grass[0]) == uids(grass[1])
    assert plain.digest() != fenced.digest()  # for there is a fence
    fenced.terrain.unfence()
    assert plain.digest() == fenced.digest()


def test_a_fence_spares_lakes_and_crossing_fences_stand_when_one_is_taken_away(menagerie):
    across, along = [[0.0, 20.0], [40.0, 20.0]], [[30.0, 0.0], [30.0, 30.0]]
    w = World.from_config(menagerie(), policies="untrained")
    before = w.terrain.ground.copy()
    for line in (across, along):
        w.intervene({"kind": "fence", "line": line})
    w.run(1)
    both = w.terrain.ground.copy()
    assert (both[before > 0] == before[before > 0]).all()
    assert (both[19:21, 2] == FENCE).any()
    w.intervene({"kind": "fence", "line": along, "remove": True})
    w.run(1)
    left = w.terrain.ground
    assert (left[20] == both[20]).all()
    assert (left[5] == before[5]).all()
    w.intervene({"kind": "fence", "remove": True})
    w.run(1)
    assert (w.terrain.ground == before).all()


# switches


def test_births_stop_and_go_on_for_one_species_or_for_all():
    more = {f"species.deer.reproduction.{key}": value
            for key, value in {"rate": 0.5, "energy_min": 0.0, "energy_given": 0.0}.items()}
    w = world({"kind": "switch", "at": 2, "species": "deer", "reproduction": False},
              {"kind": "switch", "at": 4, "reproduction": True},
              {"kind": "switch", "at": 6, "reproduction": False}, **more)
    w.run(8)
    series = w.series().to_pydict()
    births = {s: [b for b, name in zip(series["births"], series["species"], strict=True) if name == s]
              for s in ("deer", "grass")}
    assert births["deer"][2:4] == [0, 0]
    assert births["deer"][6:] == [0, 0]
    assert min(births["deer"][:2] + births["deer"][4:6]) > 0
    assert sum(births["grass"][2:4]) > 0
    assert births["grass"][6:] == [0, 0]


@pytest.mark.parametrize("kind", ["shared", "individual"])
def test_learning_stops_and_goes_on(kind):
    more = {"species.deer.policy.kind": kind, "species.deer.policy.file": None, "species.deer.ppo.horizon": 4}
    w = world({"kind": "switch", "at": 5, "learning": False, "species": "deer"},
              {"kind": "switch", "at": 9, "learning": True},
              **more, **{"species.deer.policy.learn": True})  # fmt: skip
    nerves = w.tables["deer"].species.nerves
    learns = []
    for _ in range(11):
        w.run(1)
        learns.append((nerves.learning, w.tables["wolf"].species.nerves.learning,
                       w.config.species["deer"].policy.learn))
    assert learns == [(True, False, True)] * 5 + [(False, False, False)] * 4 + [(True, True, True)] * 2


def test_a_world_that_was_built_to_learn_stops_when_told_to():
    w = World.from_config(small(), policies="untrained", learn=True, seed=4)
    w.intervene({"kind": "switch", "learning": False})
    w.run(1)
    assert not w.tables["deer"].species.nerves.learning
    assert w.tables["deer"].species.nerves.learner is None


# by file and by hand

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
    run_to_folder(small(), seed=4, ticks=8, out=tmp_path / "burnt-in", policies="untrained",
                  checkpoint_every=4, keep=9, report=False)
    asked = {"interventions": [what]} if what["kind"] != "set" else what["set"]
    forked = fork(tmp_path / "burnt-in", tmp_path / "fork", from_tick=6, changes=asked, until=14,
                  report=False)
    planned = run_to_folder(small(what), seed=4, ticks=14, out=tmp_path / "planned", policies="untrained",
                            report=False)
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
    with pytest.raises(ValueError, match="without a configuration"):
        w.intervene({"kind": "set", "set": {"dt": 2.0}})


def test_by_hand_a_wrong_intervention_is_refused_as_in_a_file():
    w = world().run(2)
    with pytest.raises(ConfigError, match=r'species = "wofl"(.|\n)*did you mean "wolf"'):
        w.intervene({"kind": "cull", "species": "wofl", "share": 0.5})
    with pytest.raises(ConfigError, match="no such fence stands"):
        w.intervene({"kind": "fence", "line": [[1.0, 1.0], [2.0, 2.0]], "remove": True})
    with pytest.raises(ValueError, match="it is tick 2 now"):
        w.intervene({"kind": "cull", "species": "wolf", "share": 0.5, "at": 7})
    assert w.run(1).intervened == []
