"""Policies that are functions or external programs; their choices are checked before kernels read them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecs_eco.engine.errors import ConfigError, Problem, listed
from ecs_eco.inputs.section import function_name

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ecs_eco.engine.table import Table
    from ecs_eco.nervous.nerves import Nerves
    from ecs_eco.nervous.ranges import Ranges
    from ecs_eco.space.world import SpatialWorld


class Answer(NamedTuple):
    """External choices for the organisms that sense in this tick."""

    choice: np.ndarray  # i16[n, categorical groups]: options of each
    numbers: np.ndarray  # f32[n, continuous groups], in units of half the range
    told: np.ndarray | None = None  # bool[n], the organisms with choices; None: all


class Outside:
    """A decision maker that replaces a species' network; `partial` means that it decides for some organisms
    and the network decides for all others."""

    partial = False

    def require(self, species: str) -> None:
        """Raise a ConfigError if no choices will be made in the coming tick."""

    def answer(self, nerves: Nerves, table: Table, world: SpatialWorld) -> Answer:
        """Return the choices of this tick."""
        raise NotImplementedError


class Nobody(Outside):
    """An external policy whose control has not been opened yet."""

    def require(self, species: str) -> None:
        """Raise a ConfigError."""
        raise ConfigError(
            [
                Problem(
                    ("species", species, "policy", "kind"),
                    "no program controls it",
                    "external",
                    f'world.external("{species}") and its `observe` and `act`, or an environment of ecs_eco.rl',
                )
            ]
        )

    def answer(self, nerves: Nerves, table: Table, world: SpatialWorld) -> Answer:
        """Raise a ConfigError."""
        self.require(table.name)
        raise AssertionError


class Function(Outside):
    """A policy that is a function of the observations f32[n, channels] and the uids u64[n]."""

    def __init__(self, function: Callable[[np.ndarray, np.ndarray], Any], named: object) -> None:
        self.function, self.named = function, function_name(named)

    def answer(self, nerves: Nerves, table: Table, world: SpatialWorld) -> Answer:
        """Call the function. Raises a ConfigError for invalid choices."""
        uid = table.uid[nerves.rows]
        chosen = self.function(nerves.x, uid)
        return taken(nerves, table, nerves.rows, chosen, f"{self.named}, tick {world.tick}")


def options_of(nerves: Nerves) -> dict[str, tuple[str, ...]]:
    """Return the options of each group in which a policy chooses, in the order of its choices: continuous
    groups last, without options. A group with a single action also has the option of not acting."""
    names: dict[str, tuple[str, ...]] = {}
    for group, (start, n) in nerves.columns.items():
        if group in nerves.ranges.groups or nerves.automatic[start : start + n].all():
            continue
        actions = tuple(nerves.groups[group])
        names[group] = (f"no {actions[0]}", *actions) if n == 1 else actions
    return names | dict.fromkeys(nerves.ranges.groups, ())


def taken(nerves: Nerves, table: Table, rows: np.ndarray, chosen: ArrayLike, source: str) -> Answer:
    """Return choices [k, groups] for rows i64[k] in executable form.

    `chosen` has a column for each group in `options_of`: the index of an option or, for a continuous group, a
    number within its range. Raises a ConfigError that names the organism, the group, the value and the
    expected values.
    """
    values, names = np.asarray(chosen), options_of(nerves)
    shape, discrete = (len(rows), len(names)), len(nerves.offsets) - 1
    if values.shape == shape[:1] and shape[1] == 1:
        values = values[:, None]
    if values.shape != shape or values.dtype.kind not in "iufb":
        raise ConfigError(
            [
                Problem(
                    (table.name, "actions"),
                    f"an array {values.dtype.name}{list(values.shape)}",
                    allowed=f"numbers {list(shape)}: a row for each of the {len(rows)} {table.name} that sense, "
                    f"a column for each of {listed(names)}",
                    source=source,
                )
            ]
        )
    sizes = np.diff(nerves.offsets)
    low = np.concatenate([np.zeros(discrete, np.float32), nerves.ranges.low])
    high = np.concatenate([sizes - 1, nerves.ranges.high])
    wrong = ~((values >= low) & (values <= high))
    if values.dtype.kind == "f" and discrete:
        wrong[:, :discrete] |= values[:, :discrete] != np.floor(values[:, :discrete])
    if wrong.any():
        raise ConfigError(_problems(table, rows, values, wrong, names, (low, high), source))
    numbers = values[:, discrete:].astype(np.float32)
    return Answer(values[:, :discrete].astype(np.int16), _in_halves(nerves.ranges.of(table, rows), numbers))


def _in_halves(ranges: Ranges, values: np.ndarray) -> np.ndarray:
    """Return numbers f32[k, continuous groups] in units of half of each organism's range."""
    low, high = ranges.low, ranges.high
    half = np.where(high > low, (high - low) / 2, np.float32(1))
    numbers: np.ndarray = ((values - (low + high) / 2) / half).astype(np.float32)
    return numbers


def _problems(
    table: Table,
    rows: np.ndarray,
    values: np.ndarray,
    wrong: np.ndarray,
    names: dict[str, tuple[str, ...]],
    ends: tuple[np.ndarray, np.ndarray],
    source: str,
) -> list[Problem]:
    """Return a problem for each of the first few invalid values."""
    groups, problems = list(names), []
    for i, g in np.argwhere(wrong)[:20].tolist():
        options = names[groups[g]]
        allowed = (
            ", ".join(f"{k} ({option})" for k, option in enumerate(options))
            if options
            else f"{ends[0][g]:g} to {ends[1][g]:g}"
        )
        value = values[i, g].item()
        fault = "not a number" if value != value else "no such option" if options else "out of range"
        key = table.name, int(table.uid[rows[i]]), groups[g]
        problems.append(Problem(key, f"{fault} ({int(wrong.sum())} in all)", value, allowed, source=source))
    return problems
