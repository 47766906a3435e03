"""What a start and a tick may cost, as counts: no noise of a machine changes them.

A limit is today's number. Who lowers a number lowers its limit; who must raise one says why in the commit.
"""

from __future__ import annotations

import ast
import gc
import json
import os
import subprocess
import sys
import tracemalloc
from collections import Counter

import esper
import pytest

import ecs_eco
from ecs_eco import World
from ecs_eco.components import Body, Position
from ecs_eco.config import load
from tools import budget

PYTHON_CALLS, ALL_CALLS = 525, 847  # a tick of predator-prey: 860 animals, 4,500 plants; C's functions too
KERNELS = 38  # with types, that Python calls in 100 ticks of predator-prey
MODULES = 1011  # that a frozen run of predator-prey loads
BYTES_OF_COLUMNS = 70  # an organism with Position and Body
BYTES_KNOWN_TO_ESPER = 1  # an organism more, where esper has been asked for all numbers
BYTES_LOOKED_AT = 520  # an organism more, where esper's loop has looked at one component of each

FROZEN = """
import json, sys
from pathlib import Path
from ecs_eco.cli import app
from ecs_eco.compiled.kernel import Kernel

app(["run", "predator-prey", "--ticks", "100", "--seed", "1", "--no-learn", "--no-report", "--quiet",
     "--out", sys.argv[1]],
    standalone_mode=False)
print(json.dumps({"modules": sorted(sys.modules),
                  "kernels": [k.py_func.__module__ + "." + k.py_func.__name__ for k, _ in Kernel.calls]}))
"""


def told(code, folder):
    """What a process of its own prints in the end."""
    done = subprocess.run(
        [sys.executable, "-c", code, str(folder)],
        check=True,
        env=os.environ | {"PYTHONPATH": os.path.dirname(ecs_eco.__path__[0])},
        capture_output=True,
        text=True,
        timeout=600,
    )
    return json.loads(done.stdout.splitlines()[-1])


@pytest.fixture(scope="module")
def frozen(tmp_path_factory):
    """What a process holds after a run whose animals do not learn, without a report: the second one, where
    the first compiles."""
    folder = tmp_path_factory.mktemp("frozen")
    return [told(FROZEN, folder / str(number)) for number in range(2)][1]


@pytest.mark.slow
def test_a_frozen_run_loads_no_library_that_it_does_not_need(frozen):
    heavy = {
        "torch",
        "pandas",
        "matplotlib",
        "deap",
        "scipy.stats",
        "scipy.special",
        "scipy.linalg",
        "starlette",
        "IPython",
        "ray",
        "numba.np.linalg",
        "numba.np.arraymath",
    }
    assert heavy & set(frozen["modules"]) == set()


@pytest.mark.slow
def test_learning_with_the_built_in_network_loads_no_torch(tmp_path):
    code = FROZEN.replace('"--no-learn", ', "")
    assert code != FROZEN
    loaded = told(code, tmp_path / "run")["modules"]
    assert "ecs_eco.learning.ppo" in loaded
    assert "torch" not in loaded


@pytest.mark.slow
def test_a_report_loads_no_library_that_it_does_not_need(frozen, tmp_path):
    code = FROZEN.replace('"--no-report", ', "").replace('"100"', '"20"')
    assert code != FROZEN
    loaded = set(told(code, tmp_path / "run")["modules"])
    assert "matplotlib" in loaded  # there is one
    assert {"torch", "pandas", "scipy.stats", "IPython", "starlette"} & loaded == set()


@pytest.mark.slow
def test_a_frozen_run_loads_few_modules(frozen):
    assert len(frozen["modules"]) <= MODULES


@pytest.mark.slow
def test_a_frozen_run_calls_few_kernels(frozen):
    assert 10 < len(frozen["kernels"]) <= KERNELS, frozen["kernels"]


def test_a_tick_calls_few_python_functions():
    world = World.from_config(load("predator-prey"), seed=1, learn=False, record=False).run(20)
    calls, ticks = Counter(), 10

    def count(frame, event, argument):
        calls[event] += 1

    gc.collect()
    gc.disable()  # what it finds of other tests, and hypothesis's two calls around it, are not a tick's
    sys.setprofile(count)
    try:
        world.run(ticks)
    finally:
        sys.setprofile(None)
        gc.enable()
    assert calls["call"] / ticks <= PYTHON_CALLS
    assert (calls["call"] + calls["c_call"]) / ticks <= ALL_CALLS


def hares(n):
    world = World((100.0, 100.0))
    world.add_table("hare", Position, Body)
    world.spawn("hare", n=n)
    world.flush()
    return world


def look(world):
    """Ask esper for all numbers, then for a component of each; the bytes that Python and numpy hold then."""
    held = []
    with world:
        for ask in (lambda: len(list(esper.get_entities())), lambda: len(esper.get_component(Position))):
            assert ask() == world.tables["hare"].n
            esper.clear_cache()
            gc.collect()
            held.append(tracemalloc.get_traced_memory()[0])
    return held


@pytest.mark.slow
def test_an_animal_takes_few_bytes_and_few_more_for_esper():
    n = 8192
    tracemalloc.start()
    try:
        look(hares(n))  # loads kernels
        before = tracemalloc.get_traced_memory()[0]
        world = hares(n)
        gc.collect()
        columns = tracemalloc.get_traced_memory()[0]
        known, looked_at = look(world)
    finally:
        tracemalloc.stop()
    each = (columns - before) / n, (known - columns) / n, (looked_at - known) / n
    assert each[0] <= BYTES_OF_COLUMNS, each
    assert each[1] <= BYTES_KNOWN_TO_ESPER, each
    assert each[2] <= BYTES_LOOKED_AT, each


def test_the_package_weighs_no_more_than_its_budget():
    over = [
        f"{table}, {name}: {number:,}, at most {limit}"
        for table, name, number, limit in budget.rows()
        if limit is None or number > limit
    ]
    assert over == [], "lower them, or say why in CHANGELOG.md and run python tools/budget.py --write"


def test_kernels_calls_and_stays_of_a_configuration_are_counted(monkeypatch):
    text = (
        "@njit(cache=True)\ndef burn(a, b):\n    import os\n\n\ndef check(config: Any, other: int) -> Any:\n"
    )
    text += "    return burn(config, other)\n"
    trees = {"ecs_eco/a.py": ast.parse(text)}
    assert budget.kernels(trees) == {"kernels": 1, "arguments": 2, "with 15 or more": 0, "most arguments": 2}
    assert list(budget.configuration(trees).values()) == [1, 1, 1]
    assert budget.anys(trees["ecs_eco/a.py"]) == 1
    assert budget.late_imports(trees["ecs_eco/a.py"]) == 1
    assert budget.lines({"ecs_eco/a.py": text, "ecs_eco/b/c.py": "x = 1\n"}) == {
        "all": 6,
        "b": 1,
        "files at the top": 5,
    }
