"""Carcasses hold what the dead body held, and feed those that eat them."""

import copy

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.testing import arrange, check_world
from ecs_eco.testing.stores import Stores

STEPPE = {
    "format": 1,
    "name": "steppe",
    "space": {"size": [20.0, 20.0]},
    "objects": {"carcass": {"body": {"radius": 0.2}, "energy": {"decay": 0.02}}},
    "species": {
        "grass": {
            "count": 60,
            "body": {"radius": 0.2, "opaque": False},
            "metabolism": {"energy": 0.5, "photosynthesis": 0.02},
            "reproduction": {"kind": "spread", "rate": 0.1, "seed_rain": 0.01, "spacing": 2.0},
        },
        "gnu": {
            "count": 40,
            "body": {"radius": 0.4},
            "remains": "carcass",
            "metabolism": {"energy": 0.75, "basal": 0.0625},
            "locomotion": {"speed": {"walk": 0.5}, "turn": 0.5},
            "diet": [{"eats": "grass", "reach": 0.25, "efficiency": 0.75}],
            "sensors": [{"kind": "nearest", "target": "grass", "range": 5.0}],
            "actions": {"speed": ["walk"], "turn": ["left", "none", "right"]},
            "always_on": ["walk"],
            "lethal": [{"property": "energy", "min": 0.0}, {"property": "age", "max": 9.0}],
        },
        "vulture": {
            "count": 10,
            "body": {"radius": 0.3},
            "remains": "carcass",
            "metabolism": {"energy": 0.5, "basal": 0.03125},
            "locomotion": {"speed": {"fly": 1.0}, "turn": 0.8},
            "diet": [{"eats": "carcass", "reach": 0.5, "efficiency": 0.5}],
            "sensors": [
                {"kind": "nearest", "target": "carcass", "range": 9.0},
                {"kind": "property", "property": "energy", "of": "carcass", "range": 9.0},
            ],
            "actions": {"speed": ["fly"], "turn": ["left", "none", "right"]},
            "always_on": ["fly"],
            "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
        },
    },
}


def _steppe(**objects):
    config = copy.deepcopy(STEPPE)
    config["objects"]["carcass"] |= objects
    return config


def _energy(world, name):
    table = world.tables[name]
    return table[Metabolism].energy[table.by_uid()]


@pytest.mark.definition("3 remains")
def test_a_carcass_holds_what_the_body_held_and_feeds_its_eater_by_that():
    config = _steppe(energy={"initial": 0.25})
    for name, count in (("grass", 0), ("gnu", 2), ("vulture", 2)):
        config["species"][name]["count"] = count
    world = World.from_config(config)
    gnu = arrange(world, "gnu", x=[5, 15], y=5, energy=[0.75, 0.5])
    arrange(world, "vulture", x=[5.25, 0], y=[5, 15], energy=0.5)
    world.kill(int(gnu.uid[gnu.by_uid()][0]), "shot")
    world.run(1)  # it falls and is eaten: 0.75 in it, half of that is gained; both birds burn 1/32
    assert world.tables["carcass"].n == 0
    assert _energy(world, "vulture").tolist() == pytest.approx([0.5 + 0.375 - 0.03125, 0.46875])
    world.kill(int(world.tables["vulture"].uid[world.tables["vulture"].by_uid()][1]), "shot")
    world.flush()
    assert _energy(world, "carcass").tolist() == [0.46875]
    world.intervene({"kind": "add", "species": "carcass", "count": 1})
    world.run(1)
    assert sorted(_energy(world, "carcass").tolist()) == [0.25, 0.46875]


def test_the_starved_leave_nothing_to_eat():
    world = World.from_config(_steppe())
    gnu = world.tables["gnu"]
    rows = gnu.by_uid()
    gnu[Metabolism].energy[rows[:3]] = 0.03125
    world.kill(int(gnu.uid[rows[4]]))
    world.run(1)
    assert _energy(world, "carcass").min() == 0


def test_the_books_close_from_grass_to_scavengers():
    world = World.from_config(_steppe(), seed=4)
    stores = Stores(world)
    held = {name: float(_energy(world, name).sum(dtype=float)) for name in world.recorder.names}
    eaten = {"grass": 0.0, "carcass": 0.0}

    def note(table, rows):
        if table.name in eaten:
            mine = [r for r in rows if world.causes[table.cause[r] - 1].startswith("eaten")]
            eaten[table.name] += float(table[Metabolism].energy[mine].sum(dtype=float))

    world.on_death.append(note)
    for _ in range(40):
        world.run(1)
        stores.note()
    series = world.series().to_pydict()
    sums = {}
    for name in world.recorder.names:
        mine = [i for i, n in enumerate(series["species"]) if n == name]
        sums[name] = {
            k: np.sum([series[k][i] for i in mine]) for k in ("endowed", "taken_in", "burnt", "given", "lost")
        }
        flow = sums[name]
        change = flow["endowed"] + flow["taken_in"] - flow["burnt"] - flow["given"] - flow["lost"]
        now = float(_energy(world, name).sum(dtype=float))
        assert now == pytest.approx(held[name] + change, abs=1e-4), name
    sums["carcass"] = stores.ledger["carcass"]
    # what gnus and vultures held when they died is what their carcasses began with
    dead = sums["gnu"]["lost"] + sums["vulture"]["lost"]
    assert sums["carcass"]["endowed"] == pytest.approx(dead, abs=1e-4)
    assert sums["carcass"]["endowed"] > 5
    assert sums["carcass"]["burnt"] > 0.1
    # who eats a carcass gains half of it as it was before it rotted in that tick, or is full
    assert 0.5 < sums["vulture"]["taken_in"] <= 0.5 * eaten["carcass"] / np.exp(-0.02) + 1e-6


@pytest.mark.definition("4 objects")
def test_scavengers_live_on_carcasses_and_starve_without():
    bare = _steppe()
    del bare["species"]["gnu"]["remains"]
    # none begins with more than 0.625, and burns 1/32 in a tick: without a meal all are dead by tick 20
    with_, without = (
        World.from_config(config, seed=2).run(21).tables["vulture"].n for config in (_steppe(), bare)
    )
    assert without == 0
    assert with_ >= 5


def test_worlds_with_carcasses_keep_their_promises():
    check_world(lambda threads: World.from_config(_steppe(), threads=threads, seed=3), ticks=40)


def test_what_a_run_resumes_from_is_all_there_is(tmp_path):
    whole = World.from_config(_steppe(), seed=5).run(30)
    part = World.from_config(_steppe(), seed=5).run(12)
    again = World.restore(part.save(tmp_path / "state.safetensors")).run(18)
    assert again.digest() == whole.digest()
    assert again.tables["carcass"].n > 0


def test_an_efficiency_on_what_holds_nothing_is_refused():
    with pytest.raises(ConfigError, match="carcass contains no energy"):
        load(_steppe(energy=None))
