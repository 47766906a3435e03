"""Worlds and tables as notebooks show them: counted by hand, with nothing unescaped."""

import pytest

from ecs_eco import World, component, f32
from ecs_eco.components import Position


@component
class Mood:
    """How somebody feels."""

    joy: f32 = 0.25
    wishes: f32[3] = 0.0


@pytest.fixture
def world():
    world = World((20.0, 10.0), seed=7, name="<script>")
    world.add_table("a<b", Position, Mood)
    world.spawn("a<b", n=10)
    return world


def test_a_world_shows_its_clock_and_a_row_for_each_table(world):
    world.run(2)
    html = world._repr_html_()
    assert "World &#x27;&lt;script&gt;&#x27; at tick 2, seed 7, 20 × 10 m" in html
    assert "<td>a&lt;b</td><td>10</td><td>Position, Mood</td>" in html
    assert "<script>" not in html


def test_a_table_shows_its_first_living_and_says_how_many_more(world):
    world.run(1)
    table = world.table("a<b")
    html = table._repr_html_()
    assert html.count("<tr>") == 1 + 8
    assert "<th>Mood.joy</th>" in html
    assert "wishes" not in html, "a field of several numbers is no cell"
    assert html.count("<td>0.25</td>") >= 8
    assert html.endswith("<p>2 more alive</p>")
