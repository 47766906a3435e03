"""Processes of MPI for tests: skipped where mpi4py or an MPI library is missing."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import ecs_eco

ROOT = Path(ecs_eco.__path__[0]).parent


@pytest.fixture
def mpirun(tmp_path):
    """Run Python code in n processes; return what ended: its exit code, output and errors."""
    try:
        from mpi4py import MPI  # noqa: F401
    except (ImportError, RuntimeError) as error:
        pytest.skip(f"needs mpi4py and an MPI library: {error}")
    mpiexec = shutil.which("mpiexec", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    if mpiexec is None:
        pytest.skip("needs mpiexec")

    def run(n, code, *arguments, timeout=400):
        return subprocess.run(
            [mpiexec, "-n", str(n), sys.executable, "-c", code, *arguments],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )

    return run


class Alone:
    """A communicator of `size` processes of which one is there: for what needs no exchange."""

    def __init__(self, size, rank=0):
        self.size, self.rank = size, rank

    def Get_size(self):
        return self.size

    def Get_rank(self):
        return self.rank


@pytest.fixture
def alone():
    return Alone
