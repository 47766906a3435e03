"""Every number of a species' section can be an organism's own, or there is a reason why not."""

import pytest

from ecs_eco.config import load
from ecs_eco.config.models.reproduction import Asexual, Spread
from ecs_eco.config.numbers import labels, numbers_of, values_in, with_value
from ecs_eco.config.traits import numbers_of_species, traits_of
from ecs_eco.inputs.section import COLUMN, Column, Section, Share, quantity, table


@pytest.mark.definition("3 genome encodes")
def test_every_number_of_a_species_can_be_an_organisms_own_or_there_is_a_reason_why_not() -> None:
    new = sorted(name for name, number in numbers_of_species().items() if number.own is None)
    assert not new, (
        f"new numbers of a species' section: {', '.join(new)}. Its model declares `own`, or its class does: "
        "True, where its system reads it by own_value(table, key, the species' value) and its kernel by "
        "of_row (see systems/metabolise.py), with a case in tests/worlds/own_worlds.py; Column, where a "
        "component has a field of this name for it; COLUMN, where traits_of has a trait of another name or "
        "another default; or the reason why no organism can have its own."
    )


def test_what_is_no_organisms_own_has_a_reason() -> None:
    numbers = numbers_of_species()
    assert numbers["metabolism.basal"].own is True
    assert numbers["body.radius"].own == COLUMN
    assert numbers["heat.insulation"].own == Column("Coat")
    reasons = [n.own for n in numbers.values() if isinstance(n.own, str) and n.own != COLUMN]
    assert len(reasons) > 20
    assert all(len(str(reason).split()) > 3 for reason in reasons)


def test_what_is_a_sites_is_no_plants() -> None:
    plants, deer = numbers_of(Spread), numbers_of(Asexual)
    for key in (("spacing",), ("dispersal",)):
        assert deer[key].own is True
        assert "site" in str(plants[key].own)


class Inner(Section):
    """A part of a section."""

    name: str = ""
    share: Share = quantity("a share", "1", 0.5)


class Outer(Section):
    """A section with numbers of all kinds."""

    most: int | None = quantity("a number of things", "1", None)
    inner: list[Inner] = table("several", list)
    rates: dict[str, float] = table("rates by name", dict)
    flag: bool = False


def test_numbers_are_found_in_lists_tables_and_sections_but_flags_are_none() -> None:
    found = {n.name: (n.low, n.high, n.whole) for n in numbers_of(Outer).values()}
    assert found == {
        "most": (-1e30, 1e30, True),
        "inner.*.share": (0.0, 1.0, False),
        "rates.*": (-1e30, 1e30, False),
    }
    outer = Outer(most=3, inner=[Inner(name="a"), Inner(name="b", share=0.25), Inner()], rates={"x": 2.0})
    assert [(key, value) for _, key, value in values_in(outer)] == [
        (("most",), 3),
        (("inner", "a", "share"), 0.5),
        (("inner", "b", "share"), 0.25),
        (("inner", "2", "share"), 0.5),
        (("rates", "x"), 2.0),
    ]
    changed = with_value(outer, ("inner", "b", "share"), 0.75)
    assert [value for _, _, value in values_in(changed)] == [3, 0.5, 0.75, 0.5, 2.0]
    assert [value for _, _, value in values_in(outer)] == [3, 0.5, 0.25, 0.5, 2.0]


def test_entries_that_share_a_name_are_numbered() -> None:
    assert labels([Inner(name="a"), Inner(name="b"), Inner(name="a")]) == ["a_1", "b", "a_2"]


def test_traits_have_the_bounds_the_unit_and_the_text_of_the_schema() -> None:
    trait = traits_of(load("reflexes").species["goat"], 2)["diet.green.efficiency"]
    assert (trait.component, trait.index, trait.default, trait.low, trait.high) == (
        "Traits",
        None,
        0.0,
        0.0,
        1.0,
    )
    assert trait.text == "proportion of the item's energy that is also gained"
    assert traits_of(load("reflexes").species["goat"], 2)["metabolism.basal"].unit == "energy/s"
