"""What is in the drawing of a nervous system, hand-counted for deer and a lamb."""

from __future__ import annotations

import math

import pytest

from ecs_eco.analysis.nervous_diagram import Diagram, diagram
from ecs_eco.config import load
from tests.analysis.nervous_worlds import heritable, lamb


def edges(d: Diagram) -> list[tuple[str, str, int | None, str]]:
    """(channel, action, sign, label) of every line of the reflex network."""
    names = {a.row: a.name for a in d.actions}
    return [(d.channels[row], names[r.action], sign, r.label) for r in d.reflexes for row, sign in r.sources]


def test_deer_have_these_senses_actions_and_networks() -> None:
    d = diagram(load("predator-prey"), "deer")
    assert [(s.kind, s.text, len(s.channels)) for s in d.sensors] == [
        ("interoception", "own energy", 1),
        ("smell", "grass_smell, 1 ahead, 0.5 left", 1),
        ("smell", "grass_smell, 1 ahead, 0.5 right", 1),
        ("smell", "wolf_smell, 1 ahead, 0.5 left", 1),
        ("smell", "wolf_smell, 1 ahead, 0.5 right", 1),
        ("vision", "nearest grass within 6 m", 3),
        ("vision", "nearest deer within 6 m", 3),
        ("vision", "nearest wolf within 6 m, if in sight", 3),
    ]
    assert [(a.section, a.name) for a in d.actions][:2] == [
        ("homeostatic regulation", "eat"),
        ("locomotion", "still"),
    ]
    assert [a.name for a in d.actions if a.automatic] == ["eat"]
    assert [a.name for a in d.actions if a.neutral] == ["still", "none"]
    assert [a.name for a in d.actions if a.chosen] == ["still", "walk", "run", "left", "none", "right"]
    assert d.policy.label == "14 → 64 → 64 → 6, shared"
    assert d.happiness is not None
    signs = {d.channels[row]: sign for row, sign in d.happiness.sources}
    assert signs == {"energy": 1, "wolf_smell_1": -1, "wolf_smell_2": -1}
    assert (edges(d), d.reflexes, d.function) == ([], (), "")


def test_a_lamb_has_a_sucking_and_a_diving_reflex() -> None:
    d = diagram(lamb(), "lamb")
    assert edges(d) == [
        ("lips", "suck", 1, "+1 if lips > 0.5"),
        ("water_on_nose", "inhale", -1, "−1 if water_on_nose > 0.5"),
    ]
    assert [s.kind for s in d.sensors] == ["interoception"] * 2 + ["touch"] * 2 + ["smell"] * 4
    assert [s.first for s in d.sensors] == [6, 7, 4, 5, 0, 1, 2, 3]
    assert [s.text for s in d.sensors][2:4] == ["anything, −29° to 29°", "wall, all around"]
    assert [a.name for a in d.actions] == ["suck", "inhale", "still", "walk"]
    assert [a.row for a in d.actions] == [2, 3, 0, 1]
    assert d.happiness is not None
    assert (d.happiness.sources, d.happiness.label) == (((6, 1), (7, -1)), "1·glucose - 0.5·oxygen")
    assert (d.policy.label, [a.chosen for a in d.actions]) == ("none", [False] * 4)


def bounce(x):
    return x[:, :2] * 0


def test_formulas_are_connections_from_every_sensor_that_they_name() -> None:
    reflex = {
        "formulas": {"suck": "(lips > 0.5) - (milk_smell < 0.1)", "walk": "glucose"},
        "function": bounce,
    }
    d = diagram(lamb(reflex=reflex), "lamb")
    assert [(channel, action, sign) for channel, action, sign, _ in edges(d)] == [
        ("milk_smell_1", "suck", -1),
        ("milk_smell_2", "suck", -1),
        ("lips", "suck", 1),
        ("glucose", "walk", 1),
    ]
    assert [(r.sign, r.label) for r in d.reflexes] == [
        (None, "(lips > 0.5) - (milk_smell < 0.1)"),
        (1, "glucose"),
    ]
    assert d.function.endswith(":bounce")


def test_senses_of_bodies_around_say_what_of_whom_how_far_and_where() -> None:
    feels = {"kind": "property", "radius": 6.0}
    sensors = [
        feels | {"property": "mass", "of": ["lamb"], "at": [1.0, -0.5], "decay": "linear"},
        feels | {"property": "glucose", "report": "mean", "decay": "inverse_square", "zero": 0.001},
        {"kind": "rays", "count": 3, "radius": 5.0, "targets": ["lamb"], "angle": -math.pi / 2, "at": [1, 0]},
        {"kind": "rays", "name": "eye", "count": 1, "radius": 5.0, "fov": 1.0, "targets": ["lamb"]},
    ]
    happiness = {"formula": "abs(lamb_mass) - any_glucose", "minimum": -1.0}
    d = diagram(lamb(sensors=sensors, reflex=None, happiness=happiness), "lamb")
    assert [(s.kind, s.text, s.at) for s in d.sensors] == [
        ("vision", "3 rays of 5 m over 180° around −90°, 1 ahead: lamb", (1, 0)),
        ("vision", "1 ray of 5 m over 57°: lamb", None),
        ("bodies around", "mass of lamb within 6 m, falling linearly, 1 ahead, 0.5 right", (1, -0.5)),
        ("bodies around", "mean glucose of all bodies within 6 m, by inverse square, at the center", (0, 0)),
    ]
    assert d.sensors[0].sector == pytest.approx((-math.pi, 0))
    assert d.happiness is not None
    assert d.happiness.sources == ((0, 1), (1, -1))  # no mass is below 0


def test_a_lone_action_and_its_absence_are_two_options_of_the_policy() -> None:
    changes = {"actions": {"homeostasis": ["suck"], "speed": ["still", "walk"]}, "reflex": None}
    d = diagram(lamb(**changes, policy={"kind": "shared", "hidden": [5]}), "lamb")
    assert d.policy.layers == (8, 5, 4)


def test_genes_are_named_where_they_act_and_tell_what_a_weight_can_be() -> None:
    d = diagram(heritable(), "lamb")
    assert [(r.sign, r.label, r.gene) for r in d.reflexes] == [
        (-1, "0 or −1 if lips > skin", "courage, skin"),
        (None, "0 or −1 or +1 if water_on_nose > 0.5", "either"),
    ]
    assert d.happiness is not None
    assert (d.happiness.genes, d.happiness.heritable) == (("greed",), {6})
    assert d.happiness.sources == ((6, None), (7, -1))
    assert [s.text for s in d.sensors if "gene" in s.text] == ["milk_smell, 1 ahead, 0.5 left, gene nose"]
    assert [r.gene for r in diagram(lamb(), "lamb").reflexes] == ["", ""]
