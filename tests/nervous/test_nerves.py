import numpy as np
import pytest

F = np.float32


def custom_sense(world, table, seekers, out, column):
    """Two channels: the uid, and a constant."""
    out[:, column] = table.uid[seekers.rows]
    out[:, column + 1] = 0.5


def custom_reflex(x):
    """Turn left, always."""
    y = np.zeros((len(x), 7))
    y[:, 3] = 2
    return y


def custom_happiness(x):
    """Minus the first channel."""
    return -x[:, 0]


def _nerves(meadow, **deer):
    return meadow(**deer).tables["deer"].species.nerves


def _x(*rows):
    return np.array(rows, F)


SENSORS = [{"kind": "own", "property": "energy"}, {"kind": "own", "property": "age", "scale": 10.0}]


def test_connections_fire_beyond_their_thresholds_and_add_up_to_a_sign(meadow):
    links = [
        ("energy", "run", 1, "above", 0.5),
        ("age", "run", -1, "above", 2.0),
        ("energy", "eat", -1, "below", 0.5),
    ]
    reflex = {"connections": [{"sensor": s, "action": a, "weight": w, way: at} for s, a, w, way, at in links]}
    nerves = _nerves(meadow, sensors=SENSORS, reflex=reflex)
    y = nerves.reflex(_x([0.5, 0], [0.6, 0], [0.6, 3], [0.4, 3]))
    assert y.dtype == np.int8
    run, eat = nerves.column("run"), nerves.column("eat")
    assert y[:, run].tolist() == [0, 1, 0, -1]
    assert y[:, eat].tolist() == [0, 0, 0, -1]
    assert not np.delete(y, [run, eat], axis=1).any()


def test_a_formula_and_a_function_give_the_sign_of_their_value(meadow):
    nerves = _nerves(
        meadow, sensors=SENSORS, reflex={"formulas": {"walk": "age - 2 * energy"}, "function": custom_reflex}
    )
    y = nerves.reflex(_x([1, 2], [1, 3], [1, 0]))
    assert y[:, nerves.column("walk")].tolist() == [0, 1, -1]
    assert y[:, nerves.column("left")].tolist() == [1, 1, 1]


@pytest.mark.parametrize(
    ("happiness", "values"),
    [
        ({"weights": {"energy": 2.0, "age": -0.5}}, [0.5, -1.0, 3.0]),
        ({"weights": {"energy": 1e-7}}, [5e-8, 0.0, 1.5e-7]),
        ({"formula": "energy - age"}, [-0.5, -1.0, 1.5]),
        ({"formula": "0.25"}, [0.25] * 3),
        ({"function": custom_happiness}, [-0.5, 0.0, -1.0]),
    ],
)
def test_happiness_is_never_below_its_minimum(meadow, happiness, values):
    nerves = _nerves(
        meadow, sensors=SENSORS, happiness=happiness | {"formula": happiness.get("formula"), "minimum": -1.0}
    )
    felt = nerves.happiness(_x([0.5, 1], [0, 3], [1.5, 0]))
    assert felt.dtype == F
    assert felt == pytest.approx(np.maximum(values, -1.0), rel=1e-6)
    assert nerves.minimum == -1


def test_the_plain_name_of_a_smell_is_the_mean_over_the_noses(meadow):
    noses = [{"kind": "smell", "field": "musk", "at": [1.0, side]} for side in (0.5, -0.5)]
    world = meadow(
        world={"fields": {"musk": {"cell": 1.0}}}, sensors=[*SENSORS, *noses], happiness={"formula": "musk"}
    )
    nerves = world.tables["deer"].species.nerves
    assert nerves.channels == ("energy", "age", "musk_1", "musk_2")
    assert nerves.reading("musk", _x([0, 0, 1, 2])).tolist() == [1.5]
    assert nerves.reading("musk_2", _x([0, 0, 1, 2])).tolist() == [2]
    assert nerves.happiness(_x([0, 0, 1, 2])).tolist() == [1.5]


def test_a_sense_of_ones_own_fills_its_channels(meadow):
    sense = {"kind": "custom", "name": "mine", "function": custom_sense, "width": 2}
    world = meadow(sensors=[*SENSORS, sense])
    world.run(1)
    nerves = world.tables["deer"].species.nerves
    assert nerves.channels[2:] == ("mine_1", "mine_2")
    assert nerves.x[:, 2:].tolist() == [[u, 0.5] for u in world.tables["deer"].uid[nerves.rows]]


def test_a_species_may_have_no_network_at_all(meadow):
    nerves = _nerves(meadow, happiness=None)
    assert (nerves.reflex, nerves.happiness, nerves.policy, nerves.brain) == (None, None, False, None)
    assert nerves.state() == {}


def test_the_state_of_a_learner_brings_another_to_the_same_point(meadow):
    def learner(seed):
        return meadow(
            policy={"kind": "shared", "hidden": [4]},
            ppo={"horizon": 3},
            options={"policies": "untrained", "learn": True, "seed": seed},
        )

    world, other = learner(1).run(5), learner(2)
    nerves, twin = (w.tables["deer"].species.nerves for w in (world, other))
    state = nerves.state()
    assert any(k.startswith("brain.") for k in state)
    assert any(k.startswith("learner.moment_1") for k in state)
    assert not np.array_equal(twin.state()["brain.policy.head.weight"], state["brain.policy.head.weight"])
    twin.load(state)
    assert all(np.array_equal(a, twin.state()[k]) for k, a in state.items())
