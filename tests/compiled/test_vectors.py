import json
import os
import subprocess
import sys

import numpy as np
import pytest

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.vectors import LANES, every, load, prefetch, store


@njit
def weigh(x, weights, out):
    """out = x + x * weights[1], 16 numbers at a time."""
    for at in range(0, x.size, LANES):
        numbers = load(x, at)
        store(out, at, numbers + numbers * every(weights, 1))


def test_vectors_compute_what_numpy_computes_to_the_bit():
    x = np.random.default_rng(1).normal(size=10 * LANES).astype(np.float32)
    weights, out = np.array([7.0, 0.3, 9.0], np.float32), np.empty_like(x)
    weigh(x, weights, out)
    np.testing.assert_array_equal(out, x + x * weights[1])


@njit
def blend(x, out):
    for at in range(0, x.size, LANES):
        prefetch(x, at + 1_000_000_000)
        numbers = load(x, at)
        store(out, at, np.float32(3) - numbers * np.float32(0.1) + np.float32(1) / numbers)


def test_numbers_meet_vectors_and_what_is_nowhere_may_be_prefetched():
    x = np.random.default_rng(1).normal(size=10 * LANES).astype(np.float32)
    out = np.empty_like(x)
    blend(x, out)
    np.testing.assert_array_equal(out, np.float32(3) - x * np.float32(0.1) + np.float32(1) / x)


def test_a_vector_is_read_and_written_where_it_says():
    x, out = np.arange(3 * LANES, dtype=np.float32), np.full(3 * LANES, -1, np.float32)
    weigh(x[5 : 5 + LANES], np.ones(2, np.float32), out[3 : 3 + LANES])
    np.testing.assert_array_equal(out[3 : 3 + LANES], 2 * x[5 : 5 + LANES])
    assert (out[:3] == -1).all()
    assert (out[3 + LANES :] == -1).all()


@pytest.mark.slow
def test_kernels_with_vectors_run_without_compilation_too():
    code = """
import numpy as np
from ecs_eco.learning.brain import Brain

brain = Brain(7, (3, 2), hidden=(9, 6), seed=1)
x = np.random.default_rng(1).normal(size=(70, 7)).astype(np.float32)
print(np.concatenate([brain.forward(x)[0].ravel(), brain.forward(x)[1]]).tolist())
"""
    said = []
    for off in "01":
        done = subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"NUMBA_DISABLE_JIT": off},
            capture_output=True,
            text=True,
            check=True,
        )
        said.append(json.loads(done.stdout))
    np.testing.assert_allclose(*said, rtol=1e-5, atol=1e-6)
