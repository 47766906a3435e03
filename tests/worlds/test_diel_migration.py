import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism, Position
from ecs_eco.config import load
from ecs_eco.testing import check_world


@pytest.fixture(scope="module")
def small():
    return load("diel-migration", {"species.phytoplankton.count": 150, "species.copepod.count": 40, "species.krill.count": 12,
                                   "space.size": [20.0, 20.0, 20.0]})  # fmt: skip


def test_the_sea_keeps_its_promises(small):
    check_world(lambda threads: World.from_config(small, policies="untrained", threads=threads), ticks=60)


def test_energy_from_light_to_phytoplankton_to_copepods_to_krill_closes(small):
    """What the eaten held is gained by the eater to the share `efficiency`, but for what no longer fits in."""
    world = World.from_config(small, policies="untrained", seed=3, learn=False)
    eaten = {"phytoplankton": 0.0, "copepod": 0.0}
    gained = {"copepod": 0.0, "krill": 0.0}

    def note(table, rows):
        if table.name in eaten:
            prey = [r for r in rows if world.causes[table.cause[r] - 1].startswith("eaten")]
            eaten[table.name] += float(table[Metabolism].energy[prey].sum(dtype=float))

    world.on_death.append(note)
    start = {n: _held(world, n) for n in world.tables}
    world.run(150)
    series = world.series().to_pydict()
    flows = {}
    for i, name in enumerate(world.recorder.names):
        each = {k: float(np.sum(series[k][i::3])) for k in ("endowed", "taken_in", "burnt", "given", "lost")}
        flows[name] = each
        change = each["endowed"] + each["taken_in"] - each["burnt"] - each["given"] - each["lost"]
        assert _held(world, name) == pytest.approx(start[name] + change, abs=1e-3), name
        gained[name] = each["taken_in"]
    c = small.species
    assert eaten["copepod"] > 0.5
    assert eaten["phytoplankton"] > 1
    assert gained["krill"] <= c["krill"].diet[0].efficiency * eaten["copepod"] + 1e-3
    assert gained["krill"] == pytest.approx(c["krill"].diet[0].efficiency * eaten["copepod"], rel=0.35)
    assert gained["copepod"] == pytest.approx(c["copepod"].diet[0].efficiency * eaten["phytoplankton"], rel=0.05)


def _held(world, name):
    table = world.tables[name]
    return float(table[Metabolism].energy[table.rows()].sum(dtype=float))


def test_no_reflex_clock_or_depth_sensor_does_the_work():
    copepod = load("diel-migration").species["copepod"]
    assert copepod.reflex is None
    assert {s.kind for s in copepod.sensors} <= {"own", "light", "nearest", "approach", "smell", "gradient", "touch"}
    assert {s.property for s in copepod.sensors if s.kind == "own"} == {"energy"}
    assert "krill" not in {s.target for s in copepod.sensors if s.kind == "nearest"}
    assert copepod.actions["climb"] == ["up", "none", "down"]
    assert copepod.automatic == ["eat"]


def test_phytoplankton_lives_near_the_surface():
    world = World.from_config("diel-migration", policies="random", seed=2).run(400)
    table = world.tables["phytoplankton"]
    depth = 30.0 - table[Position].z[table.rows()]
    assert table.n > 100
    assert np.mean(depth) < 8.0
    assert table.n <= 800


def test_krill_chase_what_they_see_by_day_and_not_by_night():
    for start, chases in ((0.5, True), (0.0, False)):
        world = World.from_config(load("diel-migration", {"sun.start": start, "species.copepod.count": 1, "species.krill.count": 1}),
                                  policies="random", training=True, learn=False)  # fmt: skip
        from ecs_eco.testing import arrange

        arrange(world, "copepod", x=20, y=10, z=29)
        krill = arrange(world, "krill", x=15, y=10, z=29, heading=0)
        world.run(1)
        gaits = krill.traits["nerves"].doing(krill, "chase")
        assert bool(gaits[krill.rows()[0]]) is chases
