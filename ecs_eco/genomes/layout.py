"""The layout of a genome: which loci code for which values, for decoding and encoding."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from ecs_eco.engine.errors import ConfigError, Problem, UnknownName, listed, unknown_name
from ecs_eco.genomes.alphabet import Alphabet
from ecs_eco.genomes.codes import Code, Codons, Listed, Range, Weights
from ecs_eco.genomes.later import kernels
from ecs_eco.genomes.models import Derived, Expression, Gene
from ecs_eco.genomes.problems import is_weights, n_codons, places, problems, shapes_of
from ecs_eco.genomes.traits import Shapes, Trait


class Piece(NamedTuple):
    """A piece of a genome's text: its string, gene ("" if neutral), first locus and letters."""

    string: int
    gene: str
    first: int
    letters: str


class Layout:
    """The mapping between loci and values. Every row of letters decodes to valid values.

    Parameters
    ----------
    genes : sequence of Gene
    alphabet : str or Alphabet, default "ACGT"
    ploidy : {1, 2}
        Strings per organism. A row of loci contains the first string, then the second.
    expression : {"first", "mean", "greater"}
        Value for two alleles: the first string's value, the mean, or the greater one.
    loci : int, optional
        Length of a string; default: the total length of all genes. Loci that no gene uses are neutral.
    traits : Mapping of str to Trait, optional
        Values that genes can code for; default: any name.
    shapes : Mapping, optional
        Shapes of networks' matrices, by trait or gene.

    Raises
    ------
    ConfigError
        If there are problems with the genes; the error lists all of them.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.genomes import Gene, Layout
    >>> layout = Layout([Gene(name="speed", trait="speed", letters=3, low=0.0, high=63.0)])
    >>> layout.decode(layout.rows(["AAA", "AAC", "TTT"]))["speed"].tolist()
    [0.0, 1.0, 63.0]
    >>> layout.alleles(layout.rows(["AAC"]), "speed").tolist(), layout.table()[0]["gene"]
    ([[1.0]], 'speed')
    >>> len(layout.text(layout.random(np.array([7], np.uint64))[0]))
    3
    """

    longest: int | None = None
    """Maximum number of letters in a string; None: strings keep their length."""
    doubled = "first"
    """How several copies of a gene in a string are combined, if strings vary in length."""
    blank = 0
    """The number for unused positions."""

    derived: Mapping[str, Derived] = MappingProxyType({})
    """Traits that are formulas of genes and have no letters, as listed in the section."""

    def __init__(
        self,
        genes: Sequence[Gene],
        alphabet: str | Alphabet = "ACGT",
        ploidy: Literal[1, 2] = 1,
        expression: Expression = "first",
        loci: int | None = None,
        traits: Mapping[str, Trait] | None = None,
        shapes: Mapping[str, Shapes] | None = None,
        dominance: Expression | None = None,  # the former name of expression
    ) -> None:
        expression = dominance or expression
        self.alphabet = alphabet if isinstance(alphabet, Alphabet) else Alphabet(alphabet)
        shapes, size = shapes or {}, len(self.alphabet)
        wrong = list(problems(genes, size, loci, traits, shapes))
        for key, value, allowed in (
            ("ploidy", ploidy, (1, 2)),
            ("expression", expression, get_args(Expression)),
        ):
            if value not in allowed:
                wrong.append(Problem((key,), "not possible", value, listed(allowed)))
        if wrong:
            raise ConfigError(wrong, "invalid genome")
        self.ploidy, self.expression = ploidy, expression
        at = places(genes, traits or {}, shapes) or []
        self.genes = tuple(
            _code(gene, first, size, (traits or {}).get(gene.trait or ""), shapes)
            for gene, (first, _) in zip(genes, at, strict=True)
        )
        self.length = self.begin = loci or max(stop for _, stop in at)  # of a string, and of a founder's
        self.founder = list(range(len(self.genes)))  # the genes of a founder's string, in order
        self.row = self.length * ploidy  # letters per organism
        self.highest = len(self.alphabet) - 1  # numbers in a row
        self._by_name = {code.name: code for code in self.genes}

    def __getitem__(self, name: str) -> Code:
        """Return the gene with this name. Raises UnknownName."""
        if name not in self._by_name:
            raise UnknownName(unknown_name("genome", "gene", name, self._by_name))
        return self._by_name[name]

    def __str__(self) -> str:
        rows = [list(self.table()[0]), *([str(v) for v in row.values()] for row in self.table())]
        widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
        return "\n".join(
            "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows
        )

    def table(self) -> list[dict[str, Any]]:
        """Return one row for each gene and each derived trait.

        Returns
        -------
        list of dict
            gene, loci, trait, meaning and resolution; `print(layout)` prints them.
        """
        out = []
        for code in self.genes:
            unit = code.trait.unit if code.trait and code.trait.unit not in ("1", "own") else ""
            fine = f"{code.resolution:.3g} {unit}".strip() if code.resolution else "exact"
            out.append(
                {
                    "gene": code.name,
                    "loci": f"{code.first}-{code.stop - 1}",
                    "trait": code.gene.trait or "none",
                    "codes for": code.text,
                    "resolution": fine,
                }
            )
        return out + [
            {"gene": name, "loci": "", "trait": one.trait, "codes for": one.formula, "resolution": ""}
            for name, one in self.derived.items()
        ]

    def decode(self, loci: np.ndarray, names: Collection[str] | None = None) -> dict[str, np.ndarray]:
        """Return the values that genomes code for.

        Parameters
        ----------
        loci : array of uint8, shape (n, row)
        names : collection of str, optional
            Genes to decode; default: all genes.

        Returns
        -------
        dict of str to array
            By gene: float32, or int32 for integers, shape (n,); (n, weights) for networks.

        Raises
        ------
        ValueError
            If the array has the wrong shape or type.

        Examples
        --------
        >>> import numpy as np
        >>> from ecs_eco.genomes import Gene, Layout
        >>> layout = Layout([Gene(name="size", trait="size", letters=4, low=0.2, high=0.6)])
        >>> sizes = layout.decode(layout.random(np.arange(100, dtype=np.uint64)))["size"]
        >>> bool((sizes >= 0.2).all() and (sizes <= 0.6).all())
        True
        """
        found = self.copies(self.check(loci))
        wanted = self.genes if names is None else [code for code in self.genes if code.name in names]
        return {code.name: self._expressed(code, loci, found).astype(code.dtype) for code in wanted}

    def alleles(self, loci: np.ndarray, name: str) -> np.ndarray:
        """Return the value of one gene in each string, before dominance.

        Parameters
        ----------
        loci : array of uint8, shape (n, row)
        name : str
            Name of the gene.

        Returns
        -------
        array, shape (n, ploidy, …)

        Raises
        ------
        UnknownName
            If a gene is unknown.
        """
        code, loci = self[name], self.check(loci)
        return np.stack(
            [code.values(code.codons.read(loci, s * self.length)) for s in range(self.ploidy)], axis=1
        ).astype(code.dtype)

    def encode(self, values: Mapping[str, Any], clip: bool = False) -> np.ndarray:
        """Return genomes that code for given values; both strings are the same, and neutral loci are 0.

        Parameters
        ----------
        values : Mapping of str to float or array, shape (n,)
            By gene. Neutral markers are optional.
        clip : bool, default False
            Whether values beyond a gene's range are replaced with the nearest valid value.

        Returns
        -------
        array of uint8, shape (n, row)
            `decode` returns each value to within half the gene's resolution.

        Raises
        ------
        ValueError
            If a value is missing or beyond a gene's range.
        UnknownName
            If a gene is unknown.

        Examples
        --------
        >>> from ecs_eco.genomes import Gene, Layout
        >>> layout = Layout([Gene(name="speed", trait="speed", letters=3, low=0.0, high=63.0)])
        >>> layout.text(layout.encode({"speed": 4.0})[0])
        'ACA'
        """
        arrays, n = self._arrays(values)
        out = np.full((n, self.row), self.blank, np.uint8)
        for place, code in self._places([g for g, c in enumerate(self.genes) if c.name in arrays]):
            numbers = np.broadcast_to(code.numbers(arrays[code.name], clip), (n, code.codons.n))
            self._write(out, place, code, numbers)
        return out

    def copies(self, loci: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return the copies of genes in rows u8[n, row]: an empty tuple, because genes have fixed positions."""
        return ()

    def _places(self, order: Sequence[int]) -> list[tuple[int, Code]]:
        """Return the first codon position of each gene in a string of these genes."""
        return [(self.genes[g].first, self.genes[g]) for g in order]

    def _write(self, out: np.ndarray, place: int, code: Code, numbers: np.ndarray | None) -> None:
        """Write the numbers of a gene's codons to each string, starting at `place`."""
        if numbers is not None:
            for first in range(0, self.row, self.length):
                code.codons.write(numbers, out, first + place - code.first)

    def _arrays(self, values: Mapping[str, Any]) -> tuple[dict[str, np.ndarray], int]:
        """Return the values of genes by name, and the number of organisms. Raises the same errors as
        `encode`."""
        for name in values:
            self[name]
        arrays = {
            code.name: self._array(code, values)
            for code in self.genes
            if code.name in values or code.gene.trait
        }
        n = max((len(a) for a in arrays.values()), default=1)
        wrong = next((name for name, a in arrays.items() if len(a) not in (1, n)), None)
        if wrong is not None:
            raise ValueError(
                f"gene {wrong!r}: {len(arrays[wrong])} values, but another gene has {n}; expected 1 or {n}"
            )
        return arrays, n

    def own(self, n: int = 1) -> np.ndarray:
        """Return identical genomes that code for the species' own values; all other letters are random.

        Parameters
        ----------
        n : int, default 1

        Returns
        -------
        array of uint8, shape (n, row)

        Raises
        ------
        ValueError
            If no codon of a gene represents the species' own value.

        Examples
        --------
        >>> from ecs_eco import World
        >>> from ecs_eco.genomes import Gene, layout_of
        >>> from ecs_eco.genomes.models import GenomeSection
        >>> layout = layout_of(GenomeSection(genes=[Gene(name="size", letters=4, low=0.2, high=0.6)]))
        >>> layout.own(2).shape
        (2, 4)
        """
        out = self.random(np.zeros(n, np.uint64))
        for code, begins in self._of_values():
            numbers = np.broadcast_to(
                code.numbers(np.array([self.own_value(code)]), clip=False), (n, code.codons.n)
            )
            for begin in begins:
                code.codons.write(numbers, out, begin - code.first)
        return out

    def coded(self) -> np.ndarray:
        """Return which letters code for a value of the species, excluding networks: bool[loci]."""
        out = np.zeros(self.row, np.bool_)
        for code, begins in self._of_values():
            for begin in begins:
                out[begin : begin + code.codons.length] = True
        return out

    def begins(self, code: Code) -> list[int]:
        """Return the positions in a founder's row at which a gene's codons begin, in each string."""
        return [begin for one, begins in self._founder() if one is code for begin in begins]

    def own_value(self, code: Code) -> float:
        """Return the value used if there is no copy of a gene: the species' own value, or 0 if it has no
        trait."""
        return 0.0 if code.trait is None else float(code.trait.default)

    def _founder(self) -> list[tuple[Code, list[int]]]:
        """Return the genes of a founder, each with the start of its codons in each string."""
        strings = range(0, self.row, self.length)
        return [(code, [s + place for s in strings]) for place, code in self._places(self.founder)]

    def _of_values(self) -> list[tuple[Code, list[int]]]:
        """Return the genes that code for a value of the species, with the starts of their codons."""
        return [(c, at) for c, at in self._founder() if c.trait is not None and not isinstance(c, Weights)]

    def random(self, keys: np.ndarray) -> np.ndarray:
        """Return genomes of founders, with letters drawn uniformly.

        If strings vary in length, each gene has as many copies as its key `copies` specifies; promoters are
        fixed, and all other letters up to `loci` are drawn.

        Parameters
        ----------
        keys : array of uint64, shape (n,)
            Equal keys give identical genomes.

        Returns
        -------
        array of uint8, shape (n, row)
        """
        drawn = np.empty((len(keys), self.ploidy * self.begin), np.uint8)
        kernels.letters_of(np.asarray(keys, np.uint64), len(self.alphabet), drawn)
        out = np.full((len(keys), self.row), self.blank, np.uint8)
        strings = out.reshape(len(keys), self.ploidy, self.length)
        strings[:, :, : self.begin] = drawn.reshape(len(keys), self.ploidy, self.begin)
        for place, code in self._places(self.founder):
            self._write(out, place, code, None)
        return out

    def rates(self, chance: float) -> np.ndarray:
        """Return each locus' mutation probability f32[length]: the gene's, or `chance`."""
        out = np.full(self.length, chance, np.float32)
        for code in self.genes:
            if code.gene.mutation_rate is not None:
                out[code.first : code.stop] = code.gene.mutation_rate
        return out

    def text(self, row: np.ndarray) -> str:
        """Return one genome as text.

        Parameters
        ----------
        row : array of uint8, shape (row,)

        Returns
        -------
        str
        """
        return self.alphabet.decode(row)

    def rows(self, texts: Sequence[str]) -> np.ndarray:
        """Return genomes from texts.

        Parameters
        ----------
        texts : sequence of str

        Returns
        -------
        array of uint8, shape (n, row)

        Raises
        ------
        ValueError
            If a text has the wrong length or letters outside the alphabet.
        """
        return self.check(
            np.stack([self.alphabet.encode(text) for text in texts])
            if texts
            else np.zeros((0, self.row), np.uint8)
        )

    def mark(self, genome: str | np.ndarray) -> list[Piece]:
        """Return the pieces of one genome in order: its genes and the neutral parts between them.

        Parameters
        ----------
        genome : str or array of uint8, shape (row,)

        Returns
        -------
        list of Piece

        Examples
        --------
        >>> from ecs_eco.genomes import Gene, Layout
        >>> layout = Layout([Gene(name="speed", trait="speed", letters=2, low=0.0, high=1.0)], loci=4)
        >>> [(piece.gene, piece.letters) for piece in layout.mark("ACGT")]
        [('speed', 'AC'), ('', 'GT')]
        """
        text = genome if isinstance(genome, str) else self.text(genome)
        self.rows([text])
        pieces = []
        for s, string in enumerate(self._strings(text)):
            at = 0
            for name, first, stop in self._genes_in(string):
                if first > at:
                    pieces.append(Piece(s, "", at, string[at:first]))
                pieces.append(Piece(s, name, first, string[first:stop]))
                at = stop
            if at < len(string):
                pieces.append(Piece(s, "", at, string[at:]))
        return pieces

    def _strings(self, text: str) -> list[str]:
        """Return the strings in a genome's text."""
        return [text[at : at + self.length] for at in range(0, self.row, self.length)]

    def _genes_in(self, string: str) -> Iterable[tuple[str, int, int]]:
        """Return the genes of a string in order: name, start and end of each."""
        return [(code.name, code.first, code.stop) for code in sorted(self.genes, key=lambda c: c.first)]

    def check(self, loci: np.ndarray) -> np.ndarray:
        """Return rows unchanged. Raises ValueError if their width, type or numbers are invalid."""
        highest = self.highest
        if (
            not isinstance(loci, np.ndarray)
            or loci.dtype != np.uint8
            or loci.ndim != 2
            or loci.shape[1] != self.row
        ):
            kind, shape = getattr(loci, "dtype", type(loci).__name__), np.shape(loci)
            raise ValueError(
                f"genome: an array of {kind} with shape {shape}; expected rows of u8[n, {self.row}]"
            )
        if highest < 255 and loci.size and loci.max() > highest:
            row, place = np.argwhere(loci > highest)[0]
            raise ValueError(
                f"genome {row}: {loci[row, place]} at position {place} is not the number of a letter; expected "
                f"0 to {highest}"
            )
        return loci

    def _expressed(self, code: Code, loci: np.ndarray, found: tuple[np.ndarray, ...]) -> np.ndarray:
        """Return the values of a gene; `found` is the result of `copies`."""
        first = code.values(code.codons.read(loci, 0))
        if self.ploidy == 1 or (how := code.gene.expression or self.expression) == "first":
            return first
        second = code.values(code.codons.read(loci, self.length))
        if how == "greater":
            return np.maximum(first, second)
        mean = (first + second) / 2
        return np.rint(mean) if code.dtype is np.int32 else mean

    def _array(self, code: Code, values: Mapping[str, Any]) -> np.ndarray:
        if code.name not in values:
            raise ValueError(f"gene {code.name!r}: no value; values are given for {listed(values)}")
        array = np.asarray(values[code.name], np.float64)
        rows = array if array.ndim > len(code.width) else array[None]
        if rows.shape[1:] != code.width:
            allowed = ", ".join(["n", *map(str, code.width)])
            raise ValueError(f"gene {code.name!r}: values have shape {array.shape}; expected ({allowed})")
        if not np.isfinite(rows).all():
            raise ValueError(f"gene {code.name!r}: a value is not finite")
        return rows


def _code(gene: Gene, first: int, size: int, trait: Trait | None, shapes: Mapping[str, Shapes]) -> Code:
    codons = Codons(gene, first, n_codons(gene, trait, shapes) or 0, size)
    if is_weights(gene, trait):
        return Weights(gene, trait, codons, shapes_of(gene, shapes) or [])
    return Range(gene, trait, codons) if gene.values is None else Listed(gene, trait, codons)
