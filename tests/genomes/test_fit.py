"""Hand-written reflexes and happiness as networks that mutation can act on."""

import numpy as np
import pytest

from ecs_eco.genomes import Gene, Layout, fit_network
from ecs_eco.genomes.fit import Fitted

LOW, HIGH = [0.0, 0.0, 0.0], [1.0, 50.0, 1.0]  # energy, depth [m], oxygen


def dive(x: np.ndarray) -> np.ndarray:
    """Rise and do not dive when short of oxygen; do not eat below 40 m."""
    y = np.zeros((len(x), 3), np.float32)
    y[x[:, 2] < 0.3, 0] = 1
    y[x[:, 2] < 0.3, 1] = -1
    y[x[:, 1] > 40, 2] = -1
    return y


def happiness(x: np.ndarray) -> np.ndarray:
    return x[:, 0] - 0.02 * x[:, 1] * (1 - x[:, 2])


@pytest.fixture(scope="module", params=[0, 1, 2])
def diver(request):
    return fit_network(dive, 3, LOW, HIGH, seed=request.param)


@pytest.mark.definition("3 hand-coded")
def test_a_diving_reflex_is_fitted_to_one_error_in_two_hundred(diver) -> None:
    assert diver.error < 0.005
    x = np.random.default_rng(9).uniform(LOW, HIGH, (5000, 3)).astype(np.float32)
    assert (diver(x) != dive(x)).mean() < 0.005
    assert diver(x).dtype == np.int8
    assert (diver(np.zeros_like(x) + 0.5)[:, 2] != diver(np.array([[0.5, 45, 0.5]], np.float32))[:, 2]).all()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.definition("3 hand-coded")
def test_a_happiness_is_fitted_to_three_hundredths(seed: int) -> None:
    fitted = fit_network(happiness, 3, LOW, HIGH, kind="happiness", seed=seed)
    assert fitted.error < 0.03
    x = np.random.default_rng(9).uniform(LOW, HIGH, (2000, 3)).astype(np.float32)
    assert np.sqrt(np.mean((fitted(x) - happiness(x)) ** 2)) < 0.03
    assert fitted(x).shape == (2000,)


def test_mutated_weights_behave_in_other_ways_and_the_original_stays(diver) -> None:
    x = np.random.default_rng(9).uniform(LOW, HIGH, (1000, 3)).astype(np.float32)
    before = diver(x)
    other = diver.with_weights(diver.weights + np.random.default_rng(1).normal(0, 2, diver.weights.size))
    assert (other(x) != before).mean() > 0.05
    assert np.array_equal(diver(x), before)
    assert np.array_equal(diver.with_weights(diver.weights)(x), before)


def test_each_row_may_have_a_network_of_its_own(diver) -> None:
    x = np.random.default_rng(9).uniform(LOW, HIGH, (2, 3)).astype(np.float32)
    weights = np.stack([diver.weights, np.zeros_like(diver.weights)])
    assert np.array_equal(diver.each(x, weights)[0], diver(x)[0])
    assert np.array_equal(diver.each(x, weights)[1], [-1, -1, -1])  # all alike: the first class


def test_an_answer_does_not_depend_on_the_other_rows(diver) -> None:
    fitted = fit_network(happiness, 3, LOW, HIGH, kind="happiness", steps=20)
    x = np.random.default_rng(9).uniform(LOW, HIGH, (100, 3)).astype(np.float32)
    assert np.array_equal(fitted(x)[::-1], fitted(x[::-1].copy()))
    assert fitted(x[5:6])[0] == fitted(x)[5]


def test_the_weights_go_through_a_genome(diver) -> None:
    most = float(np.abs(diver.weights).max()) * 1.01
    layout = Layout(
        [Gene(name="reflex", letters=6, low=-most, high=most, form="direct")], shapes={"reflex": diver.shapes}
    )
    again = diver.with_weights(layout.decode(layout.encode({"reflex": diver.weights}))["reflex"][0])
    assert again.weights == pytest.approx(diver.weights, abs=layout["reflex"].resolution)
    x = np.random.default_rng(9).uniform(LOW, HIGH, (5000, 3)).astype(np.float32)
    assert (again(x) != dive(x)).mean() < 0.02


def test_the_same_seed_gives_the_same_network() -> None:
    a, b, c = (fit_network(dive, 3, LOW, HIGH, seed=s, steps=30).weights for s in (4, 4, 5))
    assert np.array_equal(a, b)
    assert not np.array_equal(a, c)


@pytest.mark.slow
def test_hidden_layers_may_be_none_or_many() -> None:
    linear = fit_network(lambda x: 3 * x[:, 0] - x[:, 1] + 2, 2, -1, 1, hidden=(), kind="happiness")
    assert linear.error < 1e-3
    assert linear.weights == pytest.approx([3, -1, 2], abs=0.01)
    assert fit_network(dive, 3, LOW, HIGH, hidden=(5, 4), steps=5).shapes == [
        (3, 5),
        (5,),
        (5, 4),
        (4,),
        (4, 9),
        (9,),
    ]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"function": lambda x: x[:, 0]}, r"expected \(n, actions\)"),
        ({"function": lambda x: x[:, 0] / 0 * np.nan, "kind": "happiness"}, "not finite"),
        ({"low": 2.0, "high": 1.0}, "each low must be less than its high"),
        ({"kind": "policy"}, "expected reflex or happiness"),
    ],
)
@pytest.mark.filterwarnings("ignore:.*:RuntimeWarning")
def test_what_cannot_be_fitted_is_refused(change: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        fit_network(**{"function": dive, "n_inputs": 3, "low": LOW, "high": HIGH, "steps": 1} | change)


def test_wrong_numbers_of_readings_and_weights_are_refused(diver) -> None:
    with pytest.raises(ValueError, match=r"expected \(n, 3\)"):
        diver(np.zeros((4, 2), np.float32))
    with pytest.raises(ValueError, match=r"expected \(217,\)"):
        diver.with_weights(np.zeros(3))


def test_a_network_answers_no_readings_with_no_answers():
    for kind, shape in (("reflex", (0, 2)), ("happiness", (0,))):
        network = Fitted(kind, (3, 6), np.zeros(24, np.float32), 0.0)
        assert network(np.zeros((0, 3), np.float32)).shape == shape
