import os
import subprocess
import sys
import threading

import numpy as np
import pytest
import torch

from ecs_eco.compiled.threads import in_parallel, one_blas_thread

NUMBERS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")

UPDATES = """
import hashlib, sys
import numpy as np
from ecs_eco.learning import PPO, Brain
from ecs_eco.compiled.workers import Workers
from ecs_eco.learning.ppo import Learner

def learn(n, workers):
    "Let a population of n learn twelve times; a digest of the weights after each update."
    brain, rng, rows, digests = Brain(24, (3, 3), seed=1), np.random.default_rng(0), np.arange(n), []
    split = Workers(workers).split
    learner = Learner(brain, PPO(horizon=2, minibatch_size=4096, epochs=1), seed=2, workers=workers)
    for _ in range(12):
        for _ in range(2):
            x = rng.standard_normal((n, 24), dtype=np.float32)
            values = brain.forward(x, split)[1]
            learner.rollout.store(rows, x, rng.integers(0, 3, (n, 2)), np.full(n, -2.2, np.float32), values)
            learner.rollout.credit(rows, rng.standard_normal(n, dtype=np.float32))
        learner.update(rows, values)
        digests.append(hashlib.sha256(brain.weights.tobytes()).hexdigest())
    return digests

for step in sys.argv[1].split():
    digests = learn(3000 if step[0] == "L" else 50, int(step[1:]))
print("\\n".join(digests))
"""

PRODUCTS = """
import hashlib
import numpy as np
from ecs_eco.genomes import fit_network
from ecs_eco.learning import Brain

for array in Brain(495, (3,), hidden=(197, 200), seed=1).state().values():
    print(hashlib.sha256(array.tobytes()).hexdigest())
fitted = fit_network(lambda x: x[:, :1] - x[:, 1:2], 40, -1, 1, hidden=(256,), steps=20)
print(hashlib.sha256(fitted.weights.tobytes()).hexdigest())
"""

WORLDS = """
from ecs_eco import World
from ecs_eco.config import load

for kind in ("shared", "individual"):
    for threads in (1, 2):
        learns = {f"species.{name}.{key}": value for name in ("deer", "wolf")
                  for key, value in (("policy.kind", kind), ("ppo.horizon", 8))}
        config = load("predator-prey", learns | {"species.deer.count": 700})
        world = World.from_config(config, seed=1, policies="untrained", learn=True, threads=threads)
        world.run(20)
        print(kind, world.digest())
"""


def run_all(*jobs):
    """Run (code, argument, environment) in processes of their own, all at once; what each printed."""
    bare = {name: value for name, value in os.environ.items() if name not in NUMBERS}
    started = [
        subprocess.Popen(
            [sys.executable, "-c", code, argument], env=bare | environment, stdout=subprocess.PIPE, text=True
        )
        for code, argument, environment in jobs
    ]
    printed = [process.communicate()[0] for process in started]
    assert [process.returncode for process in started] == [0] * len(started)
    return printed


@pytest.mark.slow
def test_what_is_learnt_depends_neither_on_what_ran_before_nor_on_the_environment():
    alone, *others = run_all(
        (UPDATES, "L1", {"OMP_NUM_THREADS": "1"}),
        (UPDATES, "s1 s2 s1 L2", {}),
        (UPDATES, "s2 s1 L2", {"OMP_NUM_THREADS": "2"}),
        (UPDATES, "s1 s2 s1 L2 s3 s1 L2", {"OMP_NUM_THREADS": "4", "MKL_NUM_THREADS": "3"}),
        (UPDATES, "s1 s3 s1 L3", {"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "2"}),
    )
    assert others == [alone] * len(others)


@pytest.mark.slow
def test_drawn_and_fitted_networks_do_not_depend_on_the_environment():
    first, *others = run_all(
        *[(PRODUCTS, "", {"OMP_NUM_THREADS": n}) for n in ("1", "2", "4")], (PRODUCTS, "", {})
    )
    assert others == [first] * len(others)


@pytest.mark.slow
def test_worlds_that_learn_do_not_depend_on_the_environment():
    first, *others = run_all(*[(WORLDS, "", {"OMP_NUM_THREADS": n}) for n in ("1", "2", "4")])
    assert others == [first] * len(others)
    assert len(set(first.splitlines())) == 2, "threads of the world make a difference"


@pytest.fixture
def three_torch_threads():
    before = torch.get_num_threads()
    torch.set_num_threads(3)
    yield
    torch.set_num_threads(before)


def number_in_a_new_thread():
    seen = []
    thread = threading.Thread(target=lambda: seen.append(torch.get_num_threads()))
    thread.start()
    thread.join()
    return seen[0]


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_work_has_one_torch_thread_and_the_users_number_stays(three_torch_threads, workers):
    for _ in range(3):
        seen = [0] * workers

        def note(worker, seen=seen):
            seen[worker] = torch.get_num_threads()

        in_parallel(note, workers)
        assert seen == [1] * workers
        assert (torch.get_num_threads(), number_in_a_new_thread()) == (3, 3)
        torch.set_num_threads(3)


def test_the_number_of_torch_threads_comes_back_after_an_error(three_torch_threads):
    def fail(worker):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        in_parallel(fail, 1)
    assert torch.get_num_threads() == 3


def test_an_error_in_one_thread_waits_for_the_others():
    began, ended = threading.Event(), []

    def work(worker):
        if worker == 0:
            began.wait()
            raise ValueError("the first")
        began.set()
        ended.append(float(np.sort(np.random.default_rng(1).random(300_000))[0]))

    with pytest.raises(ValueError, match="the first"):
        in_parallel(work, 2)
    assert len(ended) == 1


def test_linear_algebra_has_one_thread_and_the_users_number_comes_back():
    from threadpoolctl import threadpool_info, threadpool_limits

    def numbers():
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    with threadpool_limits(3, "blas"):
        with one_blas_thread(), one_blas_thread():
            assert numbers() == {1}
        assert numbers() == {3}
