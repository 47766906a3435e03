"""Create children's genomes from their parents' genomes, in batches or one by one."""

import random
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.engine.random import mix_int
from ecs_eco.genomes import kernels
from ecs_eco.genomes.later import variable_kernels
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
from ecs_eco.genomes.unequal import UnequalCrossover
from ecs_eco.genomes.variable_layout import VariableLayout
from ecs_eco.inputs.code import handed_over

if TYPE_CHECKING:
    from deap.base import Toolbox

Births = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]
"""Both parents, whether they are swapped and crossed, keys, and a salt."""
MATE, MUTATE = 1, 2  # parts of a birth's key that seed Python's random number generator
WHOLE = slice(None)  # all loci of a string
EVENTS = ("crossing", "duplication", "loss", "insertion", "deletion")  # entries of at_limit


class Operators:
    """The operators of a DEAP toolbox, applied to all births in a tick at once.

    Parameters
    ----------
    toolbox : deap.base.Toolbox
        A toolbox with `mate` and `mutate`; `toolbox_of` creates one. Each birth uses the operators registered
        at that time.
    layout : Layout
    chance : float, default 1.0
        Probability of a crossover.
    mates : bool, default True
        Whether two parents' genomes are crossed; otherwise, `mate` is not checked.

    Attributes
    ----------
    mutation : bool
        Set this to False to switch mutation off.

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
        # the operator, and each locus' mutation probability, lowest and highest letter
        self._loci: tuple[Any, np.ndarray, np.ndarray, np.ndarray] | None = None
        self._seen: dict[str, tuple[Any, Callable[..., Any], dict[str, Any]]] = {}
        for word in ("mate", "mutate") if mates else ("mutate",):
            self._operator(word)

    @property
    def choice(self) -> int:
        """The index of the toolbox's `select_mate` in CHOICES; −1 for a user-defined function."""
        return choice_of(self.toolbox)

    @property
    def uses_random(self) -> bool:
        """Whether births use Python's random number generator, because an operator has no kernel."""
        ways = {"mate": self._crosses_all, "mutate": lambda function: way_of(function) is not None}
        return self.choice < 0 or not all(ways[word](self._operator(word)[0]) for word in self._seen)

    def offspring(self, first: np.ndarray, second: np.ndarray | None, keys: np.ndarray) -> np.ndarray:
        """Return the genomes of children.

        With one string, two parents are crossed in random order, and the child is the first of the two
        results; a single parent's genome is copied. With two strings, each parent contributes one string, a
        crossover of its two strings. Then the child mutates.

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
        """Return the function registered under a name and its arguments; check them the first time."""
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
                    child, _ = strings_of("mate", name, pair, length, len(self.layout.alphabet))
                    self._take(out[birth], WHOLE, child, None)
        return out

    def _cross_all(
        self, function: Callable[..., Any], arguments: dict[str, Any], births: Births, out: np.ndarray
    ) -> bool:
        """Fill `out` with this operator's kernel, if there is one; return whether there is."""
        from deap import tools

        if function in (tools.cxOnePoint, tools.cxTwoPoint):
            kernels.cross_points(*births, 1 if function is tools.cxOnePoint else 2, out)
        elif function is tools.cxUniform:
            kernels.cross_uniform(*births, np.float32(arguments["indpb"]), out)
        return self._crosses_all(function)

    def _crosses_all(self, function: Callable[..., Any]) -> bool:
        """Return whether a kernel replaces this crossover."""
        from deap import tools

        return function in (tools.cxOnePoint, tools.cxTwoPoint, tools.cxUniform)

    def _letters(self, string: np.ndarray) -> list[int]:
        return string.tolist()

    def _take(
        self, string: np.ndarray, loci: np.ndarray | slice, letters: np.ndarray, before: int | None
    ) -> None:
        """Write new letters to some loci of a string; `before` is the old number of letters there (None:
        crossover)."""
        string[loci] = letters

    def _mutate(self, strings: np.ndarray, keys: np.ndarray, salt: int) -> None:
        function, arguments = self._operator("mutate")
        if self._loci is None or self._loci[0] is not self.toolbox.mutate:
            rates = self.layout.rates(arguments.get("indpb", 0.0))
            self._loci = self.toolbox.mutate, rates, *self._bounds(arguments)
        _, rates, low, up = self._loci
        if (way := way_of(function)) is not None:
            kernels.mutate(strings, keys, salt, way, rates, low, up)
        else:
            self._mutate_each(strings, keys, salt, function, arguments)

    def _bounds(self, arguments: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
        """Return the lowest and the highest possible letter at each locus: i64[length] each."""
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
        """Mutate one birth at a time; genes with their own mutation rates are mutated separately."""
        size, mutate, name = len(self.layout.alphabet), self.toolbox.mutate, named(function)
        parts: list[tuple[np.ndarray | slice, dict[str, Any]]] = [(WHOLE, {})]
        fixed = self.layout.longest is None
        if fixed and any(code.gene.mutation_rate is not None for code in self.layout.genes):
            rates = self.layout.rates(arguments.get("indpb", 0.0))
            lists = {k: v for k, v in arguments.items() if isinstance(v, list | tuple)}
            parts = [
                (at, {"indpb": float(rates[at[0]])} | {k: [v[i] for i in at] for k, v in lists.items()})
                for at in (np.flatnonzero(rates == r) for r in np.unique(rates))
            ]
        with kept_random():
            for birth, string in enumerate(strings):
                random.seed(seed_of(keys[birth], MUTATE + 4 * salt))
                for loci, rate in parts:
                    letters = self._letters(string[loci])
                    before = len(letters)  # an operator can change the list
                    mutated = mutate(letters, **rate)
                    (after,) = strings_of("mutate", name, mutated, before if fixed else None, size)
                    self._take(string, loci, after, before)


class VariableOperators(Operators):
    """The operators of a toolbox for strings of variable length. Strings are crossed; genes are then
    duplicated or lost, and letters inserted or deleted, with the section's probabilities; finally, `mutate`
    is applied.

    A change that would make a string empty or longer than `longest` is skipped and counted in `at_limit`
    i64[5]: crossings, duplications, losses, insertions and deletions.
    """

    layout: VariableLayout

    def __init__(
        self,
        toolbox: "Toolbox",
        layout: VariableLayout,
        chance: float = 1.0,
        *,
        insertion: float = 0.0,
        deletion: float = 0.0,
        duplication: float = 0.0,
        loss: float = 0.0,
        mates: bool = True,
    ) -> None:
        self.insertion, self.deletion, self.duplication, self.loss = insertion, deletion, duplication, loss
        self.at_limit = np.zeros(len(EVENTS), np.int64)
        super().__init__(toolbox, layout, chance, mates)

    @property
    def genes(self) -> tuple[Any, ...]:
        """Return the parameters that kernels need to find genes: blank, words, word length, letters,
        spans."""
        layout = self.layout
        return layout.blank, layout.words, layout.word, len(layout.alphabet), layout.spans

    def _cross_all(
        self, function: Callable[..., Any], arguments: dict[str, Any], births: Births, out: np.ndarray
    ) -> bool:
        if not self._crosses_all(function):
            return False
        a, b = map(np.ascontiguousarray, births[:2])
        slip = np.float32(arguments["slip"])
        variable_kernels.cross_unequal(a, b, *births[2:], slip, *self.genes, self.at_limit, out)
        return True

    def _crosses_all(self, function: Callable[..., Any]) -> bool:
        return isinstance(function, UnequalCrossover)

    def _mutate(self, strings: np.ndarray, keys: np.ndarray, salt: int) -> None:
        letters = np.ascontiguousarray(strings)
        if self.duplication or self.loss:
            variable_kernels.rearrange(
                letters, keys, salt, float(self.duplication), float(self.loss), *self.genes, self.at_limit
            )
        if self.insertion or self.deletion:
            rates, blank = (float(self.insertion), float(self.deletion)), self.layout.blank
            size = len(self.layout.alphabet)
            variable_kernels.insert_and_delete(letters, keys, salt, *rates, blank, size, self.at_limit)
        self._mutate_letters(letters, keys, salt)
        if letters is not strings:
            strings[:] = letters

    def _mutate_letters(self, letters: np.ndarray, keys: np.ndarray, salt: int) -> None:
        function, arguments = self._operator("mutate")
        if (way := way_of(function)) is None:
            self._mutate_each(letters, keys, salt, function, arguments)
            return
        chance, low, up = (arguments.get(k, 0) for k in ("indpb", "low", "up"))
        given = letters, keys, salt, way, float(chance)
        if all(code.gene.mutation_rate is None for code in self.layout.genes):
            variable_kernels.mutate_letters(*given, int(low), int(up), self.layout.blank)
        else:
            variable_kernels.mutate_by_gene(
                *given, self.layout.rates(chance), int(low), int(up), *self.genes, self.layout.skipped
            )

    def _letters(self, string: np.ndarray) -> list[int]:
        return string[: variable_kernels.end_of(string, self.layout.blank)].tolist()

    def _take(
        self, string: np.ndarray, loci: np.ndarray | slice, letters: np.ndarray, before: int | None
    ) -> None:
        """Write new letters to a string, unless there are no letters or too many; count these cases."""
        if not 0 < letters.size <= string.size:
            event = "crossing" if before is None else "insertion" if letters.size > before else "deletion"
            self.at_limit[EVENTS.index(event)] += 1
            return
        string[: letters.size] = letters
        string[letters.size :] = self.layout.blank


def way_of(function: Callable[..., Any]) -> int | None:
    """Return the number of the mutation method that a DEAP operator uses; None for other operators."""
    from deap import tools

    ways = (tools.mutUniformInt, tools.mutFlipBit, tools.mutShuffleIndexes)
    return ways.index(function) if function in ways else None


def toss(keys: np.ndarray, salt: int, purpose: int) -> np.ndarray:
    """Return a draw for each birth: f32[k]."""
    out = np.empty(len(keys), np.float32)
    kernels.toss(keys, salt, purpose, out)
    return out


def seed_of(key: np.uint64, part: int) -> int:
    """Return the seed for Python's random number generator for one part of a birth."""
    return mix_int((int(key) + part) & ((1 << 64) - 1))


def named(function: object) -> str:
    """Return the name of an operator as shown in messages."""
    return getattr(function, "__name__", repr(function))


def operators_of(
    section: GenomeSection,
    layout: Layout,
    select_mate: str = "nearest",
    find: Callable[[Any], Any] = handed_over,
    mates: bool = True,
) -> Operators:
    """Return the operators for a world file's genome, with strings of fixed or variable length.

    Parameters
    ----------
    section : GenomeSection
    layout : Layout
        As returned by `layout_of`.
    select_mate, find, mates
        The same as for `toolbox_of`.

    Returns
    -------
    Operators

    Examples
    --------
    >>> from ecs_eco.genomes import Gene, layout_of, operators_of
    >>> from ecs_eco.genomes.models import GenomeSection
    >>> section = GenomeSection(genes=[Gene(name="size", letters=4, low=0.2, high=0.6)])
    >>> operators_of(section, layout_of(section)).mutation
    True
    """
    toolbox, chance = toolbox_of(section, layout, select_mate, find, mates), section.mate.chance
    if not isinstance(layout, VariableLayout):
        return Operators(toolbox, layout, chance, mates)
    return VariableOperators(
        toolbox,
        layout,
        chance,
        insertion=section.insertion,
        deletion=section.base_deletion,
        duplication=section.duplication,
        loss=section.gene_deletion,
        mates=mates,
    )
