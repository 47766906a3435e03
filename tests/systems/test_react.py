"""Reactions: what they use up, make, give and need; what limits them."""

import numpy as np
import pytest

from ecs_eco.components import Chemistry, Matter, Metabolism, Nervous
from ecs_eco.engine.errors import ConfigError
from ecs_eco.life.matter import NUMBER, Bodies
from ecs_eco.systems import Metabolise, React
from ecs_eco.systems.react import Stores, react
from ecs_eco.testing import act, arrange

SUBSTANCES = {"glucose": "", "oxygen": "", "carbon_dioxide": "", "water": ""}
RESPIRATION = {
    "from": {"glucose": 1.0, "oxygen": 6.0},
    "to": {"carbon_dioxide": 6.0, "water": 6.0},
    "energy": 2.0,
    "rate": 0.01,
}
PHOTOSYNTHESIS = {
    "from": {"carbon_dioxide": 6.0, "water": 6.0},
    "to": {"glucose": 1.0, "oxygen": 6.0},
    "rate": 0.01,
    "light": True,
}
RADIUS = (3 / 4000 / np.pi) ** (1 / 3)  # [m] of a body of one litre
HOLDS = {"glucose": 0.5, "oxygen": 0.9, "carbon_dioxide": 0.3, "water": 1.5}


@pytest.fixture
def cells(meadow):
    """A function of reactions that returns a world of two cells of one litre, with 1 of 2 units of energy."""

    def build(*reactions, world=None, dt=1.0, **deer):
        new = meadow(
            world={"substances": SUBSTANCES, "dt": dt} | (world or {}),
            **(
                {
                    "body": {"radius": RADIUS},
                    "substances": HOLDS,
                    "reactions": list(reactions),
                    "metabolism": {"energy": 1.0, "energy_max": 2.0},
                }
                | deer
            ),
        )
        arrange(new, "deer", energy=1.0)
        return new

    return build


def held(world):
    table = world.tables["deer"]
    rows = table.by_uid()
    return table[Chemistry].molarity[rows].astype(float) + table[Matter].residue[rows]


def energy(world):
    table = world.tables["deer"]
    return table[Metabolism].energy[table.by_uid()].tolist()


@pytest.mark.definition("3 chemical rules")
def test_respiration_burns_glucose_with_six_times_as_much_oxygen(cells):
    world = cells(RESPIRATION)
    act(world, React)
    assert held(world)[0] == pytest.approx([0.49, 0.84, 0.36, 1.56], abs=1e-7)
    assert energy(world) == pytest.approx([1.02, 1.02])  # 0.01 mol at 2 each
    assert world.tables["deer"][Metabolism].taken[:2] == pytest.approx([0.02, 0.02], abs=1e-6)
    made = world.matter.flows[0, :, NUMBER["reacted"]]
    assert made == pytest.approx([-0.02, -0.12, 0.12, 0.12], abs=1e-7)  # of both


def test_no_more_is_used_up_than_is_there(cells):
    world = cells(RESPIRATION | {"rate": 1.0, "energy": 0.0})  # 0.9 of oxygen last for 0.15
    act(world, React)
    assert held(world)[0] == pytest.approx([0.35, 0.0, 1.2, 2.4], abs=1e-7)
    assert held(world).min() >= 0


def test_who_is_full_burns_nothing_and_who_is_nearly_full_what_there_is_room_for(cells):
    world = cells(RESPIRATION)
    arrange(world, "deer", energy=[2.0, 1.99])
    act(world, React)
    assert held(world)[:, 0] == pytest.approx([0.5, 0.495], abs=1e-6)
    assert energy(world) == pytest.approx([2.0, 2.0])


def test_a_reaction_that_needs_energy_goes_as_far_as_it_lasts(cells):
    builds = {"from": {"glucose": 1.0}, "to": {"water": 1.0}, "energy": -10.0, "rate": 0.1}
    world = cells(builds)
    arrange(world, "deer", energy=[1.5, 0.25])
    act(world, React)
    assert held(world)[:, 0] == pytest.approx([0.4, 0.475], abs=1e-6)
    assert energy(world) == pytest.approx([0.5, 0.0], abs=1e-6)
    assert world.tables["deer"][Metabolism].burnt[:2] == pytest.approx([1.0, 0.25])


def test_plants_make_glucose_in_light_and_none_in_the_dark(cells):
    world = cells(PHOTOSYNTHESIS)
    world.environment["light"] = lambda w, x, y, z: np.where(x < 10, 0.5, 0.0)
    arrange(world, "deer", x=[5.0, 15.0])
    act(world, React)
    assert held(world)[0] == pytest.approx([0.505, 0.93, 0.27, 1.47], abs=1e-7)
    assert held(world)[1] == pytest.approx(list(HOLDS.values()), abs=1e-7)


def test_half_of_the_rate_is_reached_at_the_half_concentration_and_two_limits_multiply(cells):
    slow = RESPIRATION | {"energy": 0.0, "half": {"glucose": 0.5, "oxygen": 2.7}}
    world = cells(slow)
    act(world, React)
    assert held(world)[0, 0] == pytest.approx(0.5 - 0.01 / 2 / 4, abs=1e-7)


def test_reactions_take_place_in_their_order(cells):
    first = {"from": {"glucose": 1.0}, "to": {"water": 1.0}, "rate": 1.0}
    second = {"from": {"glucose": 1.0}, "to": {"oxygen": 1.0}, "rate": 1.0}
    world = cells(first, second)
    act(world, React)
    assert held(world)[0] == pytest.approx([0.0, 0.9, 0.3, 2.0], abs=1e-7)


@pytest.mark.definition("3 chemical rules")
def test_who_moves_burns_more_of_its_substances_than_who_rests(cells):
    world = cells(RESPIRATION | {"rate": 1.0, "energy": 10.0})
    arrange(world, "deer", energy=2.0, cost=[0.0, 0.5])
    act(world, Metabolise)
    act(world, React)
    assert held(world)[:, 0] == pytest.approx([0.499, 0.449], abs=1e-6)  # 0.01 by living, too
    assert energy(world) == pytest.approx([2.0, 2.0])


@pytest.mark.definition("3 chemical rules")
def test_a_reaction_with_an_action_takes_place_in_those_who_do_it(cells):
    way = {"from": {"glucose": 1.0}, "to": {"water": 1.0}, "rate": 0.1}
    world = cells(
        way | {"action": "run"},
        locomotion={"speed": {"walk": 1.0, "run": 2.0}},
        actions={"speed": ["walk", "run"], "turn": ["left", "none", "right"]},
        default_action={"speed": "walk"},
    )
    table = world.tables["deer"]
    runs = table.species.nerves.column("run")
    table[Nervous].decision[table.by_uid(), runs] = [1, 0]
    table[Nervous].decision[table.by_uid(), table.species.nerves.column("walk")] = [0, 1]
    act(world, React)
    assert held(world)[:, 0] == pytest.approx([0.4, 0.5])


def test_the_action_of_a_reaction_is_one_of_the_species(cells):
    way = {"from": {"glucose": 1.0}, "rate": 0.1, "action": "rum"}
    with pytest.raises(ConfigError, match=r'reactions\.0\.action = "rum"\n.*did you mean "run"'):
        cells(
            way,
            locomotion={"speed": {"walk": 1.0, "run": 2.0}},
            actions={"speed": ["walk", "run"]},
            default_action={"speed": "walk"},
        )


def test_small_extents_add_up_though_float32_cannot_hold_one(cells):
    world = cells({"from": {"water": 1.0}, "to": {"glucose": 1.0}, "rate": 1e-9})
    for _ in range(1000):
        act(world, React)
    assert held(world)[0, 3] == pytest.approx(1.5 - 1e-6, abs=1e-11)
    assert world.matter.flows[0, :, NUMBER["reacted"]] == pytest.approx([2e-6, 0, 0, -2e-6], abs=1e-12)


def test_worlds_without_reactions_have_no_such_system(meadow):
    world = meadow(world={"substances": SUBSTANCES}, substances={"glucose": 0.5})
    names = [type(system).__name__ for system in world.systems]
    assert not {"React", "Dilute", "TakeStock"} & set(names)
    assert Matter not in world.tables["deer"]


@pytest.mark.parametrize("seed", range(3))
def test_the_kernel_is_its_slow_twin(seed):
    rng = np.random.default_rng(seed)
    n, s = 30, 3
    alive, volume = rng.random(n) < 0.7, rng.uniform(0.1, 3, n)
    molarity, residue = rng.uniform(0, 0.1, (n, s)).astype(np.float32), np.zeros((n, s), np.float32)
    used, change, half = np.array([1.0, 2.0, 0]), np.array([-1.0, -2.0, 3.0]), np.array([0.05, 0.0, 0.1])
    light, gain, ceiling = rng.random(n).astype(np.float32), rng.choice([-3.0, 3.0]), 1.0
    energy = rng.uniform(-0.1, 1, n).astype(np.float32)
    taken, burnt, made = np.zeros(n, np.float32), np.zeros(n, np.float32), np.zeros(s)
    c = molarity.astype(float)
    reach = 0.04 * light.astype(float) * c[:, 0] / (0.05 + c[:, 0]) * c[:, 2] / (0.1 + c[:, 2])
    reach = np.minimum(reach, np.minimum(c[:, 0], c[:, 1] / 2))
    room = np.where(gain > 0, ceiling - energy.astype(float), energy).clip(0)
    reach = np.where(alive, np.minimum(reach, room / (abs(gain) * volume)), 0)
    wanted, before = c + reach[:, None] * change, energy.copy()
    react(
        alive,
        Bodies(volume, molarity, residue),
        used,
        change,
        half,
        0.04,
        light,
        gain,
        ceiling,
        Stores(energy, taken, burnt),
        made,
    )
    assert molarity.astype(float) + residue == pytest.approx(wanted, abs=1e-9)
    assert made == pytest.approx((volume[:, None] * (wanted - c)).sum(0), abs=1e-8)
    assert energy == pytest.approx(before + gain * reach * volume, abs=1e-6)
    assert taken - burnt == pytest.approx(energy - before, abs=1e-7)


def test_no_reaction_runs_in_dying_animals(cells):
    world = cells(RESPIRATION)
    world.tables["deer"].cause[0] = world.cause("eaten")
    act(world, React)
    assert held(world)[0] == pytest.approx(list(HOLDS.values()), abs=1e-7)
    assert energy(world) == pytest.approx([1.0, 1.02])
