"""Continuous actions, from the world file to the body."""

import numpy as np
import pytest
from matplotlib.text import Text

from ecs_eco import World
from ecs_eco.analysis.nervous_figure import draw_nervous_system
from ecs_eco.components import Motor, Nervous, Position, Velocity
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.nervous.ranges import Ranges
from ecs_eco.record import run_to_folder
from ecs_eco.record.parquet import read_parts
from ecs_eco.view import inspect

ROAM = {
    "count": 40,
    "body": {"radius": 0.3},
    "metabolism": {"energy": 5.0, "energy_max": 10.0, "basal": 0.01},
    "locomotion": {"speed": {"still": 0.0, "run": 3.0, "walk": 1.0}, "cost": {"walk": 0.02, "run": 0.1}},
    "sensors": [{"kind": "own", "property": "energy"}],
    "actions": {"speed": {"continuous": [0.0, 3.0]}, "turn": {"continuous": [-0.8, 0.8]}},
    "happiness": {"weights": {"energy": 1.0}, "minimum": 0.0},
}
LEARNS = {"policy": {"kind": "shared", "learn": True, "hidden": [8]}, "ppo": {"horizon": 8}}
ALONE = {"policy": {"kind": "individual", "learn": True, "hidden": [8]}, "ppo": {"horizon": 8}}


def _world(options=None, space=(60.0, 60.0), **changes):
    deer = {key: value for key, value in (ROAM | changes).items() if value is not None}
    return World.from_config(
        {"format": 1, "name": "roam", "space": {"size": list(space)}, "species": {"deer": deer}},
        seed=3,
        **(options or {}),
    )


def _commands(world):
    table = world.table("deer")
    return table[Motor].command[table.by_uid()]


def test_what_is_drawn_is_scaled_shifted_and_held_within_the_range():
    ranges = Ranges({"speed": ((0.0, 3.0), 0, None), "turn": ((-0.8, 0.8), 1, 0.5)})
    numbers = np.array([[-1, 1], [0, 0], [9, -9]], np.float32)
    assert ranges.command(numbers, None).tolist() == pytest.approx(
        np.array([[0, 0.8], [1.5, 0], [3, -0.8]], np.float32)
    )
    shift = np.array([[-1, 0.1], [0.5, -0.3], [-0.5, 0.3]], np.float32)
    assert ranges.command(numbers, shift).tolist() == pytest.approx(
        np.array([[0, 0.8], [2, -0.3], [2.5, -0.5]], np.float32)
    )
    assert ranges.command(None, None).tolist() == [[0, 0.5]]


def test_without_a_policy_the_neutral_number_is_carried_out_and_the_reflex_shifts_it():
    world = _world(default_action={"speed": 1.25}, reflex={"formulas": {"turn": "0 * energy + 0.5"}}).run(1)
    table = world.table("deer")
    assert _commands(world).tolist() == pytest.approx(np.tile(np.array([1.25, 0.5], np.float32), (40, 1)))
    v, rows = table[Velocity], table.rows()
    assert v.speed[rows].tolist() == [1.25] * 40
    assert v.cost[rows].tolist() == pytest.approx([0.02 + 0.25 / 2 * 0.08] * 40)
    assert (table[Nervous].decision[rows] == 1).all()


def test_a_connection_pushes_to_the_limit_of_the_range():
    reflex = {"connections": [{"sensor": "energy", "above": 0.0, "action": "turn", "weight": -1}]}
    world = _world(default_action={"turn": 0.6}, reflex=reflex).run(1)
    assert _commands(world)[:, 1].tolist() == pytest.approx([-0.8] * 40)


def test_an_animal_turns_by_its_number():
    world = _world(default_action={"turn": -0.4})
    table = world.table("deer")
    before = table[Position].heading.copy()
    world.run(1)
    turned = (table[Position].heading - before)[table.rows()]
    assert np.mod(turned, 2 * np.pi).tolist() == pytest.approx([2 * np.pi - 0.4] * 40, abs=1e-5)


@pytest.mark.parametrize(
    ("group", "number", "rise", "ahead"),
    [("climb", 0.3, 0.3, 2.0), ("pitch", -0.5, -2 * np.sin(0.5), 2 * np.cos(0.5))],
)
def test_in_a_volume_it_climbs_or_swims_along_a_slope(group, number, rise, ahead):
    actions = {"speed": {"continuous": [0.0, 3.0]}, group: {"continuous": [-0.5, 0.5]}}
    world = _world(space=(60.0, 60.0, 90.0), actions=actions, default_action={"speed": 2.0, group: number})
    table = world.table("deer")
    table[Position].x[:], table[Position].z[:], table[Position].heading[:] = 10, 45, 0
    world.run(1)
    p, rows = table[Position], table.rows()
    assert (p.z[rows] - 45).tolist() == pytest.approx([rise] * 40, abs=1e-5)
    assert (p.x[rows] - 10).tolist() == pytest.approx([ahead] * 40, abs=1e-5)


def test_random_policies_draw_from_the_whole_range_with_equal_chance():
    world = _world({"policies": "random"}, count=4000, **LEARNS).run(1)
    for numbers, (low, high) in zip(_commands(world).T, [(0, 3), (-0.8, 0.8)], strict=True):
        counts, _ = np.histogram(numbers, 10, (low, high))
        assert counts.sum() == 4000
        assert counts.min() > 300


@pytest.mark.slow
@pytest.mark.parametrize("kind", [LEARNS, ALONE])
def test_learning_goes_on_from_a_checkpoint_with_the_same_bytes(kind, tmp_path):
    straight = _world(**kind).run(40)
    half = _world(**kind).run(21)
    half.save(tmp_path / "half")
    resumed = World.restore(tmp_path / "half").run(19)
    assert straight.digest() == resumed.digest()


def test_learning_is_the_same_on_two_threads():
    assert _world(**LEARNS).run(40).digest() == _world({"threads": 2}, **LEARNS).run(40).digest()


@pytest.mark.slow
@pytest.mark.parametrize("kind", [LEARNS, ALONE])
def test_numbers_that_pay_are_learnt(kind):
    """Happiness is the energy left, and only speed costs: standing still is best."""
    learns = kind | {"ppo": {"horizon": 16, "learning_rate": 0.01, "epochs": 6, "discount": 0.5}}
    cost = {"speed": {"still": 0.0, "run": 3.0}, "cost": {"run": 0.2}}
    world = _world(
        locomotion=cost,
        count=8 if kind is ALONE else 60,
        **learns,
        metabolism={"energy": 500.0, "energy_max": 1000.0},
    ).run(30)
    before = _commands(world)[:, 0].mean()
    world.run(200 if kind is ALONE else 450)
    assert _commands(world)[:, 0].mean() < before / 2


def test_numbers_are_read_by_name():
    world = _world(default_action={"turn": 0.25}).run(1)
    table = world.table("deer")
    nerves = table.species.nerves
    assert nerves.amount(table, "turn")[table.rows()].tolist() == [0.25] * 40
    with pytest.raises(KeyError, match=r"unknown continuous action 'trun'.*turn"):
        nerves.amount(table, "trun")


WRONG = {
    "actions.turn.continuous.*the smaller one first": {"actions": {"turn": {"continuous": [1.0, 1.0]}}},
    "actions.turn.continuous.*at least 2 entries": {"actions": {"turn": {"continuous": [1.0]}}},
    "actions.turn.continuous.1.*finite number": {"actions": {"turn": {"continuous": [1.0, "two"]}}},
    "actions.turn.*continious.*unknown key.*continuous": {"actions": {"turn": {"continious": [0.0, 1.0]}}},
    "actions.turn.*list": {"actions": {"turn": 3}},
    "actions.turn.1.*text": {"actions": {"turn": ["left", 3]}},
    "actions.speed.continuous.*fastest gait, 0 to 3": {"actions": {"speed": {"continuous": [0.0, 4.0]}}},
    "actions.speed.*locomotion": {"locomotion": None},
    "actions.pitch.*plane": {"actions": {"pitch": {"continuous": [0.0, 1.0]}}},
    "actions.pitch.*group climb": {"actions": {"pitch": ["up"]}},
    "actions.eat.*cannot be continuous.*speed": {"actions": {"eat": {"continuous": [0.0, 1.0]}}},
    "default_action.turn.*-0.8 to 0.8": {"default_action": {"turn": 0.9}},
    "default_action.turn.*not a possible value": {"default_action": {"turn": "left"}},
    "always_on.0.*always executed": {"always_on": ["turn"]},
}


@pytest.mark.parametrize("message", WRONG)
def test_what_cannot_be_is_refused_by_name(message):
    with pytest.raises(ConfigError, match=f"(?s){message}"):
        _world(**WRONG[message])


def test_a_world_keeps_its_ranges_when_it_is_written_and_read():
    config = _world(default_action={"turn": 0.25}).config
    again = load(config.model_dump(exclude_none=True))
    assert again.species["deer"].ranges() == {"speed": (0.0, 3.0), "turn": (-0.8, 0.8)}
    assert again.species["deer"].default_action == {"turn": 0.25}


def test_recordings_the_inspector_and_drawings_show_what_was_drawn_added_and_done(tmp_path):
    world = _world(reflex={"formulas": {"turn": "0 * energy + 0.3"}}, **LEARNS)
    run_to_folder(world.config, ticks=1, out=tmp_path / "run", seed=3, record="full", report=False)
    details = read_parts(tmp_path / "run" / "details-deer")
    kept = {name: details[name].to_numpy() for name in details.column_names}
    world.run(1)
    table = world.table("deer")
    rows = table.by_uid()
    nerves, drawn = table.species.nerves, kept["chosen: turn.turn"]
    assert kept["reflex: turn.turn"].tolist() == pytest.approx([0.3] * 40)
    assert kept["decision: turn.turn"].tolist() == pytest.approx(np.clip(drawn + np.float32(0.3), -0.8, 0.8))
    assert kept["decision: turn.turn"].tolist() == nerves.amount(table, "turn")[rows].tolist()
    shown = inspect.nerves(table, rows[5])
    speed, turn = shown["actions"]
    assert (turn["continuous"], turn["reflex"]) == (True, 0.3)
    assert turn["chosen"] == pytest.approx(drawn[5], abs=1e-6)
    assert speed["decision"] == pytest.approx(kept["decision: speed.speed"][5])
    figure = draw_nervous_system(world.config, "deer", inspect.drawable(shown))
    texts = [text.get_text() for text in figure.findobj(Text)]
    assert "[−0.8, 0.8]" in texts
    assert f"turn = {turn['decision']:.3g}".replace("-", "−") in texts


def test_a_reflex_that_is_taken_away_shifts_nothing_any_more():
    world = _world(default_action={"turn": 0.25}, reflex={"formulas": {"turn": "0 * energy + 0.3"}}).run(1)
    assert _commands(world)[:, 1].tolist() == pytest.approx([0.55] * 40)
    world.table("deer").species.nerves.reflex = None
    world.run(1)
    assert _commands(world)[:, 1].tolist() == [0.25] * 40
