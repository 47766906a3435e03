"""A sealed checkpoint with numbers that no world could live with is refused, with the file and the part,
and changes nothing."""

import copy

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Body, Metabolism, Position
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.record import freeze as frozen
from ecs_eco.record.checkpoint import write
from ecs_eco.space import Field

F = np.float32


@pytest.fixture
def world():
    world = World((50.0, 40.0), edges="walls")
    world.add_table("moss", Position, Body, Metabolism)
    world.add_table("deer", Position, Body, Biology)
    world.fields["musk"] = Field(world.space, 10.0)
    world.spawn("moss", Position(x=3.0, y=4.0), n=3)
    world.spawn("deer", Position(x=9.0, y=9.0), n=2)
    world.run(4)
    world.spawn("moss", Position(x=5.0, y=6.0), n=2)
    return world


def _changed(world, path, change):
    meta, arrays = frozen.freeze(world)
    meta, arrays = copy.deepcopy(meta), {k: v.copy() for k, v in arrays.items()}
    change(meta, arrays)
    write(path, meta, arrays)
    return path


def _put(name, value, at=...):
    def change(meta, arrays):
        arrays[name][at] = value

    return change


def _replace(name, array):
    return lambda meta, arrays: arrays.__setitem__(name, array)


def _clock(key, value):
    return lambda meta, arrays: meta["clock"].__setitem__(key, value)


CASES = {
    "equal rows": (_put("table/moss/row", 1), "'table/moss/row' is not an increasing list"),
    "descending rows": (_put("table/moss/row", [2, 1, 0]), "'table/moss/row' is not an increasing list"),
    "a row below 0": (_put("table/moss/row", [-1, 1, 2]), "'table/moss/row' is not an increasing list"),
    "a row beyond the capacity": (
        _put("table/moss/row", 2**40, 2),
        "capacity of 64, but its last row is 1099511627776",
    ),
    "a capacity of nothing": (
        lambda meta, arrays: meta["tables"]["moss"].__setitem__("capacity", 2),
        "capacity of 2",
    ),
    "a capacity that is no number": (
        lambda meta, arrays: meta["tables"]["moss"].__setitem__("capacity", "x"),
        "capacity of 'x'",
    ),
    "equal uids": (_put("table/moss/uid", 2), "uid 2 occurs twice"),
    "a uid of two tables": (_put("table/deer/uid", 3, 0), "uid 3 occurs twice"),
    "no uid": (_put("table/moss/uid", 0, 0), "'table/moss/uid' contains 0; expected: 1 to 5"),
    "a uid to come": (
        _clock("next_uid", 3),
        "'table/moss/uid' contains 3; expected: 1 to 2|'table/deer/uid' contains 5",
    ),
    "a uid that the next ones would not fit behind": (
        _clock("next_uid", 2**63),
        r"clock\.next_uid is 9223372036854775808",
    ),
    "a birth to come": (_put("table/moss/born", 5, 0), "'table/moss/born' contains 5"),
    "an unknown cause": (_put("table/moss/cause", 9, 0), "'table/moss/cause' contains 9; expected: 0 to 1"),
    "a tick before the start": (_clock("tick", -1), r"clock\.tick is -1"),
    "a tick that is none": (_clock("tick", 1.5), r"clock\.tick is 1\.5"),
    "a clock without ticks": (
        lambda meta, arrays: meta["clock"].pop("next_uid"),
        "malformed: KeyError: 'next_uid'",
    ),
    "no number": (
        _put("table/moss/Metabolism.energy", np.nan, 1),
        r"moss, uid 2: Metabolism\.energy is nan; expected: finite numbers",
    ),
    "a place outside": (
        _put("table/deer/Position.y", -500.0, 1),
        r"deer, uid 5: Position\.y is -500\.0; expected: 0 to 40 m",
    ),
    "a size below 0": (
        _put("table/deer/Body.radius", -1.0),
        r"deer, uid 4: Body\.radius is -1\.0 \(1 more\); expected: 0 to 1e\+30",
    ),
    "a sex that there is not": (
        _put("table/deer/Biology.sex", 7, 0),
        r"deer, uid 4: Biology\.sex is 7; expected: 0 to 2",
    ),
    "another type": (
        _replace("table/moss/Position.x", np.zeros(3)),
        r"'table/moss/Position\.x' is float64\[3\]; expected for this world: float32\[3\]",
    ),
    "another shape": (_replace("table/moss/Position.x", np.zeros((3, 1), F)), r"this world: float32\[3\]"),
    "one too few": (_replace("table/moss/Position.x", np.zeros(2, F)), r"this world: float32\[3\]"),
    "rows in two dimensions": (
        _replace("table/moss/row", np.zeros((3, 1), np.int64)),
        r"this world: int64\[3\]",
    ),
    "a part less": (lambda meta, arrays: arrays.pop("table/deer/killer"), "'table/deer/killer' is missing"),
    "newborn outside": (
        _put("table/moss/births/0/Position.x", np.inf, 0),
        r"newborn 0 of 'moss': Position\.x is inf",
    ),
    "newborn of another number": (
        _replace("table/moss/births/0/Position.x", np.zeros(3, F)),
        r"births/0/Position\.x' is float32\[3\]; expected for this world: .*\[2\]",
    ),
    "newborn with what their kind lacks": (
        lambda meta, arrays: meta["tables"]["moss"]["births"][0]["values"].append("Biology.sex"),
        r"newborns of 'moss' have 'Biology\.sex'",
    ),
    "a field of another shape": (
        _replace("field/musk", np.zeros((1, 2, 2), F)),
        r"'field/musk' is float32\[1, 2, 2\]",
    ),
    "a field that is no number": (_put("field/musk", np.inf, (0, 1, 1)), "'field/musk' contains inf"),
    "no number in the air": (
        lambda meta, arrays: meta["ambient"].__setitem__("light", "x"),
        r"ambient\.light is 'x'",
    ),
    "a cause twice": (lambda meta, arrays: meta["causes"].append("culled"), "causes are"),
}


@pytest.mark.parametrize("case", CASES)
def test_odd_numbers_are_refused_and_nothing_changes(case, world, tmp_path):
    change, message = CASES[case]
    path = _changed(world, tmp_path / "odd.safetensors", change)
    before = world.digest()
    with pytest.raises(CheckpointError, match=r"odd\.safetensors: (the part )?.*" + f"({message})"):
        world.load(path)
    assert (world.digest(), world.tick) == (before, 4)


def test_what_was_saved_is_taken(world, tmp_path):
    world.load(_changed(world, tmp_path / "same.safetensors", lambda meta, arrays: None))
    assert world.run(2).tables["moss"].n == 5


def test_a_part_that_cannot_take_its_state_is_named(tmp_path):
    world = World.from_config("predator-prey", policies="untrained", learn=True).run(2)
    part = next(k for k in frozen.freeze(world)[1] if k.endswith("rollout.last"))
    path = _changed(world, tmp_path / "odd.safetensors", _put(part, 10**6))
    with pytest.raises(
        CheckpointError,
        match=r"odd\.safetensors: table/.*nerves cannot load its state: "
        r"last of the rollout",
    ):
        world.load(path)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (np.array(-1), "contains -1; expected: 0 to"),
        (np.array(2**63 - 1), "contains 9223372036854775807; expected: 0 to"),
        (np.array(np.nan), r"is float64\[\]; expected: one integer"),
        (np.zeros(2, int), r"is int64\[2\]; expected: one integer"),
    ],
)
def test_the_steps_of_a_learner_are_a_number_that_can_be_counted_on(value, message, tmp_path):
    world = World.from_config("predator-prey", policies="untrained", learn=True).run(2)
    part = next(k for k in frozen.freeze(world)[1] if k.endswith("learner.steps"))
    path = _changed(world, tmp_path / "odd.safetensors", _replace(part, value))
    with pytest.raises(
        CheckpointError, match=rf"odd\.safetensors: the part 'table/.*learner\.steps' {message}"
    ):
        world.load(path)
