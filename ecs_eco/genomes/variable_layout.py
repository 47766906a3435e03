"""The layout of genomes whose strings vary in length: genes are found by their promoters."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate
from typing import Any

import numpy as np

from ecs_eco.engine.errors import ConfigError
from ecs_eco.genomes.codes import Code, Weights
from ecs_eco.genomes.later import variable_kernels
from ecs_eco.genomes.layout import Layout
from ecs_eco.genomes.models import GenomeSection
from ecs_eco.genomes.promoters import copies_in, problems_of_variable, promoters_of, word_table
from ecs_eco.genomes.traits import Shapes, Trait

SEPARATORS = "|/;:,. "  # separators between the strings of a text; the first that is not a letter is used


class VariableLayout(Layout):
    """Genes on one or two strings of at most `longest` letters: a row u8[longest * ploidy] contains the
    letters of each string, then blanks (the number after the last letter's).

    Every row decodes to valid values: `doubled` determines how several copies of a gene combine; without a
    copy, the species' own value is used (0 for a neutral marker, zero weights for a network). Raises
    ConfigError.
    """

    longest: int

    def __init__(
        self,
        section: GenomeSection,
        traits: Mapping[str, Trait] | None = None,
        shapes: Mapping[str, Shapes] | None = None,
    ) -> None:
        if wrong := list(problems_of_variable(section, traits, shapes or {})):
            raise ConfigError(wrong, "invalid genome")
        super().__init__(
            section.genes, section.alphabet, section.ploidy, section.expression, None, traits, shapes
        )
        self.doubled, self.derived = section.copy_rule, section.derived
        self.length = self.longest = section.max_length or 0
        self.row = self.length * self.ploidy
        self.blank = self.highest = len(self.alphabet)
        self.separator = next(c for c in SEPARATORS + chr(0x2016) if c not in self.alphabet.letters)
        words = promoters_of(section.genes, section.alphabet)
        self.promoters = {code.name: word for code, word in zip(self.genes, words, strict=True)}
        self.words, self.word = word_table(words, section.alphabet), max(map(len, words))
        self.skipped = np.array([len(word) for word in words], np.int64)
        self.spans = self.skipped + [code.codons.length for code in self.genes]
        self.founder = [g for g, code in enumerate(self.genes) for _ in range(code.gene.copies)]
        self.begin = section.loci or int(self.spans[self.founder].sum())  # letters in a founder's string
        for code in self.genes:
            code.first = code.codons.first = 0
            code.stop = code.codons.length

    def table(self) -> list[dict[str, Any]]:
        """Return one row for each gene and each derived trait: gene, promoter, letters, trait, meaning,
        resolution."""
        rows = super().table()
        letters = {code.name: code.codons.length for code in self.genes}
        return [
            {
                "gene": row["gene"],
                "promoter": self.promoters.get(row["gene"], ""),
                "letters": letters.get(row["gene"], ""),
                **{k: v for k, v in row.items() if k not in ("gene", "loci")},
            }
            for row in rows
        ]

    # --- reading --------------------------------------------------------------------------------------------

    def copies(self, loci: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return all copies of genes in order: string, first letter of the promoter, gene; i64[copies] each."""
        strings = np.ascontiguousarray(self.check(loci)).reshape(-1, self.longest)
        n = np.empty(len(strings), np.int64)
        given = self.blank, self.words, self.word, len(self.alphabet), self.spans
        variable_kernels.count_copies(strings, *given, n)
        string, at, gene = (np.empty(int(n.sum()), np.int64) for _ in range(3))
        variable_kernels.find_copies(strings, *given, string, at, gene)
        return string, at, gene

    def copy_numbers(self, loci: np.ndarray) -> dict[str, np.ndarray]:
        """Return the number of copies of each gene in rows u8[n, row], over all strings: i64[n] by gene."""
        string, _, gene = self.copies(loci)
        return {
            code.name: np.bincount(string[gene == g] // self.ploidy, minlength=len(loci))
            for g, code in enumerate(self.genes)
        }

    def lengths(self, loci: np.ndarray) -> np.ndarray:
        """Return the number of letters in each string of rows u8[n, row]: i64[n, ploidy]."""
        ended = self.check(loci).reshape(len(loci), self.ploidy, self.longest) == self.blank
        lengths: np.ndarray = np.where(ended.any(axis=2), ended.argmax(axis=2), self.longest)
        return lengths

    def values_of(self, loci: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the string (row × ploidy + string) and the value of each copy of one gene."""
        return self._values(loci, self.copies(loci), self[name])

    def alleles(self, loci: np.ndarray, name: str) -> np.ndarray:
        """Return a gene's value in each string [n, ploidy, …]; without a copy, the species' own value."""
        code = self[name]
        value, has = self._by_string(loci, self.copies(loci), code)
        value[~has] = self.own_value(code)
        return value.reshape(len(loci), self.ploidy, *code.width).astype(code.dtype)

    def _values(
        self, loci: np.ndarray, found: tuple[np.ndarray, ...], code: Code
    ) -> tuple[np.ndarray, np.ndarray]:
        number = self.genes.index(code)
        string, at = (column[found[2] == number] for column in found[:2])
        places = (at + self.skipped[number])[:, None] + np.arange(code.codons.length)
        letters = loci.reshape(-1, self.longest)[string[:, None], places]
        return string, np.asarray(code.values(code.codons.read(letters, 0)), np.float64)

    def _by_string(
        self, loci: np.ndarray, found: tuple[np.ndarray, ...], code: Code
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the combined value of each string's copies f64[strings, …], and whether the string has any
        copies."""
        string, values = self._values(loci, found, code)
        out = np.zeros((len(loci) * self.ploidy, *code.width))
        has = np.zeros(len(out), np.bool_)
        if not string.size:
            return out, has
        begin = np.flatnonzero(np.diff(string, prepend=-1))
        has[string[begin]] = True
        how = code.gene.copy_rule or self.doubled
        if how == "first":
            out[string[begin]] = values[begin]
            return out, has
        together = (np.maximum if how == "greatest" else np.add).reduceat(values, begin)
        if how == "mean":
            number = np.diff(begin, append=string.size)
            together = together / number.reshape(-1, *[1] * len(code.width))
        elif how == "sum" and not (isinstance(code, Weights) and code.bases is not None):
            together = np.clip(together, code.low, code.high)
        out[string[begin]] = together
        return out, has

    def _expressed(self, code: Code, loci: np.ndarray, found: tuple[np.ndarray, ...]) -> np.ndarray:
        value, has = self._by_string(loci, found, code)
        if self.ploidy == 1:
            out, any_has = value, has
        else:
            (a, b), (has_a, has_b) = (
                x.reshape(len(loci), 2, *x.shape[1:]).swapaxes(0, 1) for x in (value, has)
            )
            how, any_has = code.gene.expression or self.expression, has_a | has_b
            both = {"first": a, "greater": np.maximum(a, b), "mean": (a + b) / 2}[how]
            a_only, b_only = (h.reshape(-1, *[1] * len(code.width)) for h in (has_a & ~has_b, has_b & ~has_a))
            out = np.where(a_only, a, np.where(b_only, b, both))
        out[~any_has] = self.own_value(code)
        return np.rint(out) if code.dtype is np.int32 else out

    def rates(self, chance: float) -> np.ndarray:
        """Return each gene's mutation probability per letter f64[genes]: its own, or `chance`."""
        return np.array(
            [chance if code.gene.mutation_rate is None else code.gene.mutation_rate for code in self.genes],
            np.float64,
        )

    def _places(self, order: Sequence[int]) -> list[tuple[int, Code]]:
        """Return the start of the letters after each copy's promoter; raise a ValueError if there are too
        many."""
        if (needed := int(self.spans[order].sum())) > self.longest:
            raise ValueError(f"genome: these genes need {needed} letters; expected {self.longest}")
        ends = accumulate(int(self.spans[g]) for g in order)
        return [
            (end - self.genes[g].codons.length, self.genes[g]) for g, end in zip(order, ends, strict=True)
        ]

    def _write(self, out: np.ndarray, place: int, code: Code, numbers: np.ndarray | None) -> None:
        """Write a promoter that ends at `place`, then the numbers of its codons."""
        word = self.alphabet.encode(self.promoters[code.name])
        for first in range(0, self.row, self.longest):
            out[:, first + place - word.size : first + place] = word
        super()._write(out, place, code, numbers)

    # --- texts ----------------------------------------------------------------------------------------------

    def text(self, row: np.ndarray) -> str:
        """Return one genome u8[row] as text: its strings, joined by a separator."""
        (ends,) = self.lengths(np.asarray(row)[None])
        return self.separator.join(
            self.alphabet.decode(row[s * self.longest : s * self.longest + end]) for s, end in enumerate(ends)
        )

    def joined(self, loci: np.ndarray) -> np.ndarray:
        """Return the letters of rows u8[n, row] in the form used in texts: u8[n, row + ploidy − 1], where
        `blank` marks unused positions and blank + 1 is the separator."""
        out = np.empty((len(loci), self.row + self.ploidy - 1), np.uint8)
        strings = np.ascontiguousarray(loci).reshape(-1, self.longest)
        variable_kernels.join_strings(strings, self.blank, self.ploidy, out)
        return out

    def rows(self, texts: Sequence[str]) -> np.ndarray:
        """Return the rows u8[n, row] of texts; raise ValueError if the number of strings is wrong."""
        out = np.full((len(texts), self.row), self.blank, np.uint8)
        for i, text in enumerate(texts):
            strings = self._strings(text)
            if len(strings) != self.ploidy or max(map(len, strings)) > self.longest:
                allowed = f"{self.ploidy} of at most {self.longest} letters, with {self.separator!r} between"
                raise ValueError(
                    f"genome {text[:40]!r}: strings of {[len(s) for s in strings]} letters; "
                    f"expected {allowed}"
                )
            for s, string in enumerate(strings):
                out[i, s * self.longest : s * self.longest + len(string)] = self.alphabet.encode(string)
        return out

    def _strings(self, text: str) -> list[str]:
        return text.split(self.separator)

    def _genes_in(self, string: str) -> Iterable[tuple[str, int, int]]:
        spans = {code.name: int(span) for code, span in zip(self.genes, self.spans, strict=True)}
        return ((name, at, at + spans[name]) for name, at in copies_in(string, self.promoters, spans))


def layout_of(
    section: GenomeSection,
    traits: Mapping[str, Trait] | None = None,
    shapes: Mapping[str, Shapes] | Shapes | None = None,
) -> Layout:
    """Return the layout of a world file's genome, of fixed or variable length.

    Parameters
    ----------
    section : GenomeSection
    traits : Mapping of str to Trait, optional
        Values that genes can code for; default: any name.
    shapes : Mapping or sequence, optional
        Shapes of networks by trait; a sequence contains the shapes of policy.weights.

    Returns
    -------
    Layout

    Raises
    ------
    ConfigError
        If there are problems with the genes; the error lists all of them.

    Examples
    --------
    >>> from ecs_eco.genomes import Gene, layout_of
    >>> from ecs_eco.genomes.models import GenomeSection
    >>> section = GenomeSection(genes=[Gene(name="size", letters=4, low=0.2, high=0.6)], ploidy=2)
    >>> layout_of(section).row
    8
    """
    if shapes is not None and not isinstance(shapes, Mapping):
        shapes = {"policy.weights": shapes}
    if section.max_length is not None:
        return VariableLayout(section, traits, shapes)
    layout = Layout(
        section.genes, section.alphabet, section.ploidy, section.expression, section.loci, traits, shapes
    )
    layout.derived = section.derived
    return layout
