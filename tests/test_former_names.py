"""Names that documentation of former versions imported from still lead to what is there now."""

from __future__ import annotations

import sys
from importlib import import_module

import pytest

import ecs_eco
from ecs_eco import components, lab
from ecs_eco._lazy import FORMER, stored_name
from ecs_eco.lab.searching.sampler import Sampler
from tools import make_former_names


@pytest.mark.parametrize(
    ("former", "name", "present"),
    [
        ("ecs_eco.archipelago", "Archipelago", lab.Archipelago),
        ("ecs_eco.components", "Desires", components.HappinessWeights),
        ("ecs_eco.components", "Plasticity", components.LearningRates),
        ("ecs_eco.components", "Vigour", components.SpeedScale),
        ("ecs_eco.experiments.compare", "compare", lab.compare),
        ("ecs_eco.experiments.pretraining", "pretrain", lab.pretrain),
        ("ecs_eco.search", "search", lab.search),
        ("ecs_eco.search.sampler", "Sampler", Sampler),
        ("ecs_eco.sweeps", "run_sweep", lab.run_sweep),
    ],
)
@pytest.mark.filterwarnings("ignore:ecs_eco:DeprecationWarning")
def test_a_former_name_gives_the_same_object(former: str, name: str, present: object) -> None:
    assert getattr(import_module(former), name) is present
    assert lab.compare.__name__ == "compare"  # importing a module of that name has not replaced it


def test_a_former_name_warns_with_the_present_one(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in [name for name in sys.modules if name.startswith("ecs_eco.sweeps")]:
        monkeypatch.delitem(sys.modules, module)
    with pytest.warns(DeprecationWarning, match=r"ecs_eco\.sweeps is now ecs_eco\.lab"):
        import_module("ecs_eco.sweeps")
    assert "ecs_eco.worlds.pretrain" in FORMER


@pytest.mark.filterwarnings("ignore:ecs_eco:DeprecationWarning")
def test_the_package_leads_to_former_packages_and_lists_the_present_one() -> None:
    assert ecs_eco.search.search is lab.search
    assert "lab" in ecs_eco.__all__
    assert "search" not in ecs_eco.__all__
    with pytest.raises(ModuleNotFoundError):
        import_module("ecs_eco.sweeps.nothing")


def test_a_class_by_its_former_name_warns_and_keeps_that_name_in_checkpoints() -> None:
    with pytest.warns(DeprecationWarning, match=r"components\.Vigour is now ecs_eco\.components\.SpeedScale"):
        assert components.Vigour is components.SpeedScale
    assert (stored_name(components.SpeedScale), stored_name(components.Body)) == ("Vigour", "Body")
    with pytest.raises(AttributeError, match="has no 'Vigor'"):
        components.Vigor  # noqa: B018
    with pytest.raises(ModuleNotFoundError, match=r"No module named 'ecs_eco\.components\.Vigour'"):
        import_module("ecs_eco.components.Vigour")


def test_the_page_of_former_names_is_up_to_date(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["make_former_names.py", "--check"])
    assert make_former_names.main() == 0
    named = {row[:3] for row in make_former_names.rows()}
    assert named >= {
        ("key", "until", "satiation"),
        ("key", "entropy", "entropy_coef"),
        ("key", "latin_hypercube", "sample"),
        ("kind", 'kind = "simplified"', 'kind = "asexual", place = "anywhere"'),
        ("treatment", "frozen-learning", "frozen"),
        ("class", "ecs_eco.components.Vigour", "ecs_eco.components.SpeedScale"),
        ("method", "World.report", "World.measure"),
        ("argument", "dominance", "expression"),
    }
