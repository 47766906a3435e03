"""Users' own panels: what their functions return, how often they are called, and who gets it."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from ecs_eco.view import panels as module
from ecs_eco.view.panels import Panels
from ecs_eco.view.shown import View

SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 4"><circle r="2"/></svg>'


def made(value):
    """The message of a panel whose function returns a value, without name and tick."""
    panels, view, out = Panels(None, {"One": lambda world: value}), View(), []
    panels.ask(view, {"shown": [0]})
    panels.add(view, 5, out)
    message = json.loads(out[0])
    assert (message.pop("kind"), message.pop("name"), message.pop("tick")) == ("panel", "One", 5)
    return message


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (7, {"number": 7.0}),
        (np.float32(0.5), {"number": 0.5}),
        (math.nan, {"number": None}),
        (SVG, {"svg": SVG}),
    ],
)
def test_a_number_and_an_svg_are_shown_as_they_are(value, shown):
    assert made(value) == shown


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("<p>hello</p>", "'<p>hello</p>' (str); expected a number, a matplotlib figure or an SVG text"),
        (None, "'None' (NoneType)"),
        ("<svg>" + "x" * 2_000_000, "2,000,005 characters"),
    ],
)
def test_anything_else_is_an_error_in_the_panel(value, words):
    assert words in made(value)["error"]


def test_a_figure_becomes_an_svg_with_its_text_and_pyplot_forgets_it():
    plt = pytest.importorskip("matplotlib.pyplot")
    figure, ax = plt.subplots()
    ax.set_title("ages of deer")
    svg = made(figure)["svg"]
    assert svg.lstrip().startswith("<?xml")
    assert "ages of deer" in svg
    assert figure.number not in plt.get_fignums()


class World:
    """A world whose functions take time."""

    def __init__(self, clock, cost):
        self.clock, self.cost, self.asked = clock, cost, []

    def count(self, world):
        self.asked.append(world)
        self.clock[0] += self.cost
        return len(self.asked)


@pytest.fixture
def clock(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: now[0]))
    return now


@pytest.mark.parametrize(("cost", "wait"), [(0.001, 1.0), (0.3, 3.0)])
def test_a_function_is_called_once_a_second_and_takes_a_tenth_of_the_time(clock, cost, wait):
    world = World(clock, cost)
    panels, view, out = Panels(world, {"One": world.count}), View(), []
    panels.ask(view, {"shown": [0]})
    panels.add(view, 1, out)
    clock[0] += wait - 0.01
    panels.add(view, 2, out)
    assert len(world.asked) == len(out) == 1
    clock[0] += 0.02
    panels.add(view, 2, out)
    panels.add(view, 2, out)
    assert [json.loads(message)["number"] for message in out] == [1, 2]
    clock[0] += 100
    panels.add(view, 2, out)  # at the same tick, there is nothing new
    assert world.asked == [world, world]


def test_pages_share_what_is_made_and_only_what_they_show_is_made(clock):
    world = World(clock, 0)
    panels = Panels(world, {"Hidden": lambda world: 1 / 0, "One": world.count})
    first, second, other = View(), View(), View()
    outs = [], [], []
    for view in (first, second):
        panels.ask(view, {"shown": [1]})
    for view, out in zip((first, second, other), outs, strict=True):
        panels.add(view, 3, out)
    assert outs[0] == outs[1]
    assert [len(out) for out in outs] == [1, 1, 0]
    assert len(world.asked) == 1
    panels.ask(other, {"shown": [0]})
    panels.add(other, 3, outs[2])
    assert json.loads(outs[2][0])["error"] == "ZeroDivisionError: division by zero"


@pytest.mark.parametrize("shown", [None, "One", [1], [-1], [True], [0.0]])
def test_other_requests_are_refused(shown):
    with pytest.raises(ValueError, match=r"panels: shown = .*; expected numbers less than 1"):
        Panels(None, {"One": len}).ask(View(), {"shown": shown})


@pytest.mark.parametrize("functions", [{"One": 3}, {"": len}, {1: len}])
def test_panels_are_functions_with_names(functions):
    with pytest.raises(TypeError, match="expected a name and a function of the world"):
        Panels(None, functions)


def test_the_function_of_a_recorded_run_receives_its_replay(plain):
    from ecs_eco.view.pair import Pair

    species = plain.species[0]
    panels, view, out = Panels(Pair(plain), {"n": lambda run: len(run.listed(species)["uid"])}), View(), []
    panels.ask(view, {"shown": [0]})
    panels.add(view, plain.tick, out)
    assert json.loads(out[0])["number"] == plain.counts()[species] > 0
