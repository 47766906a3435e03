"""What users see of the package before they run anything: names, types, arguments."""

import inspect
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ecs_eco
from ecs_eco import World, column, component, f32, u8
from ecs_eco.record import checkpoint
from ecs_eco.templates import new_package, new_world
from ecs_eco.testing import check_component
from ecs_eco.worlds.build import build

ROOT = Path(__file__).parents[1]
HERD = '''
"""A file of a user's, for type checkers."""

from typing import Annotated, assert_type

import numpy as np

import ecs_eco
from ecs_eco import System, Table, World, boolean, column, component, f32, u8
from ecs_eco.components import Metabolism, Position
from ecs_eco.space import Seekers
from ecs_eco.systems import Metabolise
from ecs_eco.testing import check_component, check_system


@component
class Wool:
    """The coat of one animal."""

    length: f32 = 0.01  # [m]
    shorn: boolean = False
    colour: Annotated[u8, column(u8, within=(0, 9))] = 3
    whorl: Annotated[np.ndarray, column(f32, 3)] = np.zeros(3, np.float32)


class GrowWool(System):
    """Wool grows."""

    needs = (Wool,)
    phase = "metabolise"

    def update(self, table: Table, world: World) -> None:
        table[Wool].length[table.alive] += np.float32(2e-4 * world.dt)


class Flee(System):
    """Sheep turn away from the nearest wolf."""

    needs = (Position,)
    phase = "move"

    def update(self, table: Table, world: World) -> None:
        seekers = Seekers(world, table)
        rows, distance = seekers.nearest("wolf", 5.0)
        assert_type(rows, np.ndarray)
        near: np.ndarray = np.isfinite(distance)
        table[Position].heading[seekers.rows[near]] = np.pi + seekers.heading[near]


def fear(world: World, table: Table, seekers: Seekers, out: np.ndarray, first: int) -> None:
    out[:, first] = 1.0 / (1.0 + seekers.nearest(world.table("wolf"), 5.0)[1])


def main() -> None:
    world = World((50.0, 50.0), seed=1)
    world.add_table("sheep", Position, Metabolism, Wool)
    world.add_system(GrowWool())
    world.spawn("sheep", Position(x=1.0, y=2.0), Wool(length=0.5), n=3)
    world.run(2)
    wool = world.get(1, Wool)
    assert_type(wool, Wool)
    assert_type(wool.length, float)
    assert_type(wool.shorn, bool)
    assert_type(wool.colour, int)
    assert_type(world.get(1, Metabolism).energy, float)
    assert_type(World.from_config("predator-prey", seed=1, learn=False, record=False), World)
    assert_type(world.copy(), World)
    print(ecs_eco.components.Metabolism, ecs_eco.learning.PPO, Metabolise, wool.whorl.shape)
    check_component(Wool)
    check_system(GrowWool, lambda threads: world)
'''


MYPY = """
[mypy]
strict = True
follow_imports = silent
allow_untyped_defs = True
allow_untyped_calls = True
[mypy-wool_lab.*,lightning,test_*]
allow_untyped_defs = False
allow_untyped_calls = False
[mypy-torch.*,matplotlib.*,pyarrow.*,scipy.*,numba.*,optuna.*]
follow_imports = skip
ignore_missing_imports = True
"""  # the kernels of a world's own file need no annotations; the package is as silent as an installed one


@pytest.mark.slow
def test_own_components_systems_worlds_and_all_templates_pass_strict_mypy_and_slips_in_them_do_not(tmp_path):
    wrong = HERD.replace("length=0.5", "length='long'").replace("learn=False", "lern=False")
    for name, text in {"herd.py": HERD, "wrong.py": wrong, "mypy.ini": MYPY}.items():
        (tmp_path / name).write_text(text)
    new_package(tmp_path / "wool-lab")
    new_world(tmp_path / "isle")
    command = [
        sys.executable,
        "-m",
        "mypy",
        "--no-error-summary",
        "--cache-dir",
        str(tmp_path / "cache"),
        "herd.py",
        "wrong.py",
        "wool-lab/src/wool_lab",
        *map(str, [*tmp_path.glob("wool-lab/tests/*.py"), *tmp_path.glob("isle/*.py")]),
    ]
    done = subprocess.run(
        command,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=500,
        check=False,
        env=os.environ | {"MYPYPATH": f"{ROOT}:wool-lab/src:isle"},
    )
    found = [line for line in done.stdout.splitlines() if ": error: " in line]
    assert sorted(line.partition(": error: ")[2] for line in found) == [
        'Argument "length" to "Wool" has incompatible type "str"; expected "float"  [arg-type]',
        'Unexpected keyword argument "lern" for "from_config" of "World"; did you mean "learn"?  [call-arg]',
    ], done.stdout + done.stderr
    assert all(line.startswith("wrong.py") for line in found)


@pytest.mark.skipif(shutil.which("pyright") is None, reason="needs pyright")
def test_components_systems_and_worlds_of_users_pass_pyright(tmp_path):
    (tmp_path / "herd.py").write_text(HERD)
    how = f'{{"extraPaths": ["{ROOT}"], "typeCheckingMode": "strict"}}'
    (tmp_path / "pyrightconfig.json").write_text(how)
    done = subprocess.run(
        ["pyright", "--pythonpath", sys.executable, "herd.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.stdout.startswith("0 errors"), done.stdout


def test_a_field_that_is_annotated_for_type_checkers_is_the_same_column():
    scope = {"__name__": "herd"}
    exec(HERD, scope)
    wool = scope["Wool"]
    assert repr(wool.fields["whorl"][0]) == "float32[3]"
    assert wool.fields["colour"][0].limits == (0, 9)
    check_component(wool)
    assert column(f32, "genes").shape == ("genes",)
    assert repr(column(u8)) == "uint8"

    @component
    class Plain:
        """The same as people write it who use no type checker."""

        colour: u8.within(0, 9) = 3
        whorl: f32[3] = 0.0

    assert Plain.fields["colour"][0].limits == wool.fields["colour"][0].limits
    assert np.array_equal(Plain(whorl=[1, 2, 3]).whorl, [1, 2, 3])


@pytest.mark.slow
def test_a_package_says_what_it_has_before_anything_of_it_is_loaded():
    code = """if True:
        import sys, ecs_eco
        names = [n for n in dir(ecs_eco) if not n.startswith("_")]
        heavy = [m for m in ("numpy", "numba", "torch", "pydantic") if m in sys.modules]
        print(sorted(ecs_eco.__all__) == names, heavy)
        print(all(hasattr(ecs_eco, n) for n in names), ecs_eco.components.Metabolism.__name__)
        import ecs_eco.config, ecs_eco.genomes, ecs_eco.learning, ecs_eco.record, ecs_eco.systems
        for room in (ecs_eco.config, ecs_eco.genomes, ecs_eco.learning, ecs_eco.record, ecs_eco.systems):
            assert [n for n in dir(room) if not n.startswith("_")] == sorted(room.__all__), room
            assert all(hasattr(room, n) for n in room.__all__), room
    """
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert done.stdout.splitlines() == ["True []", "True Metabolism"]


def test_a_name_that_is_not_there_is_refused_with_those_that_are():
    with pytest.raises(AttributeError, match=r"ecs_eco has no 'Wrld'; it has World.*components"):
        _ = ecs_eco.Wrld


@pytest.mark.parametrize(
    ("method", "does"),
    [(World.from_config, build), (World.restore, checkpoint.restore), (World.copy, checkpoint.copy)],
)
def test_arguments_are_written_out_and_are_those_of_what_does_the_work(method, does):
    front, behind = (inspect.signature(f).parameters for f in (method, does))
    assert not any(p.kind is p.VAR_KEYWORD for p in front.values())
    named = {name: p.default for name, p in front.items() if p.kind is p.KEYWORD_ONLY}
    if does is build:
        assert named.pop("record") is True  # the recorder is World's own
    assert named == {name: p.default for name, p in behind.items() if p.kind is p.KEYWORD_ONLY}
    fork, copy = (inspect.signature(f).parameters for f in (World.fork, World.copy))
    assert [*fork] == ["self", "seed", *[name for name in copy if name != "self"]]


def test_the_package_says_that_it_has_types():
    assert (Path(ecs_eco.__path__[0]) / "py.typed").is_file()
