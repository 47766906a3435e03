"""Some wild states of studies/wild_states.py, which has the rest,
in a process whose kernels are compiled with bounds checks."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ecs_eco.engine.errors import CheckpointError
from studies.common import wild

ROOT = Path(__file__).parents[2]
STATES = """
import json, sys
from studies import wild_states
print(json.dumps(wild_states.run({"states": 36}, {"source": sys.argv[1], "seed": 7})))
"""


@pytest.mark.slow
@pytest.mark.parametrize("world", ["herd", "menagerie"])
def test_no_kernel_leaves_its_arrays_in_wild_states(world):
    environment = {k: v for k, v in os.environ.items() if k != "ECS_ECO_DEBUG"} | {"NUMBA_BOUNDSCHECK": "1"}
    done = subprocess.run(
        [sys.executable, "-c", STATES, world], cwd=ROOT, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    content = json.loads(done.stdout.splitlines()[-1])
    assert content["failures"] == []
    for way in wild.WAYS:
        assert sum(content["kinds"][way].values()) >= 6
        assert {"refused", "ran"} & set(content["kinds"][way])


@pytest.mark.parametrize(
    ("error", "way", "kind"),
    [
        (IndexError("index is out of bounds"), "within a tick", "out of bounds"),
        (KeyError("x"), "columns", "traceback"),
        (ValueError("negative dimensions"), "spawn", "traceback"),
        (ValueError("moss, uid 2: Position.x is nan; expected: 0 to 9 m"), "columns", "refused"),
        (ValueError("negative dimensions"), "within a tick", "stopped with an error"),
        (CheckpointError("something is wrong"), "checkpoint", "refused without a location"),
        (CheckpointError("/tmp/odd.safetensors: uid 2 occurs twice"), "checkpoint", "refused"),
    ],
)
def test_what_became_of_a_state_is_told_by_its_error(error, way, kind):
    assert wild._kind(error, way)["kind"] == kind
