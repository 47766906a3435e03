"""Systems, groups of actions and functions of one's own, named in a world file or handed over in Python."""

import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ecs_eco import System, World
from ecs_eco.components import Metabolism, Nervous
from ecs_eco.config import for_training, load
from ecs_eco.engine.errors import ConfigError


class Shelter(System):
    needs = (Nervous,)
    acts = ("shelter",)

    def update(self, table: Any, world: Any) -> None:
        table.own["sheltered"] = table.own.get("sheltered", 0) + 1


def content(x: np.ndarray) -> np.ndarray:
    return x[:, 0]


def world_of(**snail: Any) -> dict[str, Any]:
    snail = {
        "count": 3,
        "body": {"radius": 0.1},
        "sensors": [{"kind": "own", "property": "energy"}],
        "actions": {"shelter": ["stay", "hide", "dig"]},
    } | snail
    return {"format": 1, "name": "garden", "space": {"size": [9.0, 9.0]}, "species": {"snail": snail}}


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> types.ModuleType:
    """An importable module with a system and a happiness in it."""
    garden = types.ModuleType("my_garden")
    garden.number = 3  # type: ignore[attr-defined]
    for thing in (Shelter, content):
        setattr(garden, thing.__name__, thing)
        monkeypatch.setattr(thing, "__module__", "my_garden")
    monkeypatch.setitem(sys.modules, "my_garden", garden)
    return garden


def test_a_group_that_no_system_carries_out_is_refused() -> None:
    with pytest.raises(ConfigError, match="shelter") as error:
        load(world_of())
    assert error.value.problems[0].allowed == "speed, turn, climb, pitch, eat, mate, carry, build, nurse"


def test_a_misspelt_group_of_ones_own_is_refused_with_the_right_name() -> None:
    with pytest.raises(ConfigError) as error:
        World.from_config(world_of(actions={"sheltr": ["stay"]}), systems=[Shelter()])
    assert error.value.problems[0].nearest == "shelter"


@pytest.mark.parametrize(
    ("actions", "what"), [([], "is empty"), (["stay", "stay"], "named twice"), (["a b"], "not a name")]
)
def test_wrong_actions_of_a_group_of_ones_own_are_refused(actions: list[str], what: str) -> None:
    with pytest.raises(ConfigError) as error:
        load(world_of(actions={"shelter": actions}), systems=[Shelter])
    assert [p.what for p in error.value.problems] == [what]


@pytest.mark.usefixtures("module")
@pytest.mark.parametrize("system", ["my_garden:Shelter", Shelter])
def test_a_system_of_a_world_file_acts_in_its_phase(system: Any) -> None:
    world = World.from_config(world_of() | {"systems": [system], "code": ["my_garden"]}, trust=True).run(2)
    assert world.table("snail").own["sheltered"] == 2


def test_systems_are_added_to_a_shipped_world_and_to_a_loaded_one() -> None:
    for config in ("predator-prey", load("predator-prey")):
        world = World.from_config(config, policies="random", systems=[Shelter()]).run(1)
        assert world.table("deer").own["sheltered"] == 1


@pytest.mark.usefixtures("module")
@pytest.mark.parametrize(
    ("system", "what"),
    [
        ("my_garden:Shelte", "has no function"),
        ("my_garden:content", "not a system"),
        ("my_gardn:Shelter", "does not list"),
    ],
)
def test_what_is_no_system_is_refused(system: str, what: str) -> None:
    with pytest.raises(ConfigError, match=what):
        load(world_of(actions={}) | {"systems": [system], "code": ["my_garden"]}, trust=True)


def test_systems_are_part_of_the_resolved_world_by_name() -> None:
    with_system = load(world_of(), systems=[Shelter()])
    assert with_system.resolved()["systems"] == [f"{__name__}:Shelter"]
    assert with_system.config_hash == load(world_of() | {"systems": [Shelter]}).config_hash
    assert with_system.config_hash != load(world_of(actions={})).config_hash


@pytest.mark.usefixtures("module")
def test_a_function_in_a_dict_is_the_function_that_a_file_names() -> None:
    for function in (content, "my_garden:content"):
        config = load(
            world_of(happiness={"function": function, "minimum": 0.0}) | {"code": ["my_garden"]},
            systems=[Shelter],
            trust=True,
        )
        world = World.from_config(for_training(config), learn=False).run(1)
        table = world.table("snail")
        assert table[Nervous].happiness[:3].tolist() == table[Metabolism].energy[:3].tolist()


def test_a_function_without_a_module_still_works_while_training() -> None:
    config = load(
        world_of(happiness={"function": lambda x: x[:, 0] * 2, "minimum": 0.0}), systems=[Shelter()]
    )
    assert (
        for_training(config).species["snail"].happiness.function is config.species["snail"].happiness.function
    )


def decided(*rows: tuple[int, int, int], **snail: Any) -> Any:
    """A table of snails that have decided so on stay, hide and dig."""
    world = World.from_config(world_of(count=len(rows), **snail), systems=[Shelter()])
    table = world.table("snail")
    table[Nervous].decision[: len(rows)] = rows
    return table


def test_of_a_group_the_first_action_that_is_on_is_done() -> None:
    table = decided((1, 1, 1), (0, 1, 1), (0, 0, 1), (0, 0, 0))
    done = {a: table.species.nerves.doing(table, a)[:4].tolist() for a in ("stay", "hide", "shelter.dig")}
    assert done == {"stay": [1, 0, 0, 0], "hide": [0, 1, 0, 0], "shelter.dig": [0, 0, 1, 0]}


def test_the_neutral_action_is_done_where_none_is_on() -> None:
    table = decided((0, 0, 0), (0, 0, 1), default_action={"shelter": "hide"})
    assert table.species.nerves.doing(table, "hide")[:2].tolist() == [True, False]
    assert table.species.nerves.doing(table, "hide").sum() == 1, "free rows do nothing"


def test_asking_for_an_unknown_action_names_the_right_one() -> None:
    table = decided((0, 0, 0))
    with pytest.raises(KeyError, match=r"did you mean \"shelter.hide\""):
        table.species.nerves.doing(table, "shelter.hyde")


OWN = """from ecs_eco import System, component, f32

@component
class Slime:
    length: f32 = 0.5  # [m]

class Fields:
    fields = ("length",)

def plain():
    pass

class Wait(System):
    phase = "record"

    def process(self, *_):
        pass
"""


def slimy(folder: Path, code: dict[str, str], component: str = "own:Slime", **more: Any) -> dict[str, Any]:
    for name, text in code.items():
        (folder / name).write_text(text)
    data = world_of(actions={}, sensors=[], components=[component])
    return (
        data
        | {"code": list(code), "systems": ["own:Wait"], "reporters": {"slime": "mean(snail.Slime.length)"}}
        | more
    )


@pytest.mark.parametrize(
    ("bad", "why"),
    [
        ("import nosuch", "ModuleNotFoundError: No module named 'nosuch' (bad.py, line 1)"),
        ("def f(:", "SyntaxError: invalid syntax (bad.py, line 1)"),
        ("\nNONE.x", "NameError: name 'NONE' is not defined (bad.py, line 2)"),
        ("import own\nown.missing", "AttributeError: module"),
    ],
)
def test_a_bad_module_is_named_and_the_others_are_not_blamed(tmp_path: Path, bad: str, why: str) -> None:
    for more in ({}, {"reporters": {"of the bad one": "bad:f"}}):
        data = slimy(tmp_path, {"own.py": OWN, "bad.py": bad}, **more)
        with pytest.raises(ConfigError) as error:
            load(data, trust=True, places=[tmp_path])
        (problem,) = error.value.problems
        assert (problem.key, problem.value) == (("code", 1), "bad.py")
        assert problem.what.startswith(f"cannot be imported: {why}")
    (tmp_path / "bad.py").write_text("import own\nf = own.plain")  # mended, in the same process
    assert load(data | {"reporters": {}}, trust=True, places=[tmp_path])


def test_a_module_that_imports_a_bad_one_says_which(tmp_path: Path) -> None:
    data = slimy(tmp_path, {"bad.py": "1 / 0", "own.py": "import bad"})
    with pytest.raises(ConfigError) as error:
        load(data, trust=True, places=[tmp_path])
    assert [(p.key, p.what) for p in error.value.problems] == [
        (("code", 0), "cannot be imported: ZeroDivisionError: division by zero (bad.py, line 1)"),
        (("code", 1), "cannot be imported: ImportError: bad.py cannot be imported (own.py, line 1)"),
    ]


@pytest.mark.parametrize("name", ["plain", "Wait", "Fields"])
def test_what_is_no_component_is_refused_where_a_reporter_is_a_formula(tmp_path: Path, name: str) -> None:
    with pytest.raises(ConfigError) as error:
        load(slimy(tmp_path, {"own.py": OWN}, f"own:{name}"), trust=True, places=[tmp_path])
    assert [(p.key, p.what) for p in error.value.problems] == [
        (("species", "snail", "components", 0), "not a component")
    ]
