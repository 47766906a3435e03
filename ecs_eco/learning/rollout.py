"""The rollout: the transitions of a changing population in a single chronological log."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Self

import numpy as np

from ecs_eco.learning.arithmetic import fused_njit

STEP = np.dtype(
    [
        ("row", "i4"),  # in the table; a newborn can reuse the row of an animal that died in the same rollout
        ("log_probability", "f4"),  # of the choice, at the time of the decision
        ("value", "f4"),  # estimate at the time of the decision
        ("reward", "f4"),  # reward, known one tick later
        ("advantage", "f4"),  # filled in by `fill_advantages`
    ]
)
_FIELDS = tuple(STEP.fields or ())


class Rollout:
    """A log of transitions of a population whose members are born and die; outcomes are added once they are
    known.

    Parameters
    ----------
    n_observations : int
    n_groups : int
        Number of categorical action groups.
    discount : float
        Per tick.
    memory : int, default 0
        Number of values that each organism's network keeps.
    n_numbers : int, default 0
        Number of continuous groups.

    Notes
    -----
    In each tick, first record the outcomes of the last actions with `credit`, `end` and `cut`, then `store`
    the new transitions. If results must not depend on rows, neither must the order in which transitions are
    stored.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.learning import Rollout
    >>> rollout = Rollout(n_observations=3, n_groups=1, discount=0.99)
    >>> rows, zeros = np.array([4, 7]), np.zeros(2, np.float32)
    >>> rollout.store(rows, np.zeros((2, 3), np.float32), np.zeros((2, 1), np.int16), zeros, zeros)
    >>> rollout.credit(rows, np.ones(2, np.float32))
    >>> rollout.end(rows[:1], np.ones(1, np.float32))
    >>> rollout.cut(rows[1:], np.ones(1, np.float32), np.zeros(1, np.float32))
    >>> rollout.n
    2
    """

    def __init__(
        self, n_observations: int, n_groups: int, discount: float, memory: int = 0, n_numbers: int = 0
    ) -> None:
        self.discount = discount
        self.n, self.ticks = 0, 0
        self._observations = np.empty((0, n_observations), np.float32)
        self._choices = np.empty((0, n_groups), np.int16)
        self._numbers = np.empty((0, n_numbers), np.float32)
        self._memory = np.empty((0, memory), np.float32)
        self._steps = np.empty(0, STEP)
        self._ended = np.empty(0, bool)  # nothing follows: the row's next record belongs to another animal
        self.last = np.empty(0, np.int64)  # row → its open record, -1: none

    observations = property(lambda self: self._observations[: self.n], doc="f32[n, n_observations]")
    memory = property(lambda self: self._memory[: self.n], doc="f32[n, memory] at decision time")
    choices = property(lambda self: self._choices[: self.n], doc="i16[n, n_groups]")
    numbers = property(
        lambda self: self._numbers[: self.n], doc="f32[n, n_numbers] drawn for continuous actions"
    )
    steps = property(lambda self: self._steps[: self.n], doc="STEP[n]")
    ended = property(lambda self: self._ended[: self.n], doc="bool[n]")

    @property
    def nbytes_per_transition(self) -> int:
        """The size of one transition in bytes."""
        return sum(column.itemsize * int(np.prod(column.shape[1:])) for column in self._columns())

    def store(
        self,
        rows: np.ndarray,
        observations: np.ndarray,
        choices: np.ndarray,
        log_probabilities: np.ndarray,
        values: np.ndarray,
        memory: np.ndarray | None = None,
        numbers: np.ndarray | None = None,
    ) -> None:
        """Append the transitions of one tick.

        Parameters
        ----------
        rows : array of int64, shape (n,)
            Rows of the organisms that act.
        observations : array of float32, shape (n, n_observations)
        choices : array of int, shape (n, n_groups)
        log_probabilities : array of float32, shape (n,)
        values : array of float32, shape (n,)
        memory : array of float32, shape (n, memory), optional
        numbers : array of float32, shape (n, n_numbers), optional
        """
        start, stop = self.n, self.n + len(rows)
        if stop > len(self._ended):
            self._grow(stop)
        self._cover(rows)
        self._observations[start:stop] = observations
        self._choices[start:stop] = choices
        if memory is not None:
            self._memory[start:stop] = memory
        if numbers is not None:
            self._numbers[start:stop] = numbers
        steps = self._steps[start:stop]
        steps["row"], steps["log_probability"], steps["value"] = rows, log_probabilities, values
        steps["reward"], steps["advantage"] = 0, 0
        self._ended[start:stop] = False
        self.last[rows] = np.arange(start, stop)
        self.n = stop
        self.ticks += 1

    def credit(self, rows: np.ndarray, rewards: np.ndarray) -> None:
        """Add rewards to the last transitions of rows; rows without one, such as newborns, are skipped.

        Parameters
        ----------
        rows : array of int64, shape (n,)
        rewards : array of float32, shape (n,)
        """
        self._cover(rows)
        _credit(self._steps, self.last, rows, rewards)

    def end(self, rows: np.ndarray, rewards: np.ndarray) -> None:
        """Add the last rewards of rows that died, and end their lives.

        Parameters
        ----------
        rows : array of int64, shape (n,)
        rewards : array of float32, shape (n,)
        """
        self._cover(rows)
        _end(self._steps, self._ended, self.last, rows, rewards)

    def cut(self, rows: np.ndarray, rewards: np.ndarray, values: np.ndarray) -> None:
        """Add the last rewards of rows that end because of a time limit.

        Parameters
        ----------
        rows : array of int64, shape (n,)
        rewards : array of float32, shape (n,)
        values : array of float32, shape (n,)
            Estimates of the returns that would have followed.
        """
        self.end(rows, rewards + np.float32(self.discount) * values)

    def leave(self, rows: np.ndarray) -> None:
        """Close the records of organisms that emigrate, as if their last action had had the expected outcome."""
        self._cover(rows)
        last = self.last[rows]
        rest = (
            np.where(last >= 0, self._steps["value"][last] - self._steps["reward"][last], 0)
            if self.n
            else np.zeros(len(rows))
        )
        self.end(rows, rest.astype(np.float32))

    def advantages(self, rows: np.ndarray, values: np.ndarray, gae_lambda: float) -> None:
        """Fill in the advantages (Schulman et al. 2016, eq. 16); values f32[n] estimate the future rewards of
        the living organisms in `rows`."""
        self._cover(rows)
        later = np.full(len(self.last), np.nan, np.float32)
        later[rows] = values
        if (lost := np.flatnonzero((self.last >= 0) & np.isnan(later))).size:
            raise ValueError(
                f"rows {lost[:5].tolist()} ({lost.size} in all) have open records but no finite value: pass "
                "the values of all living organisms, and end or cut the others first"
            )
        gain = np.zeros_like(later)
        fill_advantages(
            self.steps, self.ended, later, gain, np.float32(self.discount), np.float32(gae_lambda)
        )

    @classmethod
    def like(cls, other: Rollout) -> Self:
        """Return an empty log of transitions with the same shape."""
        n_observations, n_groups, n_numbers, memory = (c.shape[1] for c in other._columns()[:4])
        return cls(n_observations, n_groups, other.discount, memory, n_numbers)

    @classmethod
    def joined(cls, parts: Sequence[Rollout]) -> Rollout:
        """Merge several logs with known advantages into one, whose row numbers are meaningless."""
        out = cls.like(parts[0])
        columns = ([column[: p.n] for column in p._columns()] for p in parts)
        out._hold(np.concatenate(column) for column in zip(*columns, strict=True))
        row = 0
        # animals in different parts must not share a row
        for part, n in zip(parts, np.cumsum([p.n for p in parts]), strict=True):
            out._steps["row"][n - part.n : n] += row
            row += int(part.steps["row"].max(initial=-1)) + 1
        out.n, out.ticks = len(out._ended), max(p.ticks for p in parts)
        return out

    def stretches(self, longest: int) -> tuple[np.ndarray, np.ndarray]:
        """Return indices i64[n] of transitions, life by life in chronological order, and the start of each
        stretch among them.

        The starts, i64[stretches + 1], end with n; a stretch has `longest` transitions, but the last stretch
        of a life can have fewer.
        """
        order, follows = _lives(self.steps["row"], self.ended)
        begins = np.concatenate([[True], ~follows])[: self.n]
        place = np.arange(self.n)
        age = place - np.maximum.accumulate(np.where(begins, place, 0))
        return order, np.append(np.flatnonzero(age % longest == 0), self.n)

    def clear(self) -> None:
        """Remove all transitions but keep the memory allocated."""
        self.n, self.ticks = 0, 0
        self.last[:] = -1

    def state(self) -> dict[str, np.ndarray]:
        """Return copies of everything needed to continue from here."""
        return {
            "observations": self.observations.copy(),
            "choices": self.choices.copy(),
            **{name: getattr(self, name).copy() for name in self._optional()},
            **{name: self.steps[name].copy() for name in _FIELDS},
            "ended": self.ended.copy(),
            "last": self.last.copy(),
            "ticks": np.array(self.ticks),
        }

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Resume from a `state()` of a rollout with the same numbers of observations and groups."""
        flat = ("observations", "choices", *self._optional())
        for name in flat:
            have, need = np.shape(state[name])[1:], getattr(self, name).shape[1:]
            if have != need:
                raise ValueError(f"{name} of the rollout have {have} columns; this one needs {need}")
        n, last, row = len(state["ended"]), np.array(state["last"]), state["row"]
        if wrong := [name for name in (*flat, *_FIELDS) if len(state[name]) != n]:
            raise ValueError(
                f"{wrong[0]} of the rollout has {len(state[wrong[0]])} transitions, but ended has {n}"
            )
        if last.dtype != np.int64 or (last.size and not -1 <= last.min() <= last.max() < n):
            raise ValueError(f"last of the rollout points outside its {n} transitions")
        if n and not 0 <= row.min() <= row.max() < len(last):
            raise ValueError(
                f"row of the rollout is {row.min()} to {row.max()}; expected: 0 to {len(last) - 1}"
            )
        self.n, self.ticks = 0, int(state["ticks"])
        if n > len(self._ended):
            self._grow(n)
        self.n = n
        for name in flat:
            getattr(self, name)[...] = state[name]
        self.ended[...], self.last = state["ended"], last
        for name in _FIELDS:
            self.steps[name] = state[name]

    def by_uid(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Return a `state()` that links each record to the next record of the same animal instead of to a row;
        `rows` i64[n] are the living organisms, sorted by uid.

        `next` is the next record in the same life, `open` the last record of each living organism; -1 means
        none.
        """
        state = self.state()
        row, ended, last = state.pop("row"), state["ended"], state.pop("last")
        order, follows = _lives(row, ended)
        state["next"] = np.full(len(row), -1, np.int64)
        state["next"][order[:-1][follows]] = order[1:][follows]
        state["open"] = np.concatenate(
            [last, np.full(max(0, int(rows.max(initial=-1)) + 1 - len(last)), -1)]
        )[rows]
        return state

    def reorder(self, order: np.ndarray) -> None:
        """Update the rows of organisms that have moved: the organism from row `order[i]`, i64[capacity], is
        now in row i."""
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        self.steps["row"] = place[self.steps["row"]]
        last = np.full(len(order), -1, np.int64)
        last[: len(self.last)] = self.last
        self.last = last[order]

    def _columns(self) -> tuple[np.ndarray, ...]:
        return (self._observations, self._choices, self._numbers, self._memory, self._steps, self._ended)

    def _hold(self, columns: Iterable[np.ndarray]) -> None:
        """Set the arrays, in the same order as `_columns`."""
        (self._observations, self._choices, self._numbers, self._memory, self._steps, self._ended) = columns

    def _optional(self) -> list[str]:
        """Return the names of the optional columns that this rollout has."""
        return [name for name in ("numbers", "memory") if getattr(self, name).shape[1]]

    def _grow(self, need: int) -> None:
        """Reserve space for `need` records and half as many again; stored records are copied once."""
        size = need + need // 2
        grown = []
        for column in self._columns():
            grown.append(np.empty((size, *column.shape[1:]), column.dtype))
            grown[-1][: self.n] = column[: self.n]
        self._hold(grown)

    def _cover(self, rows: np.ndarray) -> None:
        """Extend `last` to these rows."""
        need = int(rows.max()) + 1 if len(rows) else 0
        if need > len(self.last):
            self.last = np.concatenate([self.last, np.full(need - len(self.last), -1)])


def _lives(row: np.ndarray, ended: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of records i64[n] sorted by row, then by time, and whether each record but the first
    continues the life of the previous record, bool[n - 1]."""
    order = np.argsort(row, kind="stable")
    return order, (row[order[1:]] == row[order[:-1]]) & ~ended[order[:-1]]


@fused_njit
def _credit(steps, last, rows, rewards):
    for i in range(len(rows)):
        if last[rows[i]] >= 0:
            steps[last[rows[i]]].reward += rewards[i]


@fused_njit
def _end(steps, ended, last, rows, rewards):
    for i in range(len(rows)):
        at = last[rows[i]]
        if at >= 0:
            steps[at].reward += rewards[i]
            ended[at] = True
            last[rows[i]] = -1


@fused_njit
def fill_advantages(steps, ended, later, gain, discount, gae_lambda):
    """Fill in the advantages (Schulman et al. 2016, eq. 16) of transitions STEP[n] in chronological order;
    after each, its row's life continues unless `ended` bool[n].

    `later` and `gain` f32[rows] contain the value and the advantage of each row's next transition; initially,
    these are the bootstrap value and 0.
    """
    for i in range(len(steps) - 1, -1, -1):
        step = steps[i]
        if ended[i]:
            later[step.row], gain[step.row] = 0, 0
        td_error = step.reward + discount * later[step.row] - step.value
        step.advantage = td_error + discount * gae_lambda * gain[step.row]
        later[step.row], gain[step.row] = step.value, step.advantage


@fused_njit
def summarize(steps, normalise):
    """Return the shift and the scale that normalize the advantages of a rollout STEP[n] to mean 0 and standard
    deviation 1 (or 0 and 1), the share of the targets' variance that the values explain, and the mean reward;
    undefined values are NaN."""
    n = len(steps)
    mean = target_mean = variance = target_variance = reward = 0.0
    for i in range(n):
        mean += steps[i].advantage
        target_mean += steps[i].advantage + steps[i].value
        reward += steps[i].reward
    mean, target_mean, reward = mean / n, target_mean / n, reward / n
    for i in range(n):
        variance += (steps[i].advantage - mean) ** 2
        target_variance += (steps[i].advantage + steps[i].value - target_mean) ** 2
    explained = 1 - variance / target_variance if target_variance > 0 else np.nan
    shift, scale = (mean, 1 / (np.sqrt(variance / n) + 1e-8)) if normalise and n > 1 else (0.0, 1.0)
    return shift, scale, explained, reward
