import numpy as np
import pytest
import torch

from ecs_eco.compiled.workers import Workers
from ecs_eco.learning import Brain
from ecs_eco.learning.torch_ppo import CHUNK

TRUNKS = ("shared", "separate")


def _observations(n, width=5, seed=0):
    return np.random.default_rng(seed).standard_normal((n, width), dtype=np.float32)


def _twin(brain, observations):
    """The network in float64 numpy, from the weights' names alone."""
    w = {name: array.astype(float) for name, array in brain.state().items()}

    def tower(name):
        h = observations.astype(float)
        for level in range(len(brain.hidden)):
            h = np.tanh(h @ w[f"{name}.{level}.weight"].T + w[f"{name}.{level}.bias"])
        return h

    shared = brain.trunk == "shared"
    logits = tower("trunk" if shared else "policy") @ w["policy.head.weight"].T + w["policy.head.bias"]
    return logits, (tower("trunk" if shared else "value") @ w["value.head.weight"].T + w["value.head.bias"])[
        :, 0
    ]


def _shaken(brain, seed=9):
    """Give a brain weights with no zero among them."""
    rng = np.random.default_rng(seed)
    brain.load(
        {name: rng.normal(0, 0.4, array.shape).astype(np.float32) for name, array in brain.state().items()}
    )
    return brain


@pytest.mark.parametrize("trunk", TRUNKS)
@pytest.mark.parametrize("n", [0, 1, 7, CHUNK, CHUNK + 3])
def test_forward_agrees_with_its_numpy_twin(trunk, n):
    brain = _shaken(Brain(5, (3, 2), hidden=(16, 8), trunk=trunk))
    logits, values = brain.forward(_observations(n))
    right_logits, right_values = _twin(brain, _observations(n))
    np.testing.assert_allclose(logits, right_logits, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(values, right_values, rtol=1e-4, atol=1e-5)
    assert logits.dtype == values.dtype == np.float32


def test_forward_gives_the_same_bits_for_any_number_of_workers_and_torch_threads():
    brain, observations = _shaken(Brain(5, (3, 2))), _observations(3 * CHUNK + 100)
    one = brain.forward(observations)
    for workers in (2, 3, 7):
        assert all(map(np.array_equal, one, brain.forward(observations, Workers(workers).split)))
    threads = torch.get_num_threads()
    try:
        torch.set_num_threads(2)
        assert all(map(np.array_equal, one, brain.forward(observations)))
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(threads)


def test_a_rows_bits_depend_neither_on_its_place_nor_on_the_other_rows():
    brain, observations = _shaken(Brain(24, (3, 3))), _observations(CHUNK + 300, width=24)
    logits, values = brain.forward(observations)
    order = np.random.default_rng(1).permutation(len(observations))
    assert all(map(np.array_equal, brain.forward(observations[order]), (logits[order], values[order])))
    for n in (*range(1, 40), 1000, CHUNK - 1, CHUNK, CHUNK + 1, CHUNK + 13):
        assert all(map(np.array_equal, brain.forward(observations[:n]), (logits[:n], values[:n]))), n


def test_weights_depend_on_the_seed_and_on_no_global_generator():
    torch.manual_seed(1)
    first = Brain(5, (3,), seed=4).state()
    torch.manual_seed(2)
    before = torch.random.get_rng_state()
    again, other = Brain(5, (3,), seed=4).state(), Brain(5, (3,), seed=5).state()
    assert torch.equal(before, torch.random.get_rng_state())
    assert all(np.array_equal(first[name], again[name]) for name in first)
    assert not np.array_equal(first["trunk.0.weight"], other["trunk.0.weight"])


def test_weights_are_orthogonal_with_their_gains():
    w = Brain(24, (3, 3), hidden=(64, 64)).state()
    np.testing.assert_allclose(w["trunk.0.weight"].T @ w["trunk.0.weight"], 2 * np.eye(24), atol=1e-5)
    np.testing.assert_allclose(w["trunk.1.weight"] @ w["trunk.1.weight"].T, 2 * np.eye(64), atol=1e-5)
    np.testing.assert_allclose(
        w["policy.head.weight"] @ w["policy.head.weight"].T, 1e-4 * np.eye(6), atol=1e-8
    )
    np.testing.assert_allclose(np.linalg.norm(w["value.head.weight"]), 1, rtol=1e-5)
    assert not w["trunk.0.bias"].any()


@pytest.mark.parametrize("trunk", TRUNKS)
def test_saved_weights_give_the_same_outputs_in_another_brain(trunk):
    first = _shaken(Brain(5, (3, 2), trunk=trunk))
    second = Brain(5, (3, 2), seed=99, trunk=trunk)
    second.load(first.state())
    assert all(map(np.array_equal, first.forward(_observations(10)), second.forward(_observations(10))))


def test_state_is_a_copy():
    brain = Brain(5, (3,))
    brain.state()["trunk.0.weight"][:] = 7
    assert not (brain.state()["trunk.0.weight"] == 7).any()


def test_weights_of_another_shape_are_refused_by_name_and_nothing_changes():
    brain, before = Brain(5, (3,)), Brain(5, (3,)).state()
    wrong = Brain(6, (3,), seed=1).state()
    with pytest.raises(ValueError, match=r"trunk\.0\.weight has shape \(64, 6\); this brain needs \(64, 5\)"):
        brain.load(wrong)
    with pytest.raises(ValueError, match=r"value\.head\.bias: missing or unknown"):
        brain.load({name: array for name, array in before.items() if name != "value.head.bias"})
    assert all(np.array_equal(before[name], array) for name, array in brain.state().items())


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"n_observations": 0, "groups": (2,)}, "n_observations = 0"),
        ({"n_observations": 1, "groups": ()}, r"groups = \(\)"),
        ({"n_observations": 1, "groups": (2, 0)}, r"groups = \(2, 0\)"),
        ({"n_observations": 1, "groups": (2,), "hidden": ()}, r"hidden = \(\)"),
        ({"n_observations": 1, "groups": (2,), "trunk": "split"}, "'shared' or 'separate'"),
    ],
)
def test_impossible_networks_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        Brain(**given)


def test_observations_of_another_width_are_refused():
    with pytest.raises(ValueError, match=r"\(4, 6\); expected \(n, 5\)"):
        Brain(5, (3,)).forward(_observations(4, width=6))
