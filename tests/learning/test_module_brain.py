"""Any torch module as a brain: what it gives, and what is said of one that cannot be."""

import re

import numpy as np
import pytest
import torch
from torch import nn

from ecs_eco.compiled.workers import Workers
from ecs_eco.learning import MLP, Brain, ModuleBrain, from_torch
from ecs_eco.learning.brains import brain_of
from ecs_eco.learning.module_brain import as_brain, as_module
from tests.learning.networks import Gru, Plain

GROUPS = (3, 2)


def changed(base=Plain, **methods):
    """A class with other methods."""
    return type("Net", (base,), methods)


class Random(Plain):
    def forward(self, observations):
        return super().forward(observations + torch.rand(1))


class Forgetful(Plain):
    calls = 0

    def forward(self, observations):
        self.calls += 1
        logits, values = super().forward(observations)
        return logits + self.calls, values


class Elsewhere(Plain):
    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.scale = torch.ones(1, device="meta")

    def forward(self, observations):
        return super().forward(observations * self.scale)


@pytest.mark.parametrize(
    ("network", "message"),
    [
        (
            changed(forward=lambda self, x: Plain.forward(self, x)[0]),
            "gives f32[3, 5]; it should give logits f32[3, 5] and values f32[3]",
        ),
        (
            changed(forward=lambda self, x: (self.policy(self.trunk(x)), self.value(self.trunk(x)))),
            "gives values f32[3, 1]; it should give",
        ),
        (
            changed(forward=lambda self, x: (Plain.forward(self, x)[0][:, 1:], Plain.forward(self, x)[1])),
            "gives logits f32[3, 4]; it should",
        ),
        (
            changed(forward=lambda self, x: tuple(o.double() for o in Plain.forward(self, x))),
            "gives logits f64[3, 5]; it should give",
        ),
        (
            changed(forward=lambda self, x: tuple(o * np.nan for o in Plain.forward(self, x))),
            "gives logits that are not finite",
        ),
        (
            changed(forward=lambda self, x: tuple(o.detach() for o in Plain.forward(self, x))),
            "has logits that depend on no parameter",
        ),
        (
            changed(forward=lambda self, x: self.policy(x)),
            "raises RuntimeError: mat1 and mat2 shapes cannot be multiplied",
        ),
        (
            lambda n, groups: Plain(n, groups).double(),
            "has parameters of type torch.float64; expected: torch.float32",
        ),
        (lambda n, groups: "a network", "gives str; expected: a torch.nn.Module"),
        (lambda n: None, "raises TypeError"),
        (Random, "draws random numbers in forward"),
        (Forgetful, "returns two different outputs for the same observations"),
        (Elsewhere, "raises RuntimeError"),
        (lambda n, groups: Plain(n, groups).to("meta"), "cannot be moved to the device 'cpu'"),
        (changed(memory=16), "has memory = 16, but its forward takes no state"),
        (
            changed(Gru, forward=lambda self, x, state: (*Gru.forward(self, x, state)[:2], state[:, :4])),
            "gives state f32[3, 4]; it should",
        ),
        (
            lambda n, groups: nn.Sequential(nn.Linear(n + 1, 8), nn.Tanh(), nn.Linear(8, 5)),
            "takes 5 observations and gives 5 numbers",
        ),
    ],
)
def test_what_cannot_be_a_brain_is_said_with_what_it_gave_and_should_give(network, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        brain_of(network, 4, GROUPS, (), 1)


def test_a_module_that_takes_a_state_says_how_large_it_is():
    class Silent(Gru):
        def __init__(self, n, groups):
            super().__init__(n, groups)
            del self.memory

    with pytest.raises(ValueError, match=r"set self.memory to the number of values that each organism keeps"):
        brain_of(Silent, 4, GROUPS, (), 1)


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device")
def test_a_device_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match="cannot be moved to the device 'cuda'"):
        brain_of(None, 4, GROUPS, (8,), 1, "cuda")
    with pytest.raises(ValueError, match="cannot be moved to the device 'gpu'"):
        brain_of(Plain, 4, GROUPS, (8,), 1, "gpu")


def test_weights_follow_from_the_seed_alone():
    torch.manual_seed(5)
    before = torch.get_rng_state()
    first, again, other = (brain_of(Plain, 4, GROUPS, (), seed).state() for seed in (1, 1, 2))
    assert torch.equal(before, torch.get_rng_state())
    assert all(np.array_equal(first[name], again[name]) for name in first)
    assert any((first[name] != other[name]).any() for name in first)


@pytest.mark.parametrize("trunk", ["shared", "separate"])
def test_the_built_in_network_as_a_module_says_the_same_and_is_recognised(trunk):
    brain = Brain(4, GROUPS, (16, 8), seed=3, trunk=trunk)
    module, x = as_module(brain), np.random.default_rng(1).standard_normal((50, 4), dtype=np.float32)
    logits, values = module(torch.from_numpy(x))
    ours = brain.forward(x)
    np.testing.assert_allclose(logits.detach().numpy(), ours[0], rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(values.detach().numpy(), ours[1], rtol=1e-4, atol=1e-6)
    back = as_brain(module, 4, GROUPS)
    assert isinstance(back, Brain)
    assert all(map(np.array_equal, back.forward(x), ours))


def test_only_a_module_that_does_what_the_kernels_do_goes_their_way():
    assert isinstance(brain_of(MLP, 4, GROUPS, (), 1), Brain)
    assert isinstance(brain_of(changed(MLP), 4, GROUPS, (), 1), ModuleBrain)
    hooked = MLP(4, GROUPS)
    hooked.register_forward_hook(lambda *_: None)
    assert isinstance(as_brain(hooked, 4, GROUPS), ModuleBrain)


@pytest.mark.parametrize("outputs", [5, 6])
def test_a_sequential_of_linear_and_tanh_becomes_the_built_in_network(outputs):
    torch.manual_seed(2)
    net = nn.Sequential(nn.Linear(4, 16), nn.Tanh(), nn.Linear(16, 8), nn.Tanh(), nn.Linear(8, outputs))
    brain, x = (
        as_brain(from_torch(net), 4, GROUPS),
        np.random.default_rng(1).standard_normal((50, 4), dtype=np.float32),
    )
    logits, values = brain.forward(x)
    right = net(torch.from_numpy(x)).detach().numpy()
    assert isinstance(brain, Brain)
    np.testing.assert_allclose(logits, right[:, :5], rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(values, right[:, 5] if outputs == 6 else 0 * values, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize(
    "net", [nn.Linear(4, 5), nn.Sequential(), nn.Sequential(nn.Linear(4, 5), nn.ReLU(), nn.Linear(5, 5))]
)
def test_other_layers_are_refused_by_from_torch(net):
    with pytest.raises(ValueError, match="expected"):
        from_torch(net)


@pytest.mark.parametrize("network", [Plain, Gru])
def test_a_thought_depends_neither_on_threads_nor_on_how_many_think(network):
    brain = brain_of(network, 24, GROUPS, (), 1)
    rng = np.random.default_rng(1)
    x, memory = (
        rng.standard_normal((5000, 24), dtype=np.float32),
        rng.standard_normal((5000, brain.memory), dtype=np.float32),
    )
    whole = brain.recall(x, memory)
    before = torch.get_num_threads()
    try:
        torch.set_num_threads(2)
        assert all(map(np.array_equal, whole, brain.recall(x, memory, Workers(2).split)))
    finally:
        torch.set_num_threads(before)
    assert all(map(np.array_equal, (a[:2048] for a in whole), brain.recall(x[:2048], memory[:2048])))


def test_wrong_weights_are_named():
    brain = brain_of(Plain, 4, GROUPS, (), 1)
    state = brain.state()
    with pytest.raises(
        ValueError, match=r"weights trunk.9.weight: missing or unknown; this network has trunk.0.weight"
    ):
        brain.load(state | {"trunk.9.weight": state["trunk.0.weight"]})
    with pytest.raises(ValueError, match=r"trunk.0.weight has shape \(2, 2\); this network needs \(16, 4\)"):
        brain.load(state | {"trunk.0.weight": np.zeros((2, 2), np.float32)})
