"""Small networks fitted to hand-written reflex and happiness functions, so that mutations have weights to
change."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Self

import numpy as np

from ecs_eco.compiled.threads import one_torch_thread
from ecs_eco.genomes.later import kernels

BATCH = 512
RATE = 1e-2  # initial learning rate of Adam; it falls to 0
HELD_OUT = 4096  # number of samples used to measure the error


@dataclass(frozen=True)
class Fitted:
    """A network of tanh layers that replaces the function to which it was fitted; call it with sensor
    readings.

    Attributes
    ----------
    kind : {"reflex", "happiness"}
        A happiness network returns float32, shape (n,); a reflex network returns the most probable of −1, 0
        and 1 as int8, shape (n, actions).
    sizes : tuple of int
        Number of units in each layer, including inputs and outputs.
    weights : array of float32
        For each layer, the matrix (inputs, units) row by row, then the bias.
    error : float
        Error on held-out samples: share of wrong answers (reflex) or root mean square error (happiness).

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.genomes import fit_network
    >>> flee = fit_network(lambda x: x[:, :1] - 0.5, n_inputs=2, low=0.0, high=1.0, steps=300)
    >>> x = np.zeros((2, 2), np.float32)
    >>> np.array_equal(flee.each(x, flee.weights[None]), flee.with_weights(flee.weights)(x))
    True
    """

    kind: Literal["reflex", "happiness"]
    sizes: tuple[int, ...]
    weights: np.ndarray
    # on held-out samples: share of wrong answers (reflex) or root mean square error (happiness)
    error: float

    @property
    def shapes(self) -> list[tuple[int, ...]]:
        """Shapes of its matrices and biases, in the order of the weights."""
        return [shape for a, b in zip(self.sizes, self.sizes[1:], strict=False) for shape in ((a, b), (b,))]

    def __call__(self, x: np.ndarray) -> np.ndarray:
        return self.each(x, self.weights[None])

    def each(self, x: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Return the outputs of one network per row.

        Parameters
        ----------
        x : array of float32, shape (n, inputs)
        weights : array of float32, shape (n, size) or (1, size)

        Returns
        -------
        array
            The same values as when the network is called.

        Raises
        ------
        ValueError
            If an array has the wrong shape.
        """
        if np.ndim(x) != 2 or x.shape[1] != self.sizes[0]:
            raise ValueError(f"network: readings have shape {np.shape(x)}; expected (n, {self.sizes[0]})")
        if weights.shape[1:] != self.weights.shape or len(weights) not in (1, len(x)):
            allowed = f"(n, {self.weights.size}), n = 1 or {len(x)}"
            raise ValueError(f"network: weights have shape {weights.shape}; expected {allowed}")
        out = np.empty((len(x), self.sizes[-1]), np.float32)
        kernels.forward(
            np.ascontiguousarray(x, np.float32),
            np.array(self.sizes),
            np.ascontiguousarray(weights, np.float32),
            out,
        )
        if self.kind == "happiness":
            return out[:, 0]
        return (out.reshape(len(x), self.sizes[-1] // 3, 3).argmax(axis=2) - 1).astype(np.int8)

    def with_weights(self, weights: np.ndarray) -> Self:
        """Return a network with the same layers but different weights.

        Parameters
        ----------
        weights : array of float32, shape (size,)

        Returns
        -------
        Fitted

        Raises
        ------
        ValueError
            If the array has the wrong shape.
        """
        weights = np.array(weights, np.float32)
        if weights.shape != self.weights.shape:
            raise ValueError(f"network: weights have shape {weights.shape}; expected {self.weights.shape}")
        return replace(self, weights=weights, error=float("nan"))


def fit_network(
    function: Callable[[np.ndarray], np.ndarray],
    n_inputs: int,
    low: float | Sequence[float],
    high: float | Sequence[float],
    hidden: Sequence[int] = (16,),
    kind: Literal["reflex", "happiness"] = "reflex",
    seed: int = 0,
    samples: int = 8192,
    steps: int = 2000,
) -> Fitted:
    """Fit a network to a hand-written reflex or happiness function, so that genes can code for its weights.

    Parameters
    ----------
    function : callable
        Takes readings f32[n, n_inputs]. A reflex returns (n, actions), of which only the signs matter; a
        happiness function returns (n,).
    n_inputs : int
        Number of channels.
    low, high : float or sequence of float
        Lowest and highest reading of each channel; samples are drawn uniformly between them.
    hidden : sequence of int, default (16,)
        Number of units in each hidden layer.
    kind : {"reflex", "happiness"}
    seed : int, default 0
        Determines the samples and the initial weights.
    samples : int, default 8192
    steps : int, default 2000
        Number of Adam steps.

    Returns
    -------
    Fitted

    Raises
    ------
    ValueError
        If the function returns an array of the wrong shape, or values that are not finite.

    Examples
    --------
    >>> from ecs_eco.genomes import fit_network
    >>> flee = fit_network(lambda x: x[:, :1] - 0.5, n_inputs=2, low=0.0, high=1.0, steps=300)
    >>> flee.error < 0.05
    True
    """
    if kind not in ("reflex", "happiness"):
        raise ValueError(f"fit_network: kind = {kind!r}; expected reflex or happiness")
    least, most = (np.broadcast_to(np.asarray(end, np.float32), (n_inputs,)) for end in (low, high))
    if not (least < most).all():
        raise ValueError(f"fit_network: low = {low}, high = {high}; each low must be less than its high")
    rng = np.random.Generator(np.random.Philox(seed))
    x, x_held = (rng.uniform(least, most, (n, n_inputs)).astype(np.float32) for n in (samples, HELD_OUT))
    y, y_held = (_answers(function, part, kind) for part in (x, x_held))
    middle, half = (least + most) / 2, (most - least) / 2
    scale = (0.0, 1.0) if kind == "reflex" else (float(y.mean()), float(y.std()) or 1.0)
    sizes = (n_inputs, *hidden, 1 if kind == "happiness" else 3 * y.shape[1])
    target = (y - scale[0]) / scale[1] if kind == "happiness" else y + 1
    with one_torch_thread():
        layers = _train((x - middle) / half, target.astype(np.float32), sizes, rng, steps, kind)
    # the network receives raw readings and returns values in raw units
    layers[0][1] -= ((middle / half)[:, None] * layers[0][0]).sum(axis=0)
    layers[0][0] /= half[:, None]
    layers[-1][0] *= scale[1]
    layers[-1][1] *= scale[1]
    layers[-1][1] += scale[0]
    weights = np.concatenate([part.ravel() for layer in layers for part in layer]).astype(np.float32)
    fitted = Fitted(kind, sizes, weights, 0.0)
    answers = fitted(x_held)
    off = answers.astype(np.float64) - y_held
    error = np.mean(off != 0) if kind == "reflex" else np.sqrt(np.mean(off**2))
    return replace(fitted, error=float(error))


def _answers(function: Callable[[np.ndarray], np.ndarray], x: np.ndarray, kind: str) -> np.ndarray:
    y = np.asarray(function(x.copy()), np.float32)
    if y.ndim != (2 if kind == "reflex" else 1) or len(y) != len(x):
        allowed = "(n, actions)" if kind == "reflex" else "(n,)"
        raise ValueError(
            f"fit_network: the function returns shape {y.shape} for {len(x)} readings; expected {allowed}"
        )
    if not np.isfinite(y).all():
        raise ValueError(
            "fit_network: the function returns numbers that are not finite; expected finite numbers between "
            "low and high"
        )
    return np.sign(y) if kind == "reflex" else y


def _train(
    x: np.ndarray, y: np.ndarray, sizes: tuple[int, ...], rng: np.random.Generator, steps: int, kind: str
) -> list[list[np.ndarray]]:
    """Return the matrix (in, out) and the bias of each layer, trained by Adam on minibatches."""
    import torch

    def start(*shape: int) -> torch.Tensor:
        return torch.tensor(
            rng.normal(0, 1 / np.sqrt(shape[0]), shape), dtype=torch.float32, requires_grad=True
        )

    layers = [
        [start(a, b), torch.zeros(b, requires_grad=True)] for a, b in zip(sizes, sizes[1:], strict=False)
    ]
    optimiser = torch.optim.Adam([part for layer in layers for part in layer], lr=RATE)
    inputs, targets = torch.from_numpy(x), torch.from_numpy(y)
    for step in range(steps):
        optimiser.param_groups[0]["lr"] = RATE * (1 - step / steps)
        rows = torch.from_numpy(rng.integers(0, len(x), min(BATCH, len(x))))
        out: Any = inputs[rows]
        for i, (matrix, bias) in enumerate(layers):
            out = torch.addmm(bias, out, matrix)
            out = torch.tanh(out) if i < len(layers) - 1 else out
        if kind == "reflex":
            loss = torch.nn.functional.cross_entropy(out.view(-1, 3), targets[rows].long().view(-1))
        else:
            loss = torch.mean((out[:, 0] - targets[rows]) ** 2)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    return [[part.detach().numpy().copy() for part in layer] for layer in layers]
