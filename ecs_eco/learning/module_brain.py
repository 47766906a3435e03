"""Any torch module as a brain: what it must provide, and how a world runs it.

`Net(n_observations, groups)` is an ordinary `torch.nn.Module` with `forward(observations f32[n, d]) → (logits
f32[n, k], values f32[n])`, k = sum(groups). A module with memory declares how many numbers each organism
keeps, `self.memory = 64`, and has `forward(observations, state f32[n, memory]) → (logits, values, state)`. It
always runs in evaluation mode and must not draw random numbers.
"""

from __future__ import annotations

import copy
import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import torch

from ecs_eco.compiled.threads import one_torch_thread
from ecs_eco.learning.brain import Brain
from ecs_eco.learning.continuous import laid_out
from ecs_eco.learning.mlp import plain
from ecs_eco.learning.policy_network import PolicyNetwork, Split

CHUNK = 2048  # rows that a module receives at once
# rows are padded to a multiple of this, because smaller products use other code and differ in the last bits
LANES = 16


class ModuleBrain(PolicyNetwork):
    """A torch module used in place of a `Brain`.

    Parameters
    ----------
    module : torch.nn.Module
        Its `forward` takes observations f32[n, n_observations] and returns logits f32[n, sum(groups)] and
        values f32[n]. If it has the `memory` attribute, the number of values that each organism keeps, it
        also takes and returns a state f32[n, memory].
    n_observations : int
    groups : tuple of int
    device : str, default "cpu"
        "cpu", "cuda" or "cuda:1". On the CPU, results are bit-identical for any number of threads.

    Raises
    ------
    ValueError
        If the module does not meet these requirements.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.learning import MLP, ModuleBrain
    >>> brain = ModuleBrain(MLP(3, (2, 4)), 3, (2, 4))
    >>> brain.forward(np.zeros((5, 3), np.float32))[0].shape
    (5, 6)
    """

    by_row = False  # torch computes a chunk of rows at once
    called = "network"

    def __init__(
        self, module: torch.nn.Module, n_observations: int, groups: tuple[int, ...], device: str = "cpu"
    ) -> None:
        if not isinstance(module, torch.nn.Module):
            raise ValueError(f"gives {type(module).__name__}; expected: a torch.nn.Module")
        self.n_observations, self.groups, self.device = n_observations, tuple(groups), device
        # categorical group g's logits are offsets[g]:offsets[g + 1], followed by means and log standard
        # deviations
        self.offsets, self.n_numbers = laid_out(groups)
        self.n_logits = sum(groups)
        try:
            self.module = module.to(device).eval()
        except (RuntimeError, NotImplementedError, AssertionError) as error:
            raise ValueError(f"cannot be moved to the device {device!r}: {_first_line(error)}") from None
        self.memory = memory_of(module)
        self._check()

    def parameters(self) -> list[torch.nn.Parameter]:
        """Return the parameters that learning changes, in the module's order."""
        return [p for p in self.module.parameters() if p.requires_grad]

    def named(self) -> dict[str, np.ndarray]:
        """Return the parameters that learning changes, by name; on the CPU they are views."""
        return {
            name: p.detach().cpu().numpy() for name, p in self.module.named_parameters() if p.requires_grad
        }

    def _parts(self) -> dict[str, np.ndarray]:
        return {name: tensor.detach().cpu().numpy() for name, tensor in self.module.state_dict().items()}

    def _set(self, state: dict[str, np.ndarray]) -> None:
        self.module.load_state_dict({name: torch.from_numpy(np.array(part)) for name, part in state.items()})

    def recall(
        self, observations: np.ndarray, memory: np.ndarray, split: Split | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the logits, values and next memory f32[n, memory] of organisms with this memory."""
        n = self._rows(observations)
        logits, values = np.empty((n, self.n_logits), np.float32), np.empty(n, np.float32)
        later = np.empty((n, self.memory), np.float32)
        with self.reproducible(), torch.inference_mode(), one_torch_thread():
            for start in range(0, n, CHUNK):
                here = slice(start, min(start + CHUNK, n))
                size = here.stop - start
                out = self.run(
                    _filled(observations[here]), self.tensor(_filled(memory[here])) if self.memory else None
                )
                logits[here], values[here] = out[0][:size].cpu().numpy(), out[1][:size].cpu().numpy()
                if self.memory:
                    later[here] = out[2][:size].cpu().numpy()
        return logits, values, later

    def run(self, observations: np.ndarray, state: torch.Tensor | None = None) -> tuple[torch.Tensor, ...]:
        """Call the module: return logits, values and, with memory, the next state, as tensors with
        gradients."""
        x = self.tensor(observations)
        out = self.module(x) if state is None else self.module(x, state)
        return out

    def tensor(self, array: np.ndarray) -> torch.Tensor:
        """Return an array as a tensor on the module's device."""
        return torch.from_numpy(np.ascontiguousarray(array)).to(self.device)

    @contextmanager
    def reproducible(self) -> Iterator[None]:
        """Make torch use only deterministic algorithms within this context. Raises RuntimeError if an
        operation has no such algorithm."""
        before, warns = (
            torch.are_deterministic_algorithms_enabled(),
            torch.is_deterministic_algorithms_warn_only_enabled(),
        )
        torch.use_deterministic_algorithms(self.device == "cpu" or before, warn_only=warns and before)
        try:
            yield
        finally:
            torch.use_deterministic_algorithms(before, warn_only=warns)

    def _check(self) -> None:
        """Raise ValueError unless the module returns the expected output for 3 and for 16 organisms, gives
        the same output each time, and can learn."""
        wrong = {str(p.dtype) for p in self.module.parameters() if p.dtype != torch.float32}
        if wrong:
            raise ValueError(f"has parameters of type {', '.join(sorted(wrong))}; expected: torch.float32")
        generator = np.random.Generator(np.random.Philox(key=[1, 2]))
        for n in (3, 16):
            x = generator.standard_normal((n, self.n_observations), dtype=np.float32)
            state = self.tensor(np.zeros((n, self.memory), np.float32)) if self.memory else None
            before = torch.get_rng_state()
            first, second = self._outputs(x, state), self._outputs(x, state)
            if not torch.equal(before, torch.get_rng_state()):
                raise ValueError(
                    "draws random numbers in forward; expected: an output that depends only on the observations"
                )
            if not all(torch.equal(a, b) for a, b in zip(first, second, strict=True)):
                raise ValueError(
                    "returns two different outputs for the same observations; keep its memory in the state"
                )
        if not (first[0].requires_grad and self.parameters()):
            raise ValueError("has logits that depend on no parameter; expected: a module that can learn")

    def _outputs(self, x: np.ndarray, state: torch.Tensor | None) -> tuple[torch.Tensor, ...]:
        n = len(x)
        need = {"logits": (n, self.n_logits), "values": (n,)} | (
            {"state": (n, self.memory)} if self.memory else {}
        )
        wanted = " and ".join(f"{name} f32{list(shape)}" for name, shape in need.items())
        given = (
            "forward(observations "
            f"f32{list(x.shape)}{f', state f32[{n}, {self.memory}]' if self.memory else ''})"
        )
        try:
            with one_torch_thread(), self.reproducible():
                out: Any = self.run(x, state)
        except Exception as error:
            raise ValueError(
                f"{given} raises {type(error).__name__}: {_first_line(error)}; it should give {wanted}"
            ) from error
        if (
            not isinstance(out, tuple)
            or len(out) != len(need)
            or not all(isinstance(o, torch.Tensor) for o in out)
        ):
            raise ValueError(f"{given} gives {_described(out)}; it should give {wanted}")
        for (name, shape), tensor in zip(need.items(), out, strict=True):
            if tuple(tensor.shape) != shape or tensor.dtype != torch.float32:
                raise ValueError(f"{given} gives {name} {_described(tensor)}; it should give {wanted}")
            if tensor.device.type != torch.device(self.device).type:
                raise ValueError(f"{given} gives {name} on {tensor.device}; expected: {self.device!r}")
            if not bool(torch.isfinite(tensor).all()):
                raise ValueError(f"{given} gives {name} that are not finite; it should give {wanted}")
        return out


def made(network: Callable[..., Any], n_observations: int, groups: tuple[int, ...], seed: int) -> Any:
    """Return `network(n_observations, groups)`, with random weights determined by the seed. Raises ValueError
    if the call fails."""
    with torch.random.fork_rng(devices=[]), one_torch_thread():
        torch.manual_seed(seed)
        try:
            return network(n_observations, groups)
        except Exception as error:
            raise ValueError(
                f"({n_observations}, {groups}) raises {type(error).__name__}: {_first_line(error)}"
            ) from error


def as_brain(
    module: torch.nn.Module, n_observations: int, groups: tuple[int, ...], device: str = "cpu"
) -> PolicyNetwork:
    """Return a module as a brain: a `Brain` if it is a plain MLP on the CPU, otherwise a `ModuleBrain`."""
    if device == "cpu" and (known := plain(module, n_observations, sum(groups))) is not None:
        hidden, trunk, state = known
        brain = Brain(n_observations, groups, hidden, 0, trunk)
        brain.load(state)
        return brain
    return ModuleBrain(module, n_observations, groups, device)


def as_module(brain: PolicyNetwork) -> torch.nn.Module:
    """Return a copy of a brain as an independent torch module."""
    if not isinstance(brain, Brain):
        assert isinstance(brain, ModuleBrain)
        return copy.deepcopy(brain.module).cpu()
    return brain.module(brain.weights)


def memory_of(module: torch.nn.Module) -> int:
    """Return how many numbers a module keeps per organism. Raises ValueError if the module does not
    declare it."""
    try:
        taken = inspect.signature(module.forward).parameters.values()
    except (TypeError, ValueError):
        return int(getattr(module, "memory", 0))
    positional = [p for p in taken if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    takes_state = len([p for p in positional if p.default is p.empty]) > 1 or any(
        p.kind is p.VAR_POSITIONAL for p in taken
    )
    memory = getattr(module, "memory", 0)
    if isinstance(memory, bool) or not isinstance(memory, int) or memory < 0:
        raise ValueError(
            f"has memory = {memory!r}; expected: the number of values that each organism keeps, >= 0"
        )
    if takes_state and not memory:
        raise ValueError(
            "takes a state in forward but does not declare its size: set self.memory to the number of "
            "values that each organism keeps"
        )
    if memory and len(positional) < 2 and not takes_state:
        raise ValueError(
            f"has memory = {memory}, but its forward takes no state; expected: forward(observations, state)"
        )
    return memory


def _filled(rows: np.ndarray) -> np.ndarray:
    """Return f32[n, …] padded with zeros to a multiple of LANES rows."""
    n = len(rows)
    out = np.zeros((-(-n // LANES) * LANES, *rows.shape[1:]), np.float32)
    out[:n] = rows
    return out


def _described(value: object) -> str:
    if isinstance(value, torch.Tensor):
        return f"{str(value.dtype).removeprefix('torch.').replace('float', 'f').replace('int', 'i')}{list(value.shape)}"  # noqa: E501
    if isinstance(value, tuple):
        return f"({', '.join(_described(v) for v in value)})"
    return type(value).__name__


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
