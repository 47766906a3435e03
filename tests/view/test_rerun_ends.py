"""A process ends at once, and with exit code 0, while a stretch of a recording is being run again beside it."""

import subprocess
import sys
import time

import pytest

from ecs_eco.config import load
from ecs_eco.record import run_to_folder

LEAVE = """
import sys, time
from pathlib import Path
import numpy as np
from ecs_eco.record.seal import read_manifest
from ecs_eco.view import rerun

path = Path(sys.argv[1])
again = rerun.Rerun(path, read_manifest(path), 10**9)
again.begin(1, 10**6, lambda tick: {"n": np.ones(1, int)})
while again.share == 0:
    time.sleep(0.01)
print("left", flush=True)
"""


@pytest.mark.slow
def test_a_process_ends_while_a_stretch_is_run_again(tmp_path):
    small = {"species.grass.count": 30, "species.deer.count": 5, "species.wolf.count": 2}
    run_to_folder(
        load("predator-prey", small),
        1,
        3,
        tmp_path / "run",
        policies="random",
        report=False,
        checkpoint_every=2,
    )
    start = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-c", LEAVE, str(tmp_path / "run")],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert (done.stdout, done.returncode) == ("left\n", 0), done.stderr[-2000:]
    assert time.monotonic() - start < 300  # a million ticks would take longer
