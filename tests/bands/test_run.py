import json

import pytest

from ecs_eco.runs.run import run_to_folder

MAIN = "from ecs_eco.cli import main; main()"
FEW = ["--set", "species.green.count=300", "--set", "species.goat.count=120", "--quiet", "--no-report"]
FAULT = """
import sys
from mpi4py import MPI
from ecs_eco import World
from ecs_eco.bands.run import together

def lead(prepare):
    world = build()
    prepare(world)
    if sys.argv[1] == "error":
        world.before_tick.append(lambda: 1 / (3 - world.tick))
    if sys.argv[1] == "stop":
        world.before_tick.append(lambda: world.tick == 3 and world.stop())
    world.run(20)
    print("ended at", world.tick, flush=True)

def build():
    world = World.from_config("lamb", seed=MPI.COMM_WORLD.rank if sys.argv[1] == "other" else 1, record=False)
    return world

together(lead, build, 20)
"""


@pytest.mark.slow
def test_a_run_in_bands_leaves_the_folder_that_one_process_would_leave(mpirun, tmp_path):
    ended = mpirun(2, MAIN, "run", "reflexes", "--bands", "--ticks", "12", "--out", "two", *FEW)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "2 processes, the same world in all" in ended.stdout
    of_two = json.loads((tmp_path / "two" / "manifest.json").read_text())
    of_one = run_to_folder({**of_two["config"]}, of_two["seed"], 12, tmp_path / "one", report=False)
    assert of_two["finished"]
    assert of_two["digest"] == of_one["digest"]


@pytest.mark.slow
@pytest.mark.parametrize(("case", "code", "text"), [
    ("error", 1, "ZeroDivisionError"), ("other", 1, "2 processes have 2 different worlds"),
    ("stop", 0, "ended at 4")])
def test_what_ends_one_process_ends_all(mpirun, case, code, text):
    ended = mpirun(2, FAULT, case, timeout=120)
    assert ended.returncode == code, ended.stdout + ended.stderr
    assert text in ended.stdout + ended.stderr


@pytest.mark.slow
def test_a_wrong_world_is_refused_once(mpirun):
    ended = mpirun(2, MAIN, "run", "reflexs", "--bands", timeout=120)
    assert ended.returncode == 2
    assert ended.stderr.count('did you mean "reflexes"') == 1


def test_without_mpi_the_message_says_how_to_install_it(monkeypatch):
    import sys

    from ecs_eco.bands.bands import mpi
    from ecs_eco.engine.errors import ConfigError

    monkeypatch.setitem(sys.modules, "mpi4py", None)
    with pytest.raises(ConfigError, match=r"ecs-eco\[mpi\]"):
        mpi()
