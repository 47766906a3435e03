"""Named tuples as arguments of kernels."""

import os
import subprocess
import sys
from typing import NamedTuple

import numpy as np
import pytest

from ecs_eco.compiled.jit import lone_njit, njit
from ecs_eco.compiled.kernel import Kernel, called_by_python
from ecs_eco.compiled.signatures import read, text
from ecs_eco.compiled.views import fields_of, views_of
from ecs_eco.compiled.workers import Workers


class Ring(NamedTuple):
    """A place of which the ends meet."""

    length: np.ndarray
    closed: bool


class Bodies(NamedTuple):
    """Bodies on it."""

    x: np.ndarray
    mass: np.ndarray


@njit
def wrapped(x: float, ring: Ring) -> float:
    """Return a place within the ring."""
    return x % ring.length[0] if ring.closed else x


@lone_njit
def weigh(first: int, last: int, ring: "Ring", mine: Bodies, factor: float, out: np.ndarray) -> None:
    """Write the mass of each times its place."""
    for i in range(first, last):
        out[i] = wrapped(mine.x[i], ring) * mine.mass[i] * factor


def some(n: int) -> tuple[Ring, Bodies, np.ndarray]:
    """Return a ring of ten, n bodies and their weights."""
    return Ring(np.full(1, 10.0), True), Bodies(np.arange(n) + 0.0, np.full(n, 2.0)), np.zeros(n)


def expected(n: int) -> np.ndarray:
    """Return what the kernel is to write."""
    return np.arange(n) % 10 * 2.0 * 3.0


def test_a_kernel_takes_named_tuples_and_gives_them_to_other_kernels() -> None:
    ring, mine, out = some(25)
    weigh(0, 25, ring, mine, 3.0, out)
    np.testing.assert_array_equal(out, expected(25))
    assert wrapped(12.0, ring) == 2.0
    assert weigh.__name__ == "weigh"
    assert weigh.__doc__ == "Write the mass of each times its place."


def test_arguments_may_be_named() -> None:
    ring, mine, out = some(4)
    weigh(first=0, last=4, ring=ring, mine=mine, factor=3.0, out=out)
    np.testing.assert_array_equal(out, expected(4))
    with pytest.raises(TypeError, match="argument"):
        weigh(0, 4, ring, mine)


@pytest.mark.parametrize("n", [100, 20_000])
def test_threads_share_a_kernel_that_takes_them(n: int) -> None:
    workers = Workers(2)
    ring, mine, out = some(n)
    try:
        workers.split(weigh, n, ring, mine, 3.0, out, work=n)
    finally:
        workers.end()
    np.testing.assert_array_equal(out, expected(n))


def test_its_types_are_those_of_the_fields_and_can_be_written_down() -> None:
    ring, mine, out = some(4)
    weigh(0, 4, ring, mine, 3.0, out)
    called = called_by_python(weigh)
    assert isinstance(called, Kernel)
    for types in weigh.signatures:
        assert len(types) == 8
        assert read(text(types)) == types


def test_views_are_found_by_annotation_alone() -> None:
    assert views_of(weigh.py_func) == {"ring": Ring, "mine": Bodies}
    assert views_of(len) == {}
    assert views_of(lambda ring: ring) == {}


def test_a_kernel_with_an_argument_that_may_be_left_out_takes_them_as_numba_does() -> None:
    @njit
    def longer(ring: Ring, times: float = 2.0) -> float:
        return ring.length[0] * times

    ring, _, _ = some(1)
    assert (longer(ring), longer(ring, 3.0)) == (20.0, 30.0)


def test_views_are_replaced_by_their_fields() -> None:
    ring, mine, _ = some(1)
    assert fields_of((1, ring, (2, 3), mine)) == (1, *ring, (2, 3), *mine)


PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])
from tests.compiled.test_views import some, weigh
from ecs_eco.compiled import jit
ring, mine, out = some(3)
weigh(0, 3, ring, mine, 3.0, out)
print(out.tolist(), jit.FOLDER.compiled)
"""


def test_it_is_kept_on_disk(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("ECS_ECO_CACHE", str(tmp_path))
    command = [sys.executable, "-c", PROGRAM, str(__file__).rpartition("/tests/")[0]]
    first, later = (
        subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(2)
    )
    assert first == "[0.0, 6.0, 12.0] 3\n"
    assert later == "[0.0, 6.0, 12.0] 0\n"


def test_they_are_taken_where_nothing_is_compiled() -> None:
    program = PROGRAM.replace(", jit.FOLDER.compiled", "")
    command = [sys.executable, "-c", program, str(__file__).rpartition("/tests/")[0]]
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout == "[0.0, 6.0, 12.0]\n"
