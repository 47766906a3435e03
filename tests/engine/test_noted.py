"""Dicts that count their changes."""

import pytest

from ecs_eco import System, World, component, f32
from ecs_eco.engine.noted import Noted


@component
class Wool:
    length: f32 = 0.0


class Shear(System):
    needs = (Wool,)

    def update(self, table, world):
        self.shorn.append(table.name)


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d.__setitem__("c", 3),
        lambda d: d.__delitem__("a"),
        lambda d: d.pop("a"),
        lambda d: d.popitem(),
        lambda d: d.clear(),
        lambda d: d.update(c=3),
        lambda d: d.setdefault("c", 3),
        lambda d: d.__ior__({"c": 3}),
    ],
)
def test_every_change_is_counted_and_made(change):
    noted, plain = Noted(a=1, b=2), {"a": 1, "b": 2}
    before = Noted.changes
    change(noted)
    change(plain)
    assert Noted.changes == before + 1
    assert noted == plain


def test_reading_counts_as_no_change():
    noted = Noted(a=1)
    before = Noted.changes
    assert [*noted.items(), noted["a"], noted.get("b"), "a" in noted, noted | {}] == [
        ("a", 1),
        1,
        None,
        True,
        {"a": 1},
    ]
    assert Noted.changes == before


def test_a_system_sees_tables_and_components_that_come_and_go():
    world, shear = World(), Shear()
    world.add_table("sheep", Wool)
    world.add_table("goat")
    shear.shorn = []
    world.add_system(shear)
    world.run(1)
    world.table("goat").add_component(Wool)
    world.run(1)
    world.table("sheep").columns.pop(Wool)
    world.run(1)
    world.add_table("llama", Wool)
    world.run(1)
    shear.needs = ()
    world.run(1)
    assert shear.shorn == ["sheep", "sheep", "goat", "goat", "goat", "llama", "sheep", "goat", "llama"]
