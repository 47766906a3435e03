"""The hyperparameters of PPO, each with its default, its range and a short description."""

from __future__ import annotations

import math
import warnings
from dataclasses import Field, dataclass, field, fields
from typing import TYPE_CHECKING, Any

from ecs_eco.engine.errors import unknown_name
from ecs_eco.learning.aliases import hint, resolve


def _setting(
    default: float, low: float, high: float, doc: str, above: bool = False, own: bool | str = True
) -> Any:
    """Declare a hyperparameter in [low, high], or in (low, high] with `above`; `own` states whether a gene
    can code for it, as for numbers in sections (inputs/section.py)."""
    return field(default=default, metadata={"low": low, "high": high, "above": above, "doc": doc, "own": own})


@dataclass(frozen=True)
class PPO:
    """Hyperparameters of PPO (Schulman et al. 2017).

    The world-file reference lists each hyperparameter with its default under `species.NAME.ppo`;
    `fields(PPO)[i].metadata["doc"]` also describes it. Names from other libraries (gamma, lr, batch_size …)
    are accepted with a warning that shows ours.

    Raises
    ------
    ValueError
        If a value is out of range.
    TypeError
        If a name is unknown.

    Examples
    --------
    >>> from ecs_eco.learning import PPO
    >>> PPO(learning_rate=1e-3, discount=0.98).gae_lambda
    0.95
    """

    horizon: int = _setting(
        64,
        1,
        math.inf,
        "length of a rollout in ticks, regardless of dt",
        own="it is the length of a rollout, which all members of the species share",
    )
    learning_rate: float = _setting(3e-4, 0, math.inf, "step size of Adam", above=True, own="COLUMN")
    discount: float = _setting(
        0.99, 0, 1, "discount factor per tick, regardless of dt; 0.99 ** dt is 0.99 per second", own="COLUMN"
    )
    gae_lambda: float = _setting(
        0.95, 0, 1, "0: one-step advantages; 1: Monte Carlo (Schulman et al. 2016, eq. 16)"
    )
    epochs: int = _setting(3, 1, math.inf, "number of times each transition is used")
    minibatch_size: int = _setting(
        8192, 1, math.inf, "maximum transitions per gradient step; minibatches have equal sizes"
    )
    unroll: int = _setting(
        16,
        1,
        math.inf,
        "ticks of truncated backpropagation, for networks with memory",
        own="it applies to networks with memory, which torch trains together",
    )
    clip: float = _setting(0.2, 0, math.inf, "clip range of the probability ratio around 1", above=True)
    clip_value: float = _setting(
        0.0, 0, math.inf, "clip range of the value around its previous estimate; 0: no clipping"
    )
    entropy_coef: float = _setting(0.01, 0, math.inf, "weight of the entropy bonus", own="COLUMN")
    value_weight: float = _setting(0.5, 0, math.inf, "weight of the mean squared error of the value")
    max_grad_norm: float = _setting(0.5, 0, math.inf, "maximum norm of a minibatch's gradient; 0: no limit")
    normalise_advantage: bool = _setting(
        True, False, True, "normalize a rollout's advantages to mean 0 and standard deviation 1"
    )
    anneal: int = _setting(
        0,
        0,
        math.inf,
        "ticks of learning, in training and in runs, over which learning_rate and clip fall linearly to 0; "
        "0: constant; individual learners are not annealed",
        own="individual learners are not annealed",
    )
    adam_epsilon: float = _setting(
        1e-5, 0, math.inf, "term added to the square root of Adam's second moment", above=True
    )
    weight_decay: float = _setting(
        0.0, 0, math.inf, "fraction of each weight removed per step, in units of the learning rate (AdamW)"
    )

    if not TYPE_CHECKING:  # type checkers see only our names

        def __init__(self, *values: object, **settings: object) -> None:
            """Accept settings by our names or, with a hint, by the names that other libraries use."""
            for alias, name in resolve(settings).items():
                warnings.warn(f"PPO: {hint(alias)}", stacklevel=2)
                settings[name] = settings.pop(alias)
            known = [f.name for f in fields(PPO)]
            if unknown := [name for name in settings if name not in known]:
                raise TypeError(unknown_name("PPO", "setting", unknown[0], known))
            given = dict(zip(known, values, strict=False))
            if len(values) > len(known) or given.keys() & settings:
                raise TypeError(f"PPO takes {len(known)} settings, each at most once: pass them by name")
            for f in fields(PPO):
                value = (given | settings).get(f.name, f.default)
                object.__setattr__(self, f.name, _checked(f, value))


def check_setting(name: str, value: object) -> None:
    """Raise ValueError if a hyperparameter cannot have this value."""
    _checked(PPO.__dataclass_fields__[name], value)


def _checked(f: Field[Any], value: object) -> Any:
    """Return the value as the field's type, or raise ValueError."""
    m, kind = f.metadata, {"int": int, "float": float, "bool": bool}[str(f.type)]
    right_type = {
        int: isinstance(value, int) and not isinstance(value, bool),
        float: isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value),
        bool: isinstance(value, bool),
    }[kind]
    if right_type and (m["low"] < value if m["above"] else m["low"] <= value) and value <= m["high"]:
        return kind(value)
    allowed = {bool: "true or false", int: "a whole number", float: "a finite number"}[kind]
    if kind is not bool:
        allowed += f" {'>' if m['above'] else '>='} {m['low']}"
        allowed += "" if math.isinf(m["high"]) else f" and <= {m['high']}"
    raise ValueError(f"PPO.{f.name} = {value!r}: expected {allowed} ({m['doc']})")
