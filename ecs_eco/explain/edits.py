"""Changes to living organisms: an allele is replaced by another one, or what an organism learned is undone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ecs_eco.components import Body, Experience, Genome, Instincts, Policy, Reflexes, Traits
from ecs_eco.engine.errors import UnknownName, listed, unknown_name
from ecs_eco.engine.table import Table
from ecs_eco.genomes.codes import Weights
from ecs_eco.genomes.heredity import hidden_units
from ecs_eco.genomes.layout import Layout
from ecs_eco.genomes.variable_layout import VariableLayout
from ecs_eco.life import sizes

OF_GENOME = ("letter", "value", "copies", "haplotype")
KINDS = (*OF_GENOME, "policy", "reflex")


class AlleleLike(Protocol):
    """Anything that names an allele, such as the alleles that `ecs_eco.explain` finds in a run."""

    @property
    def species(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def gene(self) -> str: ...
    @property
    def locus(self) -> int: ...
    @property
    def value(self) -> str: ...


@dataclass(frozen=True)
class Edit:
    """A change that can be made to each carrier of an allele.

    Parameters
    ----------
    species : str
    kind : {"letter", "value", "copies", "haplotype", "policy", "reflex"}
        A letter at a locus of each string, the value of a gene, a number of copies of a gene (variable-length
        genomes), a whole string, the weights that an organism has learned, or a reflex.
    gene : str, default ""
        Name of the gene; for a reflex, the name of the connection, or "" for the whole reflex.
    locus : int, default -1
        Locus of the letter, counted from 0 in each string.
    value : str, default ""
        The allele. Of copies, "3 or more" or "3 or fewer"; "3" means the latter if `was` is larger.
    was : str, default ""
        What replaces it.
    reverse : bool, default False
        Whether organisms without the allele receive it instead. All their strings receive it.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.explain.edits import Edit
    >>> goats = World.from_config("reflexes", seed=1, record=False).table("goat")
    >>> edit = Edit("goat", "letter", "red", 0, "T", "A")
    >>> rows, dose = edit.carriers(goats)
    >>> edit.apply(goats, rows)
    >>> edit.carriers(goats)[0].size
    0
    """

    species: str
    kind: str
    gene: str = ""
    locus: int = -1
    value: str = ""
    was: str = ""
    reverse: bool = False

    def carriers(
        self, table: Table, known: Mapping[int, np.ndarray] | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the rows i64[n] of the living organisms that can be changed, in uid order, and how many
        strings or copies would change in each, i64[n].

        `known` contains weights at birth by uid, for the kind "policy". Raises ValueError or KeyError for a
        change that is not possible in this species.
        """
        rows = table.by_uid()
        if self.kind == "policy":
            _need(
                Policy in table,
                f"{table.name!r} has no individual policies, so nothing that each organism learned can be undone",
            )
            has = np.isin(table.uid[rows], np.array(list(known or ()), np.uint64)).astype(np.int64)
        elif self.kind == "reflex":
            parts = [column[rows][:, which] != 0 for column, which in self._reflexes(table)]
            has = np.asarray(np.concatenate(parts, axis=1).any(axis=1), np.int64)
        else:
            layout = layout_of(table)
            loci = table[Genome].loci[rows]
            self._check(layout)
            has = self._number(layout, loci)
            if self.kind == "copies":
                has = self._copies_to_change(layout, loci, has)
            elif self.reverse:
                has = np.where(has == 0, layout.ploidy, 0)
        return rows[has > 0], has[has > 0]

    def apply(self, table: Table, rows: np.ndarray, known: Mapping[int, np.ndarray] | None = None) -> None:
        """Change the organisms in rows i64[k], and nothing else; call this between ticks."""
        if not rows.size:
            return
        if self.kind == "policy":
            p = table[Policy]
            p.weights[rows] = np.stack([(known or {})[uid] for uid in table.uid[rows].tolist()])
            p.moment_1[rows], p.moment_2[rows], p.steps[rows] = 0, 0, 0
            if Experience in table:
                table[Experience].length[rows] = 0  # its transitions belong to other weights
        elif self.kind == "reflex":
            for column, which in self._reflexes(table):
                weights = column[rows]
                weights[:, which] = 0
                column[rows] = weights
        else:
            loci = table[Genome].loci[rows]
            rewrite(table, rows, loci, self._edited(layout_of(table), loci.copy()))

    def alternative(self, table: Table) -> str:
        """Return what replaces the allele if `was` is not given: the most common other letter, value, string
        or number of copies among the living. Raises ValueError if there is none."""
        if self.kind not in OF_GENOME:
            return ""
        layout = layout_of(table)
        self._check(layout, None)
        loci = table[Genome].loci[table.by_uid()]
        if self.kind == "letter":
            found = [layout.alphabet.letters[i] for i in loci[:, self._columns(layout)].ravel()]
        elif self.kind == "value":
            found = [f"{v:g}" for v in self._values(layout, loci)[3]]
        elif self.kind == "copies":
            (k, way), numbers = limit_of(self.value), self._number(layout, loci).tolist()
            found = [str(n) for n in numbers if n != k and way in ("", "fewer" if n > k else "more")]
        else:
            strings = loci.reshape(-1, layout.length)
            none = layout.blank if layout.longest else -1
            found = [layout.alphabet.decode(row[row != none]) for row in strings]
        others, n = np.unique([word for word in found if word != self._name()], return_counts=True)
        _need(
            n.size > 0,
            f"all {table.name} carry {self._name()}: choose an earlier tick, or what replaces it (was)",
        )
        return str(others[n.argmax()])

    # --- genomes --------------------------------------------------------------------------------------------

    def _name(self) -> str:
        return f"{_number(self.value):g}" if self.kind == "value" else self.value

    def _check(self, layout: Layout, was: str | None = "") -> None:
        """Raise ValueError or KeyError if the genome has no such locus, gene or letter."""
        fixed = not isinstance(layout, VariableLayout)
        same = was is not None and not self.reverse and self.was == self.value
        _need(not same, f"{self.kind} {self.value!r} would be replaced by itself")
        if self.kind in ("value", "copies"):
            weights = isinstance(layout[self.gene], Weights) and self.kind == "value"
            _need(not weights, f"gene {self.gene!r}: network weights have no single value")
        if self.kind == "copies":
            _need(not fixed, f"gene {self.gene!r}: only variable-length genomes have copies (max_length)")
            k, way = limit_of(self.value)
            wrong = self.was and way and (int(self.was) > k) != (way == "fewer")
            _need(not wrong, f"{self.was} copies cannot replace {self.value}")
        words = [self.value] if was is None or self.reverse else [self.value, self.was]
        if self.kind == "letter":
            _need(
                fixed, "loci are not comparable in variable-length genomes; choose a gene's value or copies"
            )
            last = layout.length - 1
            _need(0 <= self.locus <= last, f"locus = {self.locus}; expected 0 to {last}")
            _need(all(len(word) == 1 for word in words), f"letters = {words}; expected one letter each")
        if self.kind in ("letter", "haplotype"):
            for word in words:
                layout.alphabet.encode(word)

    def _columns(self, layout: Layout) -> np.ndarray:
        return self.locus + layout.length * np.arange(layout.ploidy)

    def _number(self, layout: Layout, loci: np.ndarray) -> np.ndarray:
        """Return how many strings or copies of each genome u8[n, row] have the allele: i64[n]."""
        n = len(loci)
        if self.kind == "letter":
            has = loci[:, self._columns(layout)] == layout.alphabet.encode(self.value)[0]
        elif self.kind == "haplotype":
            has = (loci.reshape(n, -1, layout.length) == _string(layout, self.value)).all(axis=2)
        elif self.kind == "value":
            string, *_, values = self._values(layout, loci)
            return np.bincount(string[_same(values, self.value)] // layout.ploidy, minlength=n)
        else:
            return np.asarray(_variable(layout).copy_numbers(loci)[self.gene])
        return np.asarray(has.sum(axis=1))

    def _copies_to_change(self, layout: Layout, loci: np.ndarray, has: np.ndarray) -> np.ndarray:
        """Return how many copies of the gene are removed or added: i64[n]. Copies are added only to genomes
        that have one, up to the maximum length."""
        (value, way), was = limit_of(self.value), int(self.was or -1)
        loss = way == "fewer" or (way == "" and was > value)
        fewer = has <= value if loss else has < value  # with the allele, if it is a loss
        adds, target = loss != self.reverse, value if self.reverse else was
        change = np.where(fewer if adds else ~fewer, np.abs(target - has), 0)
        if not adds:
            return change
        variable = _variable(layout)
        span = int(variable.spans[layout.genes.index(layout[self.gene])])
        fits = variable.lengths(loci).max(axis=1) + change * span <= variable.longest
        return np.where(fits & (has > 0), change, 0)

    def _edited(self, layout: Layout, loci: np.ndarray) -> np.ndarray:
        """Return genomes u8[n, row] with the change; `loci` is written to."""
        new = self.value if self.reverse else self.was
        if self.kind == "letter":
            columns, letter = self._columns(layout), layout.alphabet.encode(new)[0]
            old = layout.alphabet.encode(self.value)[0]
            part = loci[:, columns]
            loci[:, columns] = letter if self.reverse else np.where(part == old, letter, part)
        elif self.kind == "haplotype":
            strings = loci.reshape(-1, layout.length)
            own = (strings == _string(layout, self.value)).all(axis=1) | self.reverse
            strings[own] = _string(layout, new)
        elif self.kind == "value":
            code = layout[self.gene]
            string, places, letters, values = self._values(layout, loci)
            numbers = code.numbers(np.array([_number(new)]), clip=False)
            code.codons.write(np.repeat(numbers, len(letters), axis=0), letters, -code.codons.first)
            some = np.ones(len(string), np.bool_) if self.reverse else _same(values, self.value)
            loci.reshape(-1, layout.length)[string[some, None], places[some]] = letters[some]
        else:
            n = limit_of(new)[0]
            return np.asarray(layout.rows([self._with_copies(layout, row, n) for row in loci]))
        return loci

    def _values(self, layout: Layout, loci: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return each copy of the gene: its string i64[k], its loci i64[k, letters], its letters and value."""
        code = layout[self.gene]
        if isinstance(layout, VariableLayout):
            number = layout.genes.index(code)
            found = layout.copies(loci)
            string, at = (column[found[2] == number] for column in found[:2])
            first = at + layout.skipped[number]
        else:
            string = np.arange(len(loci) * layout.ploidy)
            first = np.full(string.size, code.first)
        places = first[:, None] + np.arange(code.codons.length)
        letters = np.ascontiguousarray(loci.reshape(-1, layout.length)[string[:, None], places])
        values = code.values(code.codons.read(letters, -code.codons.first))
        return string, places, letters, np.asarray(values, np.float64)

    def _with_copies(self, layout: Layout, row: np.ndarray, wanted: int) -> str:
        """Return a genome as text with this number of copies; the last ones are removed or doubled."""
        pieces = layout.mark(row)
        own = [i for i, piece in enumerate(pieces) if piece.gene == self.gene]
        for i in own[wanted:]:
            pieces[i] = pieces[i]._replace(letters="")
        if own and wanted > len(own):
            last = pieces[own[-1]]
            pieces[own[-1]] = last._replace(letters=last.letters * (1 + wanted - len(own)))
        strings = ("".join(p.letters for p in pieces if p.string == s) for s in range(layout.ploidy))
        return str(_variable(layout).separator.join(strings))

    # --- reflexes -------------------------------------------------------------------------------------------

    def _reflexes(self, table: Table) -> list[tuple[np.ndarray, slice | list[int]]]:
        """Return the columns that contain the reflex's individual weights, and which of their entries do."""
        section = getattr(table.species.section, "reflex", None)
        names = [c.name for c in section.connections] if section is not None else []
        if self.gene and self.gene not in names:
            raise UnknownName(unknown_name(f"reflex of {table.name!r}", "connection", self.gene, names))
        out: list[tuple[np.ndarray, slice | list[int]]] = []
        if Reflexes in table:
            out.append((table[Reflexes].weight, [names.index(self.gene)] if self.gene else slice(None)))
        if Instincts in table and not self.gene and table[Instincts].reflex.shape[1]:
            out.append((table[Instincts].reflex, slice(None)))
        _need(
            bool(out),
            f"the reflex of {table.name!r} is the same for all; give it a gene, such as "
            '{ name = "shy", trait = "reflex.NAME.weight", … }',
        )
        return out


def rewrite(table: Table, rows: np.ndarray, old: np.ndarray, new: np.ndarray) -> None:
    """Give organisms in rows i64[k] genomes `new` instead of `old`, u8[k, row], and express them.

    Only columns whose expressed value differs change. Learned weights change by the difference of the
    inherited ones; the bodies of a species that grows, by the same factor as those of adults.

    Raises ValueError if the number of hidden units of a network would change.
    """
    heredity = table.species.heredity
    assert heredity is not None
    before, after = heredity.express(table, old), heredity.express(table, new)
    if table.species.standard_mass is not None:
        before |= sizes.of_adults(table, before, rows.size)
        after |= sizes.of_adults(table, after, rows.size)
    for at in hidden_units(table).values():
        was, now = (values[Traits, "value"][:, at] for values in (before, after))
        _need(np.array_equal(was, now), "this change adds or removes hidden units of a network")
    table[Genome].loci[rows] = new
    for (component, field), now in after.items():
        was, column = before[component, field], table.field(component, field)
        if component is Policy:
            learned = column[rows]
            column[rows] = np.where(learned == was, now, learned + (now - was))
        elif component is Body and table.species.growth is not None:
            column[rows] *= now / was
        else:
            column[rows] = np.where(now != was, now, column[rows])


def layout_of(table: Table) -> Layout:
    """Return the layout of a species' genomes; raise ValueError if it has none."""
    layout = getattr(table.species.heredity, "layout", None)
    if layout is None or Genome not in table:
        raise ValueError(f"species {table.name!r} has no genome")
    assert isinstance(layout, Layout)
    return layout


def edit_of(allele: AlleleLike, was: str | None = None, reverse: bool = False) -> Edit:
    """Return the change that takes out an allele; raise ValueError for a kind that cannot be taken out."""
    if allele.kind not in KINDS:
        raise ValueError(f"{allele.kind!r} cannot be taken out; expected {listed(KINDS)}")
    _need(not (reverse and allele.kind in ("policy", "reflex")), f"a {allele.kind} can only be taken out")
    gene = allele.gene if allele.kind != "haplotype" else ""
    return Edit(allele.species, allele.kind, gene, allele.locus, allele.value, was or "", reverse)


def _string(layout: Layout, text: str) -> np.ndarray:
    """Return one string of a genome as numbers u8[length], with blanks at the end."""
    letters = layout.alphabet.encode(text)
    fits = letters.size <= layout.length if layout.longest else letters.size == layout.length
    _need(fits, f"haplotype of {letters.size} letters; expected {layout.length}")
    out = np.full(layout.length, layout.blank, np.uint8)
    out[: letters.size] = letters
    return out


def _variable(layout: Layout) -> VariableLayout:
    assert isinstance(layout, VariableLayout)  # else `_check` has refused the change
    return layout


def limit_of(copies: str) -> tuple[int, str]:
    """Return the number in "2 or more", "2 or fewer" or "2", and "more", "fewer" or ""."""
    number, _, way = copies.partition(" or ")
    return int(number), way


def _number(value: str) -> float:
    return float(value.replace("−", "-"))


def _same(values: np.ndarray, value: str) -> np.ndarray:
    return np.array([f"{v:g}" for v in values.tolist()]) == f"{_number(value):g}"


def _need(condition: bool, message: str) -> None:
    if not condition:
        raise ValueError(message)
