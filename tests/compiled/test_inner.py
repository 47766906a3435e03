"""Functions that only other kernels call: bitcode, to be linked into these."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.numba_private import Linked
from ecs_eco.compiled.numba_version import plain

pytestmark = pytest.mark.skipif(plain(), reason="public numba compiles")


@njit
def root(x):
    if x < 0:
        raise ValueError("a root of less than nothing", x)
    return np.sqrt(x)


@njit
def factorial(n):
    return 1 if n < 2 else n * factorial(n - 1)


@njit
def roots(array):
    total = 0.0
    for i in range(len(array)):
        total += root(array[i])
    return total


@njit
def factorials(n):
    total = 0
    for i in range(n):
        total += factorial(i)
    return total


PAIR = """
@njit
def called(x):
    return np.sqrt(x)

@njit
def outer(array):
    return called(array[0]) + called(array[1])
"""

SCRIPT = """
import numpy as np
from inner_kept import roots, factorials
from ecs_eco.compiled.jit import njit

@njit
def twice(array):  # without a file: compiled in each process, with what is kept of `root`
    return 2 * roots(array)

print(twice(np.array([4.0, 9.0])), factorials(5), len(roots.inner.overloads))
try:
    twice(np.array([-1.0]))
except ValueError as error:
    print(error.args)
"""


def test_a_function_that_kernels_call_has_no_machine_code():
    compiled = {"np": np, "njit": njit}
    exec(PAIR, compiled)  # without a file, so that nothing of it is kept from another run
    assert compiled["outer"](np.array([4.0, 9.0])) == 5
    (form,) = compiled["called"].inner.overloads.values()
    assert isinstance(form.library, Linked)
    assert form.library.get_pointer_to_function(form.fndesc.llvm_func_name) == 0
    (form,) = compiled["outer"].overloads.values()
    assert not isinstance(form.library, Linked)


def test_one_that_calls_itself_is_linked():
    assert factorials(6) == 1 + 1 + 2 + 6 + 24 + 120


def test_an_error_comes_out_of_it_with_its_arguments():
    with pytest.raises(ValueError, match="less than nothing") as caught:
        roots(np.array([4.0, -9.0]))
    assert caught.value.args == ("a root of less than nothing", -9.0)


@pytest.mark.slow
def test_what_another_process_kept_is_linked_into_new_kernels(tmp_path):
    source = Path(__file__).read_text(encoding="utf-8").partition("PAIR =")[0]
    (tmp_path / "inner_kept.py").write_text(source, encoding="utf-8")
    environment = os.environ | {
        "ECS_ECO_CACHE": str(tmp_path / "cache"),
        "PYTHONPATH": os.pathsep.join([str(tmp_path), *filter(None, sys.path)]),
    }
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, done.stderr
        assert done.stdout.splitlines() == ["10.0 34 1", "('a root of less than nothing', -1.0)"]
    kept = {path.name.partition("-")[0] for path in (tmp_path / "cache").rglob("*.nbc")}
    assert {"inner_kept.root", "inner_kept.roots", "inner_kept.factorial"} <= kept
