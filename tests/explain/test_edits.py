"""Edits: alleles are replaced in some organisms, and nothing else changes."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body, Genome, Metabolism, Reflexes, Stature, Traits
from ecs_eco.explain import Edit
from ecs_eco.explain.edits import edit_of
from tests.explain.newts import VARIABLE, WORLD

HUNGRY = Edit("newt", "letter", "hunger", 0, "B", "A")


@pytest.fixture(scope="module")
def pond():
    return World.from_config(WORLD, seed=1, record=False).run(1)


@pytest.fixture(scope="module")
def variable():
    world = copy.deepcopy(WORLD)
    world["species"]["newt"]["genome"] = VARIABLE
    return World.from_config(world, seed=1, record=False)


def basal(table, rows):
    return table[Traits].value[rows, table.species.traits["metabolism.basal"]]


def test_a_letter_is_replaced_in_all_strings_and_expressed(pond):
    table = pond.copy().table("newt")
    rows, dose = HUNGRY.carriers(table)
    loci = table[Genome].loci[rows]
    assert (loci[:, [0, 3]].sum(axis=1) == dose).all()
    assert set(dose.tolist()) == {1, 2}
    assert (basal(table, rows) == 0.25).all()
    HUNGRY.apply(table, rows[::2])
    assert (basal(table, rows[::2]) == 0.125).all()
    assert (basal(table, rows[1::2]) == 0.25).all()
    now = table[Genome].loci[rows]
    assert (now[::2][:, [0, 3]] == 0).all()
    assert (now[1::2] == loci[1::2]).all()
    assert (now[:, [1, 2, 4, 5]] == loci[:, [1, 2, 4, 5]]).all()


def test_only_the_edited_organisms_differ(pond):
    one = pond.copy()
    assert one.digest() == pond.digest()
    table = one.table("newt")
    HUNGRY.apply(table, np.zeros(0, np.int64))
    assert one.digest() == pond.digest()
    rows = HUNGRY.carriers(table)[0][:1]
    HUNGRY.apply(table, rows)
    assert one.digest() != pond.digest()
    others = np.setdiff1d(table.rows(), rows)
    for component in (Genome, Traits, Metabolism):
        for name in pond.table("newt").defaults[component]:
            here, there = table.field(component, name), pond.table("newt").field(component, name)
            assert (here[others] == there[others]).all()


def test_in_reverse_those_without_the_allele_receive_it(pond):
    table = pond.copy().table("newt")
    edit = replace(HUNGRY, reverse=True)
    rows, dose = edit.carriers(table)
    assert (basal(table, rows) == 0.125).all()
    assert (dose == 2).all()
    assert rows.size
    edit.apply(table, rows)
    assert (basal(table, rows) == 0.25).all()
    assert not edit.carriers(table)[0].size


def test_a_value_is_replaced_by_its_codon(pond):
    one, two = pond.copy().table("newt"), pond.copy().table("newt")
    value = Edit("newt", "value", "hunger", value="0.25", was="0.125")
    rows = value.carriers(one)[0]
    assert (rows == HUNGRY.carriers(two)[0]).all()
    value.apply(one, rows)
    HUNGRY.apply(two, rows)
    assert (one[Genome].loci[rows] == two[Genome].loci[rows]).all()
    with pytest.raises(ValueError, match=r"no codon codes for 7; expected 0\.125, 0\.25"):
        replace(value, was="7").apply(one, one.rows())


def test_a_whole_string_is_replaced(pond):
    table = pond.copy().table("newt")
    edit = Edit("newt", "haplotype", value="BAA", was="ABB")
    rows = edit.carriers(table)[0]
    edit.apply(table, rows)
    text = [table.species.heredity.layout.text(row) for row in table[Genome].loci[rows]]
    assert rows.size
    assert all("ABB" in (one[:3], one[3:]) for one in text)
    assert not any("BAA" in (one[:3], one[3:]) for one in text)


def test_copies_are_removed_from_the_end_and_added_in_tandem(variable):
    table = variable.copy().table("newt")
    layout = table.species.heredity.layout
    edit = Edit("newt", "copies", "hunger", value="3", was="1")
    rows, dose = edit.carriers(table)
    number = layout.copy_numbers(table[Genome].loci[table.rows()])["hunger"]
    assert (number == 3).all()
    assert (dose == 2).all()
    assert rows.size == table.n
    edit.apply(table, rows)
    assert (layout.copy_numbers(table[Genome].loci[rows])["hunger"] == 1).all()
    poor = basal(table, rows) == 0.0625
    assert poor.any()
    more = replace(edit, value="2", reverse=True)
    assert (more.carriers(table)[1] == 1).all()
    more.apply(table, rows)
    assert (layout.copy_numbers(table[Genome].loci[rows])["hunger"] == 2).all()
    assert (basal(table, rows[poor]) == 0.125).all()
    loss = replace(edit, value="2", was="3")  # fewer copies are the allele
    assert (loss.carriers(table)[1] == 1).all()
    assert not replace(loss, reverse=True).carriers(table)[0].size
    assert (replace(loss, value="2 or fewer").carriers(table)[1] == 1).all()
    assert not replace(edit, value="3 or more").carriers(table)[0].size
    with pytest.raises(ValueError, match="3 copies cannot replace 2 or more"):
        replace(loss, value="2 or more").carriers(table)
    edit.apply(table, rows[::2])
    none = replace(edit, value="1", was="0")
    assert none.carriers(table)[1].tolist() == [1 if i % 2 == 0 else 2 for i in range(rows.size)]
    none.apply(table, rows)
    assert not none.carriers(table)[0].size
    assert (basal(table, rows) == 0.125).all()  # the species' own value


def test_bodies_change_as_those_of_adults():
    world = copy.deepcopy(WORLD)
    size = {"name": "size", "trait": "body.radius", "letters": 1, "values": [0.1, 0.2]}
    newt = world["species"]["newt"]
    newt["genome"]["genes"] = [size]
    newt["body"] = {"radius": 0.1, "density": 1000.0}
    newt["growth"] = {"rate": 0.1, "newborn": 0.1}
    table = World.from_config(world, seed=1, record=False).table("newt")
    edit = Edit("newt", "value", "size", value="0.2", was="0.1")
    rows = edit.carriers(table)[0]
    table[Body].radius[rows], table[Body].mass[rows] = 0.1, 1.0  # young
    adult = table[Stature].mass[rows].copy()
    edit.apply(table, rows)
    assert table[Stature].radius[rows] == pytest.approx(0.1)
    assert table[Stature].mass[rows] == pytest.approx(adult / 8)
    assert table[Body].radius[rows] == pytest.approx(0.05)
    assert table[Body].mass[rows] == pytest.approx(1 / 8)


def test_the_alternative_is_the_most_common_other_allele(pond, variable):
    table = pond.table("newt")
    assert Edit("newt", "letter", locus=0, value="B").alternative(table) == "A"
    assert Edit("newt", "value", "hunger", value="0.125").alternative(table) == "0.25"
    other = Edit("newt", "haplotype", value="BAA").alternative(table)
    assert len(other) == 3
    assert other != "BAA"
    three = variable.table("newt")  # copies each
    for value in ("2", "2 or fewer"):
        assert Edit("newt", "copies", "hunger", value=value).alternative(three) == "3"
    with pytest.raises(ValueError, match="all newt carry 2 or more"):
        Edit("newt", "copies", "hunger", value="2 or more").alternative(three)
    only = pond.copy().table("newt")
    HUNGRY.apply(only, only.rows())
    with pytest.raises(ValueError, match=r"all newt carry A: choose an earlier tick, or what replaces it"):
        Edit("newt", "letter", locus=0, value="A").alternative(only)


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (Edit("newt", "letter", locus=3, value="A", was="B"), "locus = 3; expected 0 to 2"),
        (Edit("newt", "letter", locus=0, value="X", was="B"), "'X' at position 0 is not in the alphabet"),
        (Edit("newt", "letter", locus=0, value="AB", was="B"), "expected one letter each"),
        (Edit("newt", "letter", locus=0, value="B", was="B"), "letter 'B' would be replaced by itself"),
        (Edit("newt", "value", "hungr", value="1", was="0"), 'did you mean "hunger"'),
        (Edit("newt", "copies", "hunger", value="2", was="1"), "only variable-length genomes have copies"),
        (Edit("newt", "haplotype", value="A", was="B"), "haplotype of 1 letters; expected 3"),
        (Edit("newt", "policy"), "'newt' has no individual policies"),
        (Edit("newt", "reflex"), "the reflex of 'newt' is the same for all"),
        (Edit("newt", "reflex", "shy"), "unknown connection 'shy'"),
    ],
)
def test_impossible_edits_are_refused(pond, edit, words):
    with pytest.raises((ValueError, KeyError), match=words):
        edit.carriers(pond.table("newt"))


def test_loci_and_clades_without_meaning_are_refused(variable):
    with pytest.raises(ValueError, match="loci are not comparable in variable-length genomes"):
        Edit("newt", "letter", locus=0, value="A", was="C").carriers(variable.table("newt"))
    with pytest.raises(ValueError, match="'clade' cannot be taken out; expected letter"):
        edit_of(Edit("newt", "clade", value="17"))
    with pytest.raises(ValueError, match="a reflex can only be taken out"):
        edit_of(Edit("newt", "reflex"), reverse=True)


def test_a_reflex_is_cut():
    herd = World.from_config("reflexes", seed=1, record=False)
    table = herd.table("goat")
    edit = Edit("goat", "reflex", "red")
    rows = edit.carriers(table)[0]
    weight = table[Reflexes].weight
    assert (weight[rows, 0] == -1).all()
    others = weight[rows, 1:].copy()
    edit.apply(table, rows[::2])
    assert (weight[rows[::2], 0] == 0).all()
    assert (weight[rows[1::2], 0] == -1).all()
    assert (weight[rows, 1:] == others).all()
    assert (edit.carriers(table)[0] == rows[1::2]).all()
