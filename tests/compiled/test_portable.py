"""The portable mode: what it fixes, what it refuses, and that no environment changes its results."""

import json
import os
import subprocess
import sys

import pytest

from ecs_eco.compiled import portable

CHILD = """
import json
import ecs_eco, os
from ecs_eco import World
from ecs_eco.compiled import elementary, jit, portable
from ecs_eco.learning.arithmetic import tanh
from numba.core.registry import cpu_target
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
world = World.from_config({
    "format": 1, "name": "small", "space": {"size": [20.0, 20.0]}, "species": {"deer": {
        "count": 40, "body": {"radius": 0.5}, "metabolism": {"energy": 1.0, "basal": 0.001},
        "locomotion": {"speed": {"still": 0.0, "walk": 1.0}, "cost": {"walk": 0.02}, "turn": 0.5},
        "actions": {"speed": ["still", "walk"], "turn": ["left", "none", "right"]},
        "neutral": {"speed": "still", "turn": "none"},
        "sensors": [{"kind": "nearest", "target": "deer", "radius": 6.0}],
        "happiness": {"formula": "exp(-deer_near) + deer_near ** 1.7", "minimum": -1.0},
        "policy": {"kind": "shared"}, "ppo": {"horizon": 4}}}}, seed=3, record=False)
print(json.dumps({
    "codegen": cpu_target.target_context.codegen().magic_tuple()[1:], "folder": jit.FOLDER.path.name,
    "fastmath": str(tanh.targetoptions["fastmath"]),
    "numpy": [n for n in __cpu_dispatch__ if __cpu_features__[n]],
    "sin": float(elementary.arrays.sin(1e22)), "digests": [world.digest(), world.run(9).digest()],
    "target": portable.target()}))
"""
LESSER = {
    "NUMBA_CPU_NAME": "nehalem",
    "NUMBA_CPU_FEATURES": "",
    "MKL_ENABLE_INSTRUCTIONS": "SSE4_2",
    "ATEN_CPU_CAPABILITY": "default",
    "NPY_DISABLE_CPU_FEATURES": "",
    "MKL_CBWR": "AUTO",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-AVX2,-FMA",
}


def child(mode, **variables):
    environment = {**os.environ, portable.VARIABLE: mode, **variables}
    done = subprocess.run(
        [sys.executable, "-c", CHILD], env=environment, capture_output=True, text=True, timeout=580
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.slow  # kernels are compiled for other processors where no cache has them
def test_two_processors_give_the_same_bytes_and_in_the_native_mode_others():
    here, there = child("1"), child("1", **LESSER)
    assert here == there
    assert here["codegen"] == [portable.CPU, ""]
    assert here["fastmath"] == "False"
    assert here["numpy"] == []
    assert here["folder"].startswith("kernels-portable-")
    assert here["target"] == {"mode": "portable", "cpu": portable.CPU}
    native = child("0")
    assert native["digests"][1] != here["digests"][1]
    assert native["folder"] != here["folder"]
    assert "portable" not in native["folder"]
    assert native["target"]["mode"] == "native"


def test_a_job_script_gets_all_that_a_process_needs():
    variables = portable.variables()
    assert variables[portable.VARIABLE] == "1"
    assert variables["NUMBA_CPU_NAME"] == portable.CPU
    assert all(isinstance(value, str) for value in variables.values())


def test_a_word_that_is_neither_0_nor_1_is_refused(monkeypatch):
    monkeypatch.setenv(portable.VARIABLE, "yes")
    with pytest.raises(portable.PortableError, match=r"ECS_ECO_PORTABLE=yes: expected 1"):
        portable.check()


def test_another_machine_than_x86_64_is_refused(monkeypatch):
    monkeypatch.setattr(portable, "_on", True)
    monkeypatch.setattr(portable.platform, "machine", lambda: "aarch64")
    with pytest.raises(portable.PortableError, match="aarch64"):
        portable.check()


def test_interpreted_kernels_are_refused(monkeypatch):
    monkeypatch.setattr(portable, "_on", True)
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    with pytest.raises(portable.PortableError, match="NUMBA_DISABLE_JIT"):
        portable.check()


def test_numpy_that_was_loaded_before_is_told_with_what_helps(monkeypatch):
    monkeypatch.setattr(portable, "_on", True)
    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)
    monkeypatch.setattr(portable, "_numpys_own", lambda: ["X86_V3"])
    with pytest.raises(portable.PortableError) as refused:
        portable.check()
    assert "uses X86_V3: import ecs_eco first" in str(refused.value)
    assert "NPY_DISABLE_CPU_FEATURES='" in str(refused.value)


def test_what_is_of_the_other_mode_is_told_and_what_is_older_is_native(monkeypatch):
    assert portable.other_mode({"target": {"mode": "native"}}) == portable.other_mode({}) == ""
    assert "ecs-eco --portable" in portable.other_mode({"target": {"mode": "portable"}})
    monkeypatch.setattr(portable, "_on", True)
    assert "native mode" in portable.other_mode({})
