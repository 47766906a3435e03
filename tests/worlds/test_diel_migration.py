import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ecs_eco import World
from ecs_eco.components import Metabolism, Position
from ecs_eco.config import load
from ecs_eco.testing import check_world

SMALL = {
    "species.phytoplankton.count": 150,
    "species.copepod.count": 40,
    "species.krill.count": 12,
    "space.size": [20.0, 20.0, 20.0],
}


@pytest.fixture(scope="module")
def small():
    return load("diel-migration", SMALL)


@pytest.mark.slow
def test_the_sea_keeps_its_promises(small):
    check_world(lambda threads: World.from_config(small, policies="untrained", threads=threads), ticks=60)


def test_krill_have_no_energy_budget_and_are_never_full(small):
    world = World.from_config(small, policies="untrained", seed=3)
    krill = world.tables["krill"]
    before = krill[Metabolism].energy[krill.rows()].copy()
    world.run(150)
    assert (krill[Metabolism].energy[krill.rows()] == before).all()
    assert (before < small.species["krill"].metabolism.energy_max).all()
    assert sum(world.series().to_pydict()["died: eaten by krill"]) > 3


@pytest.mark.parametrize(
    "budget",
    [
        {},
        {
            "species.krill.metabolism.basal": 0.002,
            "species.krill.diet.0.efficiency": 0.7,
        },  # as in learning-krill
    ],
)
def test_energy_from_light_to_phytoplankton_to_copepods_to_krill_closes(budget):
    """What the eaten held is gained by the eater to the share `efficiency`, but for what does not fit in."""
    roomy = {"species.copepod.metabolism.energy_max": 8.0}  # what a copepod eats always fits in
    small = load("diel-migration", SMALL | budget | roomy)
    world = World.from_config(small, policies="untrained", seed=3, learn=False)
    eaten = {"phytoplankton": 0.0, "copepod": 0.0}
    gained, meals = {"copepod": 0.0, "krill": 0.0}, dict.fromkeys(eaten, 0)

    owed = []  # by those that starve: energy below 0

    def note(table, rows):
        owed.append(float(-table[Metabolism].energy[rows].clip(max=0).sum(dtype=float)))
        if table.name in eaten:
            prey = [r for r in rows if world.causes[table.cause[r] - 1].startswith("eaten")]
            eaten[table.name] += float(table[Metabolism].energy[prey].sum(dtype=float))
            meals[table.name] += len(prey)

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
    assert gained["copepod"] == pytest.approx(
        c["copepod"].diet[0].efficiency * eaten["phytoplankton"], rel=0.05
    )
    # what the dead held, the eaten too; what of it nobody gained is gone from the sea
    lost = sum(flows[n]["lost"] for n in flows)
    given, endowed = (sum(flows[n][k] for n in flows) for k in ("given", "endowed"))
    burnt, light = sum(flows[n]["burnt"] for n in flows), flows["phytoplankton"]["taken_in"]
    gone = lost - gained["copepod"] - gained["krill"]
    assert sum(_held(world, n) - start[n] for n in flows) == pytest.approx(
        light + endowed - given - burnt - gone, abs=3e-3
    )
    unused = sum(
        (1 - c[n].diet[0].efficiency) * eaten[prey]
        for n, prey in (("copepod", "phytoplankton"), ("krill", "copepod"))
    )
    # what is eaten still burns its share of that tick, after its eater has gained
    late = sum(
        meals[prey] * c[n].diet[0].efficiency * c[prey].metabolism.basal
        for n, prey in (("copepod", "phytoplankton"), ("krill", "copepod"))
    )
    assert gone >= unused - late - sum(owed) - 1e-3
    assert unused > 0.3


@settings(max_examples=10)
@given(
    seed=st.integers(0, 2**31),
    pitch=st.floats(0.01, 1.57),
    share=st.floats(0.01, 1.0),
    drag=st.sampled_from([0.0, 0.3, 50.0]),
    depth=st.floats(10.0, 40.0),
    sinking=st.floats(-5.0, 5.0).map(lambda v: v if abs(v) > 1e-3 else 0.0),
    dt=st.sampled_from([0.1, 1.0, 3.0]),
)
def test_nothing_swims_sinks_or_is_born_through_the_surface_or_the_bottom(
    small, seed, pitch, share, drag, depth, sinking, dt
):
    speed = 0.99 * share * min(depth, 20.0) / 2 / dt  # [m/s] no animal may cross half of the world in a tick
    way = {
        f"species.copepod.locomotion.{k}": v
        for k, v in (("pitch", pitch), ("drag", drag), ("speed.burst", speed))
    }
    body = {f"species.{n}.body.sinking": sinking for n in ("copepod", "phytoplankton")}
    size = {"space.size": [20.0, 20.0, depth], "water.thermocline": 0.0}
    few = {"species.phytoplankton.count": 20, "species.copepod.count": 15, "species.krill.count": 3}
    world = World.from_config(
        load(small, {**way, **body, **size, **few, "dt": dt}), policies="random", seed=seed, learn=False
    )
    for _ in range(8):
        world.step()
        for table in world.tables.values():
            z = table[Position].z[table.rows()]
            assert ((z >= 0) & (z <= np.float32(depth))).all(), (table.name, z.min(), z.max())


def _held(world, name):
    table = world.tables[name]
    return float(table[Metabolism].energy[table.rows()].sum(dtype=float))


def test_no_reflex_clock_or_depth_sensor_does_the_work():
    copepod = load("diel-migration").species["copepod"]
    assert copepod.reflex is None
    assert {s.kind for s in copepod.sensors} <= {
        "own",
        "light",
        "nearest",
        "approach",
        "smell",
        "gradient",
        "touch",
    }
    assert {s.property for s in copepod.sensors if s.kind == "own"} == {"energy"}
    assert "krill" not in {s.target for s in copepod.sensors if s.kind == "nearest"}
    assert copepod.actions["climb"] == ["up", "none", "down"]
    assert copepod.always_on == ["eat"]


def test_phytoplankton_lives_near_the_surface():
    world = World.from_config("diel-migration", policies="random", seed=2).run(400)
    table = world.tables["phytoplankton"]
    depth = 30.0 - table[Position].z[table.rows()]
    assert table.n > 100
    assert np.mean(depth) < 8.0
    assert table.n <= 800


def test_krill_chase_what_they_see_by_day_and_not_by_night():
    for start, chases in ((0.5, True), (0.0, False)):
        world = World.from_config(
            load(
                "diel-migration", {"sun.start": start, "species.copepod.count": 1, "species.krill.count": 1}
            ),
            policies="random",
            training=True,
            learn=False,
        )
        from ecs_eco.testing import arrange

        arrange(world, "copepod", x=20, y=10, z=29)
        krill = arrange(world, "krill", x=15, y=10, z=29, heading=0)
        world.run(1)
        gaits = krill.species.nerves.doing(krill, "chase")
        assert bool(gaits[krill.rows()[0]]) is chases
