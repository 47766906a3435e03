"""Drawings of nervous systems: what is in them, hand-counted for deer and a lamb; where it is;
what is refused."""

from __future__ import annotations

import copy
import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ecs_eco import System
from ecs_eco.analysis import nervous_figure
from ecs_eco.analysis.formula_signs import directions, pushes
from ecs_eco.analysis.nervous_diagram import diagram, nervous_species
from ecs_eco.analysis.nervous_figure import draw_nervous_system, draw_nervous_systems, save
from ecs_eco.analysis.nervous_layout import BETWEEN, Layout, spread
from ecs_eco.config import WorldConfig, compile_formula, load
from ecs_eco.engine.errors import ConfigError


class Stomach(System):
    acts = ("homeostasis",)

    def process(self) -> None:
        """Nothing: only the group of actions matters here."""


def noses(field: str) -> list[dict[str, Any]]:
    return [{"kind": "smell", "field": field, "at": [1.0, side]} for side in (0.5, -0.5)]


LAMB: dict[str, Any] = {
    "format": 1,
    "name": "meadow",
    "space": {"size": [40.0, 40.0], "edges": "torus"},
    "fields": {n: {"cell": 2.0, "diffusion": 0.5, "decay": 0.1} for n in ("milk_smell", "sheep_smell")},
    "substances": {"glucose": "blood sugar", "oxygen": "in blood"},
    "systems": [Stomach],
    "species": {
        "lamb": {
            "count": 3,
            "body": {"radius": 0.3, "mass": 5.0},
            "substances": {"glucose": 0.005, "oxygen": 0.01},
            "locomotion": {"speed": {"still": 0.0, "walk": 0.5}},
            "sensors": [
                *noses("milk_smell"),
                *noses("sheep_smell"),
                {"kind": "touch", "name": "lips", "at": [-0.5, 0.5]},
                {"kind": "touch", "name": "water_on_nose", "target": "wall"},
                {"kind": "own", "property": "glucose", "scale": 0.005},
                {"kind": "own", "property": "oxygen", "scale": 0.01},
            ],
            "actions": {"speed": ["still", "walk"], "homeostasis": ["suck", "inhale"]},
            "reflex": {
                "connections": [
                    {"sensor": "lips", "action": "suck", "weight": 1, "above": 0.5},
                    {"sensor": "water_on_nose", "action": "inhale", "weight": -1, "above": 0.5},
                ]
            },
            "happiness": {"weights": {"glucose": 1.0, "oxygen": -0.5}, "minimum": -1.0},
        }
    },
}


def lamb(**changes: Any) -> WorldConfig:
    data = copy.deepcopy(LAMB)
    data["species"]["lamb"] |= changes
    return load(data)


def many() -> WorldConfig:
    """A lamb of 40 channels with ten reflexes, four of them for one action, and lines of every kind."""
    eye = {"kind": "rays", "name": "eye", "count": 32, "radius": 5.0, "targets": ["lamb"],
           "report": "per_ray"}
    reflex = copy.deepcopy(LAMB["species"]["lamb"]["reflex"])
    for threshold in (0.1, 0.2, 0.3):
        reflex["connections"] += [{"sensor": "glucose", "action": a, "weight": 1, "below": threshold}
                                  for a in ("suck", "walk")]
    reflex["formulas"] = {"inhale": "0.3 - oxygen + min(eye_lamb_3, "
                                    "eye_lamb_30) * (lips > 0.5 or water_on_nose > 0.25) - milk_smell"}
    reflex["connections"].append({"sensor": "sheep_smell", "action": "still", "weight": 0, "above": 0.5})
    happiness = {"formula": "tanh(glucose) - oxygen + (lips - milk_smell) ** 2", "minimum": -1.0}
    return lamb(sensors=[*LAMB["species"]["lamb"]["sensors"], eye], reflex=reflex, happiness=happiness)


# signs of formulas


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("energy - 0.3 * smell", {"energy": 1, "smell": -1}),
        ("-tanh(2 * x)", {"x": -1}),
        ("x * smell", {"x": 1, "smell": None}),
        ("1 / (1 + smell)", {"smell": -1}),
        ("x ** 2", {"x": None}),
        ("smell ** 2", {"smell": 1}),
        ("x ** 3", {"x": 1}),
        ("abs(x)", {"x": None}),
        ("x > 0.5", {"x": 1}),
        ("0.1 < x < 0.5", {"x": None}),
        ("x == 1", {"x": None}),
        ("not (x > 0.5)", {"x": -1}),
        ("not x", {"x": None}),
        ("-1 if x < 0.5 else 0", {"x": 1}),
        ("x - x", {"x": None}),
        ("min(x, 3) - max(smell, 0.5)", {"x": 1, "smell": -1}),
    ],
)
def test_a_formula_rises_or_falls_with_a_reading(text: str, wanted: dict[str, int | None]) -> None:
    assert directions(text, {"smell", "energy"}) == wanted


FORMULAS = ("a * b - c", "clip(c, -1, b)", "b / (a + 1) + c * c", "-a ** 2 * (c > 0)",
            "(a > 0.4) * (b < 0.6) - abs(a)", "max(a, c) - exp(-b)", "c if a > 0.5 else b", "sqrt(a) * -b",
            "1 if c < 0 else -2", "a / c", "(a - c) * (b - 2)",
            "a and c > 0", "not a", "not c", "2 * (not c < b)")  # fmt: skip


@pytest.mark.parametrize("text", FORMULAS)
def test_what_is_said_of_a_formula_is_true_of_its_numbers(text: str) -> None:
    """a and b are never below 0, c may be; a sign that is told must hold between any two values of a grid."""
    grid = {"a": np.linspace(0, 1, 9), "b": np.linspace(0, 1, 9), "c": np.linspace(-1, 1, 9)}
    formula = compile_formula(text, grid)
    a, b, c = np.meshgrid(*grid.values(), indexing="ij")
    value = formula({"a": a, "b": b, "c": c})
    for name, sign in directions(text, {"a", "b"}).items():
        if sign is not None:
            steps = np.diff(value, axis="abc".index(name))
            assert (sign * steps[np.isfinite(steps)] >= -1e-6).all(), name


def test_in_a_reflex_a_term_pushes_the_way_that_it_counts() -> None:
    signs = pushes("(energy < 0.3) - 2 * (wolf > 0.5) + x * wolf", {"wolf", "energy"})
    assert signs == {"energy": 1, "wolf": None, "x": 1}
    assert pushes("-1 if lips > 0.3 and energy < 0.5 else 0", set()) == {"lips": -1, "energy": -1}


# what is drawn


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
    assert [(a.section, a.name) for a in d.actions][:2] == [("homeostatic regulation", "eat"),
                                                            ("locomotion", "still")]
    assert [a.name for a in d.actions if a.automatic] == ["eat"]
    assert [a.name for a in d.actions if a.neutral] == ["still", "none"]
    assert [a.name for a in d.actions if a.chosen] == ["still", "walk", "run", "left", "none", "right"]
    assert d.policy.label == "14 → 64 → 64 → 6, shared"
    assert d.happiness is not None
    signs = {d.channels[row]: sign for row, sign in d.happiness.sources}
    assert signs == {"energy": 1, "wolf_smell_1": -1, "wolf_smell_2": -1}
    assert (d.edges, d.reflexes, d.function) == ([], (), "")


def test_a_lamb_has_a_sucking_and_a_diving_reflex() -> None:
    d = diagram(lamb(), "lamb")
    assert d.edges == [
        ("lips", "suck", 1, "+1 if lips > 0.5"),
        ("water_on_nose", "inhale", -1, "−1 if water_on_nose > 0.5"),
    ]
    assert [s.kind for s in d.sensors] == ["interoception"] * 2 + ["touch"] * 2 + ["smell"] * 4
    assert [s.first for s in d.sensors] == [6, 7, 4, 5, 0, 1, 2, 3]
    assert [s.text for s in d.sensors][2:4] == ["anything, −29° to 29°", "wall, all round"]
    assert [a.name for a in d.actions] == ["suck", "inhale", "still", "walk"]
    assert [a.row for a in d.actions] == [2, 3, 0, 1]
    assert d.happiness is not None
    assert (d.happiness.sources, d.happiness.label) == (((6, 1), (7, -1)), "1·glucose - 0.5·oxygen")
    assert (d.policy.label, [a.chosen for a in d.actions]) == ("none", [False] * 4)


def bounce(x):
    return x[:, :2] * 0


def test_formulas_are_connections_from_every_sensor_that_they_name() -> None:
    reflex = {"formulas": {"suck": "(lips > 0.5) - (milk_smell < 0.1)", "walk": "glucose"},
              "function": bounce}
    d = diagram(lamb(reflex=reflex), "lamb")
    assert [(channel, action, sign) for channel, action, sign, _ in d.edges] == [
        ("milk_smell_1", "suck", -1),
        ("milk_smell_2", "suck", -1),
        ("lips", "suck", 1),
        ("glucose", "walk", 1),
    ]
    assert [(r.sign, r.label) for r in d.reflexes] == [(None, "(lips > 0.5) - (milk_smell < 0.1)"),
                                                       (1, "glucose")]
    assert d.function.endswith(":bounce")


def test_a_lone_action_and_its_absence_are_two_options_of_the_policy() -> None:
    changes = {"actions": {"homeostasis": ["suck"], "speed": ["still", "walk"]}, "reflex": None}
    d = diagram(lamb(**changes, policy={"kind": "shared", "hidden": [5]}), "lamb")
    assert d.policy.layers == (8, 5, 4)


def test_a_network_of_ones_own_is_drawn_with_its_name(tmp_path: Path) -> None:
    config = load("predator-prey", {"species.deer.policy.network": "ecs_eco.learning.mlp:MLP"})
    d = diagram(config, "deer")
    assert d.policy.label == "14 → MLP → 6, shared"
    assert save(draw_nervous_system(config, "deer"), tmp_path / "deer.png").stat().st_size > 10_000


GENES = [
    {"name": "courage", "trait": "reflex.lips_suck.weight", "letters": 1, "values": [0, 0, 0, -1]},
    {"name": "skin", "trait": "reflex.lips_suck.threshold", "letters": 2, "low": 0, "high": 1},
    {"name": "either", "trait": "reflex.dive.weight", "letters": 1, "values": [1, 0, 0, -1]},
    {"name": "greed", "trait": "happiness.glucose", "letters": 2, "low": -1, "high": 1},
    {"name": "nose", "trait": "sensors.milk_smell_1.left", "letters": 2, "low": 0, "high": 1},
    {"name": "neutral", "letters": 1, "values": [0, 1, 2, 3]},
]


def heritable() -> WorldConfig:
    reflex = copy.deepcopy(LAMB["species"]["lamb"]["reflex"])
    reflex["connections"][1]["name"] = "dive"
    return lamb(reflex=reflex, genome={"genes": GENES})


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


# where it is drawn


def overlapping(figure: Any) -> list[tuple[str, str]]:
    """Pairs of texts that overlap by more than a hair."""
    renderer = figure.canvas.get_renderer()
    texts = [t for ax in figure.axes for t in ax.texts if t.get_text()]
    boxes = [(t.get_text(), t.get_window_extent(renderer)) for t in texts]
    pairs = itertools.combinations(boxes, 2)
    return [(a, b) for (a, p), (b, q) in pairs
            if min(p.x1, q.x1) - max(p.x0, q.x0) > 1 and min(p.y1, q.y1) - max(p.y0, q.y0) > 2]


def outside(figure: Any) -> list[str]:
    renderer, page = figure.canvas.get_renderer(), figure.bbox
    boxes = [(t.get_text(), t.get_window_extent(renderer)) for ax in figure.axes for t in ax.texts]
    return [text for text, b in boxes if b.x0 < page.x0 or b.x1 > page.x1 or b.y0 < page.y0 or b.y1 > page.y1]


@pytest.mark.parametrize("species", ["deer", "wolf", "lamb", "heritable", "many", "one"])
@pytest.mark.parametrize("with_values", [False, True])
def test_no_texts_overlap_and_none_leaves_the_page(species: str, with_values: bool) -> None:
    one = {"sensors": [{"kind": "own", "property": "energy"}], "reflex": None, "happiness": None,
           "actions": {}}
    config = {"lamb": lamb, "heritable": heritable, "many": many,
              "one": lambda: lamb(**one)}.get(species, lambda: load("predator-prey"))()
    name = species if species in config.species else "lamb"
    d = diagram(config, name)
    actions = {"y": [1] * len(d.actions), "probabilities": [0.5] * len(d.actions),
               "decision": [1] * len(d.actions)}
    values = actions | {"readings": np.linspace(-1, 1, len(d.channels)), "happiness": -0.25}
    figure = draw_nervous_system(config, name, values if with_values else None)
    assert overlapping(figure) == []
    assert outside(figure) == []


def test_boxes_of_reflexes_keep_apart_and_stay_near_their_actions() -> None:
    assert spread([1.0, 1.0], [0.2, 0.4], 0.0, 9.0) == pytest.approx([0.8, 1.2])
    assert spread([5.0], [0.2], 0.0, 1.0) == pytest.approx([0.9])
    at = Layout(diagram(many(), "lamb"), {})
    boxes = sorted(at.hub_boxes.values())
    assert len(boxes) == 10
    for (y, height), (after, its) in itertools.pairwise(boxes):
        assert after - y >= (height + its) / 2 + BETWEEN - 1e-9


def test_a_legend_that_is_too_long_goes_on_in_another_line() -> None:
    at = Layout(diagram(many(), "lamb"), {})
    assert [sign for _, _, sign, _ in at.legend] == [1, -1, None, 0]
    assert len({y for _, y, _, _ in at.legend}) == 2


def test_of_many_rays_those_are_drawn_that_a_network_names() -> None:
    at = Layout(diagram(many(), "lamb"), {})
    assert sorted(set(at.channel_y) - set(range(8))) == [8, 9, 10, 37, 39]
    assert [n for _, n in at.dots] == [26, 1]


def test_values_are_shown_as_numbers_and_the_decision_is_filled() -> None:
    values = {"readings": np.arange(8) / 8, "y": [0, 0, 1, -1], "decision": [0, 1, 1, 0],
              "probabilities": [0.75, 0.25, 0.5, np.nan]}
    figure = draw_nervous_system(lamb(), "lamb", values | {"happiness": np.float32(-0.25)})
    (ax,) = figure.axes
    said = [t.get_text() for t in ax.texts]
    assert [t for t in said if t in ("+1", "−1")] == ["+1", "−1"]
    assert {"0.12", "0.88", "0.25", "0.50", "now −0.25"} <= set(said)
    bold = [t.get_text() for t in ax.texts if t.get_weight() == "bold"]
    assert {"walk", "suck"} <= set(bold)
    assert not {"still", "inhale"} & set(bold)


def test_blocking_is_told_from_forcing_without_colour() -> None:
    assert nervous_figure.look(1)["ls"] != nervous_figure.look(-1)["ls"]
    assert nervous_figure.look(1, dotted=True)["ls"] not in (nervous_figure.look(1)["ls"],
                                                             nervous_figure.look(-1)["ls"])


# files and errors


@pytest.mark.parametrize(("ending", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_the_same_drawing_gives_the_same_file(tmp_path: Path, ending: str, begins: bytes) -> None:
    files = [save(draw_nervous_system(lamb(), "lamb"), tmp_path / f"{i}.{ending}", dpi=50).read_bytes()
             for i in range(2)]
    assert files[0].startswith(begins)
    assert files[0] == files[1]


def test_all_species_with_nerves_are_drawn_below_each_other() -> None:
    config = load("predator-prey")
    assert nervous_species(config) == ["deer", "wolf"]
    figure = draw_nervous_systems(config)
    assert [ax.texts[0].get_text() for ax in figure.axes] == ["deer", "wolf"]


def test_a_species_without_nerves_is_refused_and_those_with_nerves_are_listed() -> None:
    config = load("predator-prey")
    with pytest.raises(ConfigError, match=r'"grass"\n.*neither sensors nor actions; allowed: .*: deer, wolf'):
        draw_nervous_system(config, "grass")
    with pytest.raises(ConfigError, match='did you mean "deer"'):
        draw_nervous_system(config, "dear")
    plants = lamb(sensors=[], actions={}, reflex=None, happiness=None)
    with pytest.raises(ConfigError, match="no species has sensors or actions"):
        draw_nervous_systems(plants)


def test_values_of_unknown_name_or_another_length_are_refused() -> None:
    with pytest.raises(KeyError, match='did you mean "readings"'):
        draw_nervous_system(lamb(), "lamb", {"reading": [0] * 8})
    with pytest.raises(ValueError, match=r"values\['y'\] of lamb has 3 numbers; allowed: 4"):
        draw_nervous_system(lamb(), "lamb", {"y": [0, 1, 0]})
