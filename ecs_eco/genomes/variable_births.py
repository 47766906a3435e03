"""Births with strings of variable length: crossover at genes, duplications, losses, insertions and
deletions."""

import random
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.genomes import variable_kernels
from ecs_eco.genomes.batch import MUTATE, Births, Operators, named, seed_of, way_of
from ecs_eco.genomes.layout import Layout
from ecs_eco.genomes.models import GenomeSection
from ecs_eco.genomes.operators import kept_random, strings_of, toolbox_of
from ecs_eco.genomes.unequal import UnequalCrossover
from ecs_eco.genomes.variable_layout import VariableLayout
from ecs_eco.inputs.code import handed_over

if TYPE_CHECKING:
    from deap.base import Toolbox

EVENTS = ("crossing", "duplication", "loss", "insertion", "deletion")


class VariableOperators(Operators):
    """The operators of a toolbox for strings of variable length. Strings are crossed; then genes are
    duplicated and lost and letters inserted and deleted with the probabilities of the section; then `mutate`
    is applied.

    A change that would make a string longer than `longest`, or empty, does not happen: `at_limit` i64[5]
    counts such crossings, duplications, losses, insertions and deletions.
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

    @classmethod
    def from_config(
        cls,
        section: GenomeSection,
        layout: Any,
        select_mate: str = "nearest",
        find: Callable[[Any], Any] = handed_over,
        mates: bool = True,
    ) -> "VariableOperators":
        return cls(
            toolbox_of(section, layout, select_mate, find, mates),
            layout,
            section.mate.chance,
            insertion=section.insertion,
            deletion=section.base_deletion,
            duplication=section.duplication,
            loss=section.gene_deletion,
            mates=mates,
        )

    @property
    def genes(self) -> tuple[Any, ...]:
        """Return the parameters by which kernels find genes: blank, words, their length, letters, spans."""
        layout = self.layout
        return layout.blank, layout.words, layout.word, len(layout.alphabet), layout.spans

    def _cross_all(
        self, function: Callable[..., Any], arguments: dict[str, Any], births: Births, out: np.ndarray
    ) -> bool:
        if not isinstance(function, UnequalCrossover):
            return False
        a, b = map(np.ascontiguousarray, births[:2])
        slip = np.float32(arguments["slip"])
        variable_kernels.cross_unequal(a, b, *births[2:], slip, *self.genes, self.at_limit, out)
        return True

    def _mutate(self, strings: np.ndarray, keys: np.ndarray, salt: int) -> None:
        letters = np.ascontiguousarray(strings)
        size = len(self.layout.alphabet)
        if self.duplication or self.loss:
            variable_kernels.rearrange(
                letters, keys, salt, float(self.duplication), float(self.loss), *self.genes, self.at_limit
            )
        if self.insertion or self.deletion:
            variable_kernels.insert_and_delete(
                letters,
                keys,
                salt,
                float(self.insertion),
                float(self.deletion),
                self.layout.blank,
                size,
                self.at_limit,
            )
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

    def _mutate_each(
        self,
        strings: np.ndarray,
        keys: np.ndarray,
        salt: int,
        function: Callable[..., Any],
        arguments: dict[str, Any],
    ) -> None:
        mutate, name = self.toolbox.mutate, named(function)
        lengths = (strings != self.layout.blank).sum(axis=1)
        with kept_random():
            for birth in range(len(strings)):
                random.seed(seed_of(keys[birth], MUTATE + 4 * salt))
                mutated = mutate(self._letters(strings[birth]))
                (string,) = strings_of("mutate", name, mutated, None, self.layout.blank)
                grows = string.size > lengths[birth]
                event = variable_kernels.INSERTION if grows else variable_kernels.DELETION
                self._take(strings[birth], string, event)

    def _letters(self, string: np.ndarray) -> list[int]:
        return string[: variable_kernels.end_of(string, self.layout.blank)].tolist()

    def _take(self, string: np.ndarray, letters: np.ndarray, event: int = variable_kernels.CROSSING) -> None:
        """Write new letters into a string, unless they are none or too many, which is counted."""
        if not 0 < letters.size <= string.size:
            self.at_limit[event] += 1
            return
        string[: letters.size] = letters
        string[letters.size :] = self.layout.blank


def operators_of(
    section: GenomeSection,
    layout: Layout,
    select_mate: str = "nearest",
    find: Callable[[Any], Any] = handed_over,
    mates: bool = True,
) -> Operators:
    """Return the operators of the genome of a world file, for strings of fixed or of variable length.

    Parameters
    ----------
    section : GenomeSection
    layout : Layout
        As `layout_of` returns it.
    select_mate, find, mates
        As for `toolbox_of`.

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
    kind = VariableOperators if isinstance(layout, VariableLayout) else Operators
    return kind.from_config(section, layout, select_mate, find, mates)
