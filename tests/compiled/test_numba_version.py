"""Public numba alone, where its version was not tried or a variable says so: the same bytes, more slowly."""

import json
import os
import subprocess
import sys
import warnings

import pytest

from ecs_eco.compiled import numba_version
from ecs_eco.compiled.numba_version import TRIED, VARIABLE, plain, summary

WORLDS = [
    ("reflexes", False, {}),
    ("learning-krill", True, {}),
    ("predator-prey", True, {"policy.kind": "individual", "count": 150}),
]
CHILD = """
import json, sys
from ecs_eco import World
from ecs_eco.compiled import workers
from ecs_eco.config import load

workers.PARALLEL_FROM = 1
for name, learn, changes in json.loads(sys.argv[1]):
    changes = {f"species.{animal}.{key}": value for key, value in changes.items() for animal in ("deer", "wolf")}
    policies = "untrained" if changes else "trained"
    world = World.from_config(
        load(name, changes), seed=3, learn=learn, policies=policies, threads=2, record=False
    )
    print(name, world.run(60).digest())
compiled = {name.rpartition(".")[2] for name in sys.modules if name.startswith("ecs_eco.compiled")}
print(sorted({"plain", "kernel", "numba_private"} & compiled), file=sys.stderr)
"""


@pytest.fixture(autouse=True)
def asked_anew(monkeypatch):
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)
    plain.cache_clear()
    yield
    plain.cache_clear()


def installed(monkeypatch, number):
    monkeypatch.setattr(numba_version, "version", lambda name: number)


@pytest.mark.parametrize("number", [f"{TRIED[0]}.0", f"{TRIED[-1]}.7", f"{TRIED[-1]}.0rc1"])
def test_a_version_that_was_tried_compiles_with_private_names(monkeypatch, number):
    installed(monkeypatch, number)
    assert not plain()
    assert f"with numba's private names; tested with numba {TRIED[0]}" in summary()


@pytest.mark.parametrize("number", ["0.61.2", "0.680.0", "1.0.0"])
def test_an_untried_version_compiles_plainly_and_says_so_once(monkeypatch, number):
    installed(monkeypatch, number)
    with pytest.warns(
        RuntimeWarning, match=rf"numba {number} was not tested .* {TRIED[-1]} were.*{VARIABLE}=1"
    ):
        assert plain()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert plain()
        assert "public API only" in summary()


def test_the_variable_decides_whatever_the_version(monkeypatch):
    monkeypatch.setenv(VARIABLE, "1")
    assert plain()
    plain.cache_clear()
    installed(monkeypatch, "9.9.9")
    monkeypatch.setenv(VARIABLE, "0")
    assert not plain()
    plain.cache_clear()
    monkeypatch.setenv(VARIABLE, "yes")
    with pytest.raises(ValueError, match=f"{VARIABLE}=yes: expected 1"):
        plain()


def test_interpreted_kernels_need_nothing_private(monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    assert plain()


@pytest.mark.slow
@pytest.mark.parametrize(("portable", "worlds"), [("0", WORLDS), ("1", WORLDS[:1])])
def test_results_are_the_same_bytes(portable, worlds):
    digests = {}
    for by in ("0", "1"):
        done = subprocess.run(
            [sys.executable, "-c", CHILD, json.dumps(worlds)],
            env=os.environ | {VARIABLE: by, "ECS_ECO_PORTABLE": portable},
            capture_output=True,
            text=True,
            timeout=1500,
        )
        assert done.returncode == 0, done.stderr
        assert done.stderr.splitlines()[-1] == ("['plain']" if by == "1" else "['kernel', 'numba_private']")
        digests[by] = done.stdout.splitlines()
    assert len(digests["0"]) == len(worlds)
    assert digests["0"] == digests["1"]
