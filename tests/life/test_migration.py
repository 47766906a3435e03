"""Migrants: who leaves, what goes along, and how they arrive."""

import numpy as np
import pytest

from ecs_eco import World, component, f32
from ecs_eco.components import Biology, Experience, Load, Memory, Metabolism, Parentage, Policy, Position
from ecs_eco.config import load
from ecs_eco.config.loading import island_of
from ecs_eco.life.migration import admit, copied, emigrants, leave
from ecs_eco.record.ledger import imbalance
from ecs_eco.record.matter import imbalance as matter_imbalance
from ecs_eco.testing import shuffle
from tests.learning.networks import Gru


@component
class Marks:
    """A component of one's own."""

    left: f32 = 0.0
    pair: f32[2] = 0.0


def archipelago(config, ticks=5, **plan):
    plan = {"islands": 3, "migration_interval": 5, "migration_probability": {"ram": 0.3, "lynx": 0.5}} | plan
    base = load(config | {"archipelago": plan})
    return [
        World.from_config(island_of(base, name), policies="untrained", learn=True).run(ticks)
        for name in base.archipelago.names
    ]


def exchange(worlds):
    sent = [copied(world) for world in worlds]
    for world in worlds:
        leave(world)
    for world in worlds:
        admit(world, enumerate(sent))
    return sent


def test_who_leaves_depends_on_uids_and_not_on_rows(menagerie):
    world = archipelago(menagerie())[0]
    before = {name: world.tables[name].uid[rows].tolist() for name, (rows, _) in emigrants(world).items()}
    shuffle(world, 5)
    after = {name: world.tables[name].uid[rows].tolist() for name, (rows, _) in emigrants(world).items()}
    assert before == after
    assert 0 < len(before["ram"]) < world.tables["ram"].n


def test_nobody_leaves_between_barriers_or_without_a_way(menagerie):
    assert emigrants(archipelago(menagerie(), ticks=4)[0]) == {}
    edges = {"graph": "own", "edges": [["island_2", "island_1"]]}
    first, second, third = archipelago(menagerie(), **edges)
    assert emigrants(first) == emigrants(third) == {}
    assert set(np.concatenate([to for _, to in emigrants(second).values()])) == {0}


def test_leaving_is_no_death_and_arriving_no_birth_and_nobody_is_lost(menagerie):
    worlds = archipelago(menagerie())
    heard = []
    for world in worlds:
        world.on_death.append(lambda *_: heard.append("death"))
        world.on_birth.append(lambda *_: heard.append("birth"))
    before = [{n: set(w.tables[n].uid[w.tables[n].rows()].tolist()) for n in ("ram", "lynx")} for w in worlds]
    sent = exchange(worlds)
    after = [{n: set(w.tables[n].uid[w.tables[n].rows()].tolist()) for n in ("ram", "lynx")} for w in worlds]
    assert heard == []
    for name in ("ram", "lynx"):
        assert sorted(u for w in before for u in w[name]) == sorted(u for w in after for u in w[name])
        for i, (was, now) in enumerate(zip(before, after, strict=True)):
            left = set(sent[i][name].uid.tolist())
            came = {u for s in sent for u in s[name].uid[s[name].to == i].tolist()}
            assert now[name] == (was[name] - left) | came
            assert left


@pytest.mark.slow
def test_all_columns_go_along_but_the_place_and_the_load(menagerie):
    alone = {
        "policy": {"kind": "individual", "network": Gru, "learn": True, "hidden": None},
        "ppo": {"horizon": 8},
        "components": [Marks],
    }
    worlds = archipelago(menagerie(species={"ram": alone}))
    ram = worlds[0].tables["ram"]
    ram[Marks].left[ram.rows()] = ram.uid[ram.rows()] % 97
    lynx = worlds[0].tables["lynx"]
    lynx[Load].object[lynx.rows()] = 5
    before = {
        int(u): {
            (c.__name__, f): np.array(a[r]) for c, held in ram.columns.items() for f, a in vars(held).items()
        }
        | {"born": int(ram.born[r])}
        for u, r in zip(ram.uid[ram.rows()], ram.rows(), strict=True)
    }
    sent = exchange(worlds)[0]
    for uid, to in zip(sent["ram"].uid.tolist(), sent["ram"].to, strict=True):
        table, row = worlds[to].locate(uid)
        assert table.born[row] == before[uid]["born"]
        for component_, held in table.columns.items():
            for field, array in vars(held).items():
                same = np.array_equal(array[row], before[uid][component_.__name__, field])
                assert same or (component_ is Position and field in "xyz"), (component_, field)
    there = worlds[1].tables["ram"]
    rows = there.rows()[there.uid[there.rows()] < 2**48]
    assert there[Marks].left[rows].tolist() == (there.uid[rows] % 97).tolist()
    for part, field in (
        (Policy, "weights"),
        (Memory, "state"),
        (Experience, "value"),
        (Biology, "age"),
        (Metabolism, "energy"),
    ):
        assert getattr(there[part], field)[rows].any(), (part, field)
    for uid, to in zip(sent["lynx"].uid.tolist(), sent["lynx"].to, strict=True):
        assert worlds[to].get(uid, Load).object == 0


def test_parents_are_known_on_the_new_island(menagerie):
    worlds = archipelago(menagerie(), ticks=20)
    born = {}
    for world in worlds:
        ram = world.tables["ram"]
        rows = ram.rows()
        born |= dict(zip(ram.uid[rows].tolist(), ram[Parentage].mother[rows].tolist(), strict=True))
    exchange(worlds)
    children = 0
    for world in worlds:
        ram = world.tables["ram"]
        for uid, mother in zip(ram.uid[ram.rows()].tolist(), ram[Parentage].mother[ram.rows()], strict=True):
            assert mother == born[uid]
            children += mother > 0
    assert children


def test_the_ledgers_of_energy_and_matter_close_with_export_and_import(menagerie):
    worlds = archipelago(menagerie())
    for _ in range(3):
        exchange(worlds)
        for world in worlds:
            world.run(5)
    moved = {"imported": 0.0, "exported": 0.0}
    for world in worlds:
        series = {k: np.array(v) for k, v in world.series().to_pydict().items()}
        assert np.abs(imbalance(series)).max() < 1e-5
        assert (series["immigrants"] > 0).any()
        for name in moved:
            moved[name] += series[name].sum()
        n, born, died, came, left = (
            series[k].reshape(-1, 3) for k in ("n", "births", "deaths", "immigrants", "emigrants")
        )
        assert (np.diff(n, axis=0) == (born - died + came - left)[1:]).all()
        pages = {k: np.array(v) for k, v in world.recorder.matter_series().to_pydict().items()}
        size = np.abs(pages["stock_before"]) + np.abs(pages["imported"]) + 1e-12
        assert (np.abs(matter_imbalance(pages)) / size).max() < 1e-5
        assert (pages["exported"] < 0).any()
    assert moved["imported"] == pytest.approx(moved["exported"])


def test_a_shared_policy_stays_and_learns_no_lesson_of_those_who_left(menagerie):
    worlds = archipelago(menagerie())
    ram = worlds[0].tables["ram"]
    rollout = ram.species.nerves.learner.rollout
    rows = emigrants(worlds[0])["ram"][0]
    opened = rollout.last[rows]
    opened = opened[opened >= 0]
    exchange(worlds)
    steps = rollout.steps[opened]
    assert rollout.ended[opened].all()
    assert steps["reward"].tolist() == steps["value"].tolist()  # an advantage of 0
    for world in worlds:
        world.run(20)  # and both islands go on learning


def test_migrants_with_other_columns_are_refused(menagerie):
    worlds = archipelago(menagerie())
    sent = [copied(world) for world in worlds]
    ram = sent[0]["ram"]
    ram.columns["Nervous.mood"] = ram.columns.pop("Nervous.happiness")
    leave(worlds[0])
    leave(worlds[1])
    with pytest.raises(ValueError, match=r"ram: migrants have .* as no column, .* the same columns"):
        admit(worlds[1], enumerate(sent))
