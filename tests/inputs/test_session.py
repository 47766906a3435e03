"""Classes and functions of a notebook, or of another interactive session."""

import linecache
import sys
from types import ModuleType

import numpy as np
import pytest
from numba import njit

from ecs_eco import System, World, component, f32
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.inputs.session import source_of
from ecs_eco.record import run_to_folder
from ecs_eco.runs.repeat import repeat

WOOL = '''
@component
class Wool:
    """Coat."""
    length: f32 = 0.01
'''
GROW = """
class Grow(System):
    needs = (Wool,)
    def update(self, table, world):
        table[Wool].length[table.alive] += np.float32(0.001)
"""


class Session:
    """Runs cells as IPython does."""

    def __init__(self, main):
        self.main, main.In = main, [""]

    def run(self, cell):
        file = f"<cell {len(self.main.In)}>"
        self.main.In.append(cell)
        linecache.cache[file] = len(cell), None, cell.splitlines(keepends=True), file
        exec(compile(cell, file, "exec"), vars(self.main))

    def world(self):
        return World.from_config(
            {
                "format": 1,
                "name": "fold",
                "space": {"size": [9.0, 9.0]},
                "systems": [self.main.Grow],
                "species": {"ewe": {"count": 3, "body": {"radius": 0.3}, "components": [self.main.Wool]}},
            }
        )


@pytest.fixture
def session(monkeypatch):
    main = ModuleType("__main__")
    main.__file__ = "/usr/lib/ipykernel_launcher.py"  # that of a notebook's kernel
    vars(main).update(System=System, component=component, f32=f32, np=np)
    monkeypatch.setitem(sys.modules, "__main__", main)
    monkeypatch.setattr("ecs_eco.inputs.code._loaded", {})  # modules of another session
    session = Session(main)
    session.run(WOOL)
    session.run(GROW)
    return session


def test_the_source_of_a_class_is_that_of_its_cell(session):
    assert source_of("Wool") == WOOL.strip()
    assert source_of("Grow") == GROW.strip()
    session.run("def Grow(): pass\nx = 1")
    assert source_of("Grow") == "def Grow(): pass"
    assert [source_of(name) for name in ("np", "x", "System", "none")] == [None] * 4


def test_without_cells_a_class_is_what_it_was_compiled_to(session):
    session.main.In = []
    linecache.clearcache()
    first = source_of("Grow")
    exec(GROW, vars(session.main))
    assert source_of("Grow") == first
    exec(GROW.replace("0.001", "0.1"), vars(session.main))
    assert source_of("Grow") != first


@pytest.mark.parametrize(
    ("cell", "names"),
    [
        (GROW.replace("0.001", "0.1"), ["Grow"]),
        (WOOL.replace("0.01", "0.5"), ["Grow", "Wool"]),
    ],  # Grow reads Wool
)
def test_a_class_of_a_notebook_that_changed_is_refused_by_name(session, tmp_path, cell, names):
    world = session.world().run(2)
    path = world.save(tmp_path / "fold.safetensors")
    assert World.restore(path).run(2).digest() == world.run(2).digest()
    session.run(cell)
    with pytest.raises(
        CheckpointError, match=f"__main__:{names[-1]}, or what it reads, has changed: .*trust=True"
    ):
        World.restore(path)
    with pytest.warns(UserWarning, match="has changed; using the current version") as warned:
        World.restore(path, trust=True)
    assert sorted(str(one.message).partition("__main__:")[2].partition(",")[0] for one in warned) == names


@pytest.mark.parametrize(
    "cell",
    [
        "RATE = 0.5",
        "class Base(System):\n    needs = (Wool,)\n",
        "def growth():\n    return np.float32(9.0)",
        "@njit\ndef kernel(rate):\n    return 2 * rate",
    ],
)
def test_a_class_whose_base_helper_or_constant_changed_is_refused(session, tmp_path, cell):
    vars(session.main).update(njit=njit)
    session.run("RATE = 0.001\ncalls = []")
    session.run("@njit\ndef kernel(rate):\n    return rate")
    session.run("def growth():\n    calls.append(1)\n    return [np.float32(kernel(RATE)) for _ in 'x'][0]")
    session.run(GROW.replace("Grow", "Base").replace("np.float32(0.001)", "growth()"))
    session.run("class Grow(Base):\n    pass")
    path = session.world().run(2).save(tmp_path / "fold.safetensors")
    session.run("x = 3")
    World.restore(path)
    session.run(cell)
    with pytest.raises(CheckpointError, match="__main__:Grow, or what it reads, has changed"):
        World.restore(path)


def test_a_recording_of_a_notebook_names_the_classes_that_are_missing_elsewhere(session, tmp_path):
    run_to_folder(session.world().config, ticks=2, out=tmp_path / "run", report=False)
    assert repeat(tmp_path / "run")["same"]
    del session.main.Grow
    with pytest.raises(Exception, match="needs code that is missing here: __main__:Grow"):
        repeat(tmp_path / "run")
