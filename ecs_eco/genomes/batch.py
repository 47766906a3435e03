"""Births: children's genomes from parents' genomes, in batches or one by one."""

import random
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.engine.random import mix_int
from ecs_eco.genomes import kernels
from ecs_eco.genomes.layout import Layout
from ecs_eco.genomes.models import GenomeSection
from ecs_eco.genomes.operators import (
    check_operator,
    choice_of,
    kept_random,
    strings_of,
    taken_apart,
    toolbox_of,
)
from ecs_eco.inputs.code import handed_over

if TYPE_CHECKING:
    from deap.base import Toolbox

Births = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]
"""Both parents, whether they are swapped and crossed, keys, and a salt."""
MATE, MUTATE = 1, 2  # parts of a birth's key that seed Python's random numbers


class Operators:
    """The operators of a DEAP toolbox, applied to all births of a tick at once.

    Parameters
    ----------
    toolbox : deap.base.Toolbox
        With `mate` and `mutate`; `toolbox_of` makes one. Offspring are made by what is registered at the time.
    layout : Layout
    chance : float, default 1.0
        Probability of a crossover.
    mates : bool, default True
        Whether genomes of two parents are crossed; otherwise `mate` is not checked.

    Attributes
    ----------
    mutation : bool
        Set it to False to switch mutation off.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.genomes import Gene, Layout, Operators, toolbox_of
    >>> layout = Layout([Gene(name="size", trait="size", letters=8, low=0.0, high=1.0)])
    >>> toolbox = toolbox_of({"mutate": {"operator": "mutUniformInt", "indpb": 0.0}}, layout)
    >>> operators = Operators(toolbox, layout)
    >>> mothers, fathers = layout.rows(["AAAAAAAA"]), layout.rows(["CCCCCCCC"])
    >>> child = layout.text(operators.offspring(mothers, fathers, np.arange(1, dtype=np.uint64))[0])
    >>> set(child) <= {"A", "C"}
    True
    """

    def __init__(self, toolbox: "Toolbox", layout: Layout, chance: float = 1.0, mates: bool = True) -> None:
        if not 0 <= chance <= 1:
            raise ValueError(f"mate: chance = {chance}; expected 0 to 1")
        self.toolbox, self.layout, self.chance, self.mutation = toolbox, layout, chance, True
        # mutate, with its chance, low and up for each locus
        self._loci: tuple[Any, np.ndarray, np.ndarray, np.ndarray] | None = None
        self._seen: dict[str, tuple[Any, Callable[..., Any], dict[str, Any]]] = {}
        for word in ("mate", "mutate") if mates else ("mutate",):
            self._operator(word)

    @classmethod
    def from_config(
        cls,
        section: GenomeSection,
        layout: Layout,
        select_mate: str = "nearest",
        find: Callable[[Any], Any] = handed_over,
        mates: bool = True,
    ) -> "Operators":
        """Return the operators of the genome of a world file.

        Parameters
        ----------
        section : GenomeSection
        layout : Layout
        select_mate, find, mates
            As for `toolbox_of`.

        Returns
        -------
        Operators
        """
        if layout.longest is not None:
            raise ValueError(
                "Operators.from_config: strings of this layout vary in length; "
                "ecs_eco.genomes.operators_of takes it"
            )
        return cls(toolbox_of(section, layout, select_mate, find, mates), layout, section.mate.chance, mates)

    @property
    def choice(self) -> int:
        """The number in CHOICES of the toolbox's `select_mate`; −1: a user's function."""
        return choice_of(self.toolbox)

    def offspring(self, first: np.ndarray, second: np.ndarray | None, keys: np.ndarray) -> np.ndarray:
        """Return the genomes of children.

        With one string, two parents are crossed and the child is the first of the two results, with the
        parents in random order; the genome of a single parent is copied. With two strings, each parent gives
        one, crossed from its two. Then the child mutates.

        Parameters
        ----------
        first : array of uint8, shape (k, row)
            Genomes of the first parents.
        second : array of uint8, shape (k, row), optional
            Genomes of the second parents.
        keys : array of uint64, shape (k,)
            A child depends only on its parents and its key.

        Returns
        -------
        array of uint8, shape (k, row)

        Raises
        ------
        ValueError
            If an operator returns something that is not a genome.
        """
        layout, n = self.layout, self.layout.length
        first, keys = layout.check(first), np.asarray(keys, np.uint64)
        if second is None:
            child = first.copy()
        elif layout.ploidy == 1:
            child = self._cross(first, layout.check(second), keys, 0)
        else:
            second = layout.check(second)
            gametes = [self._cross(p[:, :n], p[:, n:], keys, 1 + i) for i, p in enumerate((first, second))]
            turned = toss(keys, 0, kernels.ORDER)[:, None] < 0.5
            child = np.concatenate([np.where(turned, *gametes[::-1]), np.where(turned, *gametes)], axis=1)
        for string in range(layout.ploidy if self.mutation else 0):
            self._mutate(child[:, string * n : (string + 1) * n], keys, string)
        return child

    def _operator(self, word: str) -> tuple[Callable[..., Any], dict[str, Any]]:
        """Return the function registered under a word and its arguments, checked on first sight."""
        operator = getattr(self.toolbox, word)
        if word not in self._seen or self._seen[word][0] is not operator:
            check_operator(word, operator, self.layout)
            self._seen[word] = operator, *taken_apart(word, operator)
        return self._seen[word][1:]

    def _cross(self, a: np.ndarray, b: np.ndarray, keys: np.ndarray, salt: int) -> np.ndarray:
        function, arguments = self._operator("mate")
        swapped = toss(keys, salt, kernels.ORDER) < 0.5
        crossed = toss(keys, salt, kernels.CROSS) < self.chance
        out = np.empty_like(a, order="C")
        if not self._cross_all(function, arguments, (a, b, swapped, crossed, keys, salt), out):
            np.copyto(out, np.where(swapped[:, None], b, a))
            other, mate, name = np.where(swapped[:, None], a, b), self.toolbox.mate, named(function)
            length = out.shape[1] if self.layout.longest is None else None
            with kept_random():
                for birth in np.flatnonzero(crossed):
                    random.seed(seed_of(keys[birth], MATE + 4 * salt))
                    pair = mate(self._letters(out[birth]), self._letters(other[birth]))
                    size = len(self.layout.alphabet)
                    self._take(out[birth], strings_of("mate", name, pair, length, size)[0])
        return out

    def _cross_all(
        self, function: Callable[..., Any], arguments: dict[str, Any], births: Births, out: np.ndarray
    ) -> bool:
        """Fill `out` with a kernel, if there is one for this operator."""
        from deap import tools

        if function in (tools.cxOnePoint, tools.cxTwoPoint):
            kernels.cross_points(*births, 1 if function is tools.cxOnePoint else 2, out)
        elif function is tools.cxUniform:
            kernels.cross_uniform(*births, np.float32(arguments["indpb"]), out)
        return function in (tools.cxOnePoint, tools.cxTwoPoint, tools.cxUniform)

    def _letters(self, string: np.ndarray) -> list[int]:
        return string.tolist()

    def _take(self, string: np.ndarray, letters: np.ndarray) -> None:
        string[:] = letters

    def _mutate(self, strings: np.ndarray, keys: np.ndarray, salt: int) -> None:
        function, arguments = self._operator("mutate")
        if self._loci is None or self._loci[0] is not self.toolbox.mutate:
            self._loci = (
                self.toolbox.mutate,
                self.layout.rates(arguments.get("indpb", 0.0)),
                *self._bounds(arguments),
            )
        _, rates, low, up = self._loci
        if (way := way_of(function)) is not None:
            kernels.mutate(strings, keys, salt, way, rates, low, up)
        else:
            self._mutate_each(strings, keys, salt, function, arguments)

    def _bounds(self, arguments: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
        """Return the lowest and the highest letter of each locus: i64[length] each."""
        n, highest = self.layout.length, len(self.layout.alphabet) - 1
        low, up = (
            np.atleast_1d(np.asarray(arguments.get(k, v), np.int64))[:n]
            for k, v in (("low", 0), ("up", highest))
        )
        return np.broadcast_to(low, n).copy(), np.broadcast_to(up, n).copy()

    def _mutate_each(
        self,
        strings: np.ndarray,
        keys: np.ndarray,
        salt: int,
        function: Callable[..., Any],
        arguments: dict[str, Any],
    ) -> None:
        """Mutate birth by birth; genes with their own mutation rates separately."""
        size, mutate, name = len(self.layout.alphabet), self.toolbox.mutate, named(function)
        rates = self.layout.rates(arguments.get("indpb", 0.0))
        lists = {k: v for k, v in arguments.items() if isinstance(v, list | tuple)}
        parts = [
            (at, {"indpb": float(rates[at[0]])} | {k: [v[i] for i in at] for k, v in lists.items()})
            for at in (np.flatnonzero(rates == r) for r in np.unique(rates))
        ]
        if all(code.gene.mutation_rate is None for code in self.layout.genes):
            parts = [(np.arange(strings.shape[1]), {})]
        with kept_random():
            for birth in range(len(strings)):
                random.seed(seed_of(keys[birth], MUTATE + 4 * salt))
                for loci, rate in parts:
                    mutated = mutate(strings[birth, loci].tolist(), **rate)
                    strings[birth, loci] = strings_of("mutate", name, mutated, loci.size, size)[0]


def way_of(function: Callable[..., Any]) -> int | None:
    """Return the number of the method by which an operator of DEAP mutates letters; None for any other."""
    from deap import tools

    ways = (tools.mutUniformInt, tools.mutFlipBit, tools.mutShuffleIndexes)
    return ways.index(function) if function in ways else None


def toss(keys: np.ndarray, salt: int, purpose: int) -> np.ndarray:
    """Return a draw for each birth: f32[k]."""
    out = np.empty(len(keys), np.float32)
    kernels.toss(keys, salt, purpose, out)
    return out


def seed_of(key: np.uint64, part: int) -> int:
    """Return the seed of Python's random numbers for a part of a birth."""
    return mix_int((int(key) + part) & ((1 << 64) - 1))


def named(function: object) -> str:
    """Return the name of an operator for messages."""
    return getattr(function, "__name__", repr(function))
