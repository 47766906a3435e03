"""Drawings of nervous systems: where things stand, what values add, the files, and what is refused."""

from __future__ import annotations

import itertools
import re
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ecs_eco.analysis import nervous_figure, nervous_pen
from ecs_eco.analysis.nervous_diagram import diagram, nervous_species
from ecs_eco.analysis.nervous_figure import draw_nervous_system, draw_nervous_systems, save
from ecs_eco.analysis.nervous_layout import BETWEEN, Layout, spread
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from tests.analysis.nervous_worlds import heritable, lamb, many

contrast = runpy.run_path(str(Path(__file__).with_name("test_palette.py")))["contrast"]


def test_a_network_of_ones_own_is_drawn_with_its_name(tmp_path: Path) -> None:
    config = load("predator-prey", {"species.deer.policy.network": "ecs_eco.learning.mlp:MLP"})
    d = diagram(config, "deer")
    assert d.policy.label == "14 → MLP → 6, shared"
    assert save(draw_nervous_system(config, "deer"), tmp_path / "deer.png").stat().st_size > 10_000


def overlapping(figure: Any) -> list[tuple[str, str]]:
    """Pairs of texts that overlap by more than a hair."""
    renderer = figure.canvas.get_renderer()
    texts = [t for ax in figure.axes for t in ax.texts if t.get_text()]
    boxes = [(t.get_text(), t.get_window_extent(renderer)) for t in texts]
    pairs = itertools.combinations(boxes, 2)
    return [
        (a, b)
        for (a, p), (b, q) in pairs
        if min(p.x1, q.x1) - max(p.x0, q.x0) > 1 and min(p.y1, q.y1) - max(p.y0, q.y0) > 2
    ]


def outside(figure: Any) -> list[str]:
    renderer, page = figure.canvas.get_renderer(), figure.bbox
    boxes = [(t.get_text(), t.get_window_extent(renderer)) for ax in figure.axes for t in ax.texts]
    return [text for text, b in boxes if b.x0 < page.x0 or b.x1 > page.x1 or b.y0 < page.y0 or b.y1 > page.y1]


@pytest.mark.parametrize("species", ["deer", "wolf", "lamb", "heritable", "many", "one"])
@pytest.mark.parametrize("with_values", [False, True])
def test_no_texts_overlap_and_none_leaves_the_page(species: str, with_values: bool) -> None:
    one = {
        "sensors": [{"kind": "own", "property": "energy"}],
        "reflex": None,
        "happiness": None,
        "actions": {},
    }
    config = {"lamb": lamb, "heritable": heritable, "many": many, "one": lambda: lamb(**one)}.get(
        species, lambda: load("predator-prey")
    )()
    name = species if species in config.species else "lamb"
    d = diagram(config, name)
    actions = {
        "y": [1] * len(d.actions),
        "probabilities": [0.5] * len(d.actions),
        "decision": [1] * len(d.actions),
    }
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
    values = {
        "readings": np.arange(8) / 8,
        "y": [0, 0, 1, -1],
        "decision": [0, 1, 1, 0],
        "probabilities": [0.75, 0.25, 0.5, np.nan],
    }
    figure = draw_nervous_system(lamb(), "lamb", values | {"happiness": np.float32(-0.25)})
    (ax,) = figure.axes
    texts = [t.get_text() for t in ax.texts]
    assert [t for t in texts if t in ("+1", "−1")] == ["+1", "−1"]
    assert {"0.12", "0.88", "0.25", "0.50", "now −0.25"} <= set(texts)
    bold = [t.get_text() for t in ax.texts if t.get_weight() == "bold"]
    assert {"walk", "suck"} <= set(bold)
    assert not {"still", "inhale"} & set(bold)


def test_blocking_is_told_from_forcing_without_colour() -> None:
    assert nervous_figure.look(1)["ls"] != nervous_figure.look(-1)["ls"]
    assert nervous_figure.look(1, dotted=True)["ls"] not in (
        nervous_figure.look(1)["ls"],
        nervous_figure.look(-1)["ls"],
    )


# files and errors


@pytest.mark.parametrize(("ending", "begins"), [("png", b"\x89PNG"), ("svg", b"<svg"), ("pdf", b"%PDF")])
def test_the_same_drawing_gives_the_same_file(tmp_path: Path, ending: str, begins: bytes) -> None:
    files = [
        save(draw_nervous_system(lamb(), "lamb"), tmp_path / f"{i}.{ending}", dpi=50).read_bytes()
        for i in range(2)
    ]
    assert files[0].startswith(begins)
    assert files[0] == files[1]


def test_an_svg_follows_the_theme_and_its_words_stand_out_on_a_dark_ground(tmp_path: Path) -> None:
    night, words = nervous_pen.NIGHT, set()
    for name, config in (("lamb", lamb()), ("deer", load("predator-prey"))):
        drawn = draw_nervous_system(config, name)
        text = save(drawn, tmp_path / "x.svg").read_text(encoding="utf-8")
        used = set(re.findall(r' (fill|stroke)="(#[0-9a-f]{6})"', text))
        assert len(used) > 8
        assert [hue for what, hue in used if f'[{what}="{hue}"]{{{what}:{night.get(hue)}}}' not in text] == []
        assert f">{name}<" in text  # words can be searched
        words |= set(re.findall(r'<text [^>]*fill="(#[0-9a-f]{6})"', text))
    assert {nervous_pen.INK, nervous_pen.GREY} <= words
    grounds = [night[ground] for ground in ("#ffffff", nervous_pen.POLICY, nervous_pen.HAPPINESS)]
    assert min(contrast(night[hue], ground) for hue in words for ground in grounds) >= 4.5
    signs = [night[hue.lower()] for hue in (nervous_pen.GREEN, nervous_pen.RED, nervous_pen.BLUE)]
    assert min(contrast(sign, ground) for sign in signs for ground in grounds) >= 3


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
    with pytest.raises(ValueError, match=r"values\['y'\] of lamb has 3 numbers; expected 4"):
        draw_nervous_system(lamb(), "lamb", {"y": [0, 1, 0]})
