"""The first start: what two processes compile, and that neither does what the other has done."""

import os
import subprocess
import sys
import threading
import time

import pytest

from ecs_eco.compiled import jit, signatures
from ecs_eco.compiled.kernel import Kernel
from ecs_eco.compiled.kernel_folder import CLAIM, Folder
from ecs_eco.compiled.numba_version import plain
from ecs_eco.config.shipped import shipped
from ecs_eco.engine.processes import python
from ecs_eco.worlds import first_start
from tools import make_kernels

pytestmark = pytest.mark.skipif(plain(), reason="public numba compiles, and no list says what")

KERNEL = """
from ecs_eco.compiled.jit import njit


@njit
def triple(x):
    return 3 * x


@njit
def quarter(x):
    return x / 4
"""


@pytest.fixture
def two_kernels(tmp_path, monkeypatch):
    """A module with two kernels, a list of them, and an empty cache."""
    monkeypatch.setattr(jit, "FOLDER", Folder(tmp_path / "cache" / "kernels-1"))
    (tmp_path / "two_kernels.py").write_text(KERNEL)
    monkeypatch.syspath_prepend(tmp_path)
    listed = tmp_path / "kernels.txt"
    listed.write_text(
        "# worlds: meadow, sea\n0,1\ttwo_kernels:triple\tfloat64\n"
        "1\ttwo_kernels:quarter\tfloat64\n1\ttwo_kernels:gone\tfloat64\n"
    )
    monkeypatch.setattr(first_start, "LIST", listed)
    yield tmp_path / "cache" / "kernels-1"
    sys.modules.pop("two_kernels", None)


def test_the_list_names_worlds_that_are_shipped_and_kernels_that_are_there():
    head = first_start.LIST.read_text(encoding="utf-8").splitlines()[0]
    assert set(head.removeprefix("# worlds: ").split(", ")) <= set(shipped())
    assert make_kernels.check() == 0
    assert len(first_start.listed("predator-prey")) > 20


def test_a_world_of_ones_own_gets_what_most_worlds_call(two_kernels):
    names = [function for function, _ in first_start.listed("sea")]
    assert names == ["two_kernels:triple", "two_kernels:quarter", "two_kernels:gone"]
    assert first_start.listed("others") == [("two_kernels:triple", "float64")]


def test_what_is_listed_is_compiled_once_and_what_is_gone_stops_nothing(two_kernels):
    def made():
        return {path: path.stat().st_mtime_ns for path in two_kernels.glob("*.nbc")}

    first_start.compile_listed(["sea"], backwards=True)
    kept = made()
    assert len(kept) == 2
    assert (two_kernels / "sea.warm").exists()
    first_start.compile_listed(["sea"])
    assert made() == kept


@pytest.mark.slow
def test_a_second_process_compiles_what_the_first_has_not_and_takes_no_modules_of_the_folder(
    two_kernels, tmp_path, monkeypatch
):
    monkeypatch.setenv("ECS_ECO_CACHE", str(tmp_path / "others"))
    (tmp_path / "numba.py").write_text("raise SystemExit('hidden')")
    monkeypatch.chdir(tmp_path)
    code = first_start._HELPER.replace(
        "help_on(",
        "from ecs_eco.worlds import first_start; "
        f"first_start.LIST = first_start.Path({str(first_start.LIST)!r}); "
        f"sys.path.append({str(tmp_path)!r}); help_on(",
    )
    done = subprocess.run(
        python(code, "share", "1", "2", "sea"), capture_output=True, text=True, env=without_path()
    )
    assert done.returncode == 0, done.stderr
    (folder,) = (tmp_path / "others").iterdir()
    assert len(list(folder.glob("*.nbc"))) == 2


def without_path():
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def test_a_kernel_that_another_process_compiles_is_waited_for(two_kernels):
    two_kernels.mkdir(parents=True)
    jit.FOLDER.shared = True
    kernel = first_start.kernel_of("two_kernels:triple")
    assert isinstance(kernel, Kernel)
    signature = signatures.read("float64")
    assert not kernel.known(signature)
    claim = kernel.kept._path(signature, kernel.targetctx.codegen()).with_suffix(CLAIM)
    claim.write_text(str(os.getppid()))
    assert kernel.known(signature)
    ended = []
    threading.Timer(0.3, lambda: (ended.append(time.monotonic()), claim.unlink())).start()
    assert kernel(2.0) == 6
    assert ended
    assert time.monotonic() >= ended[0]


def test_the_claim_of_a_process_that_has_ended_stops_nobody(two_kernels):
    two_kernels.mkdir(parents=True)
    jit.FOLDER.shared = True
    kernel = first_start.kernel_of("two_kernels:triple")
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    claim = kernel.kept._path(signatures.read("float64"), kernel.targetctx.codegen()).with_suffix(CLAIM)
    claim.write_text(str(ended.pid))
    assert kernel(2.0) == 6
    assert not claim.exists()


def test_only_kernels_that_this_process_compiles_are_counted(two_kernels):
    two_kernels.mkdir(parents=True)
    (two_kernels / f"meadow{first_start.MARK}").touch()
    with first_start.two_processes("meadow") as kernels:
        (two_kernels / "of_another_process.nbc").touch()
        assert first_start.kernel_of("two_kernels:triple")(2.0) == 6
    assert kernels.number == 1
    assert "1 kernel compiled" in str(kernels)
