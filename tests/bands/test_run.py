import json

import pyarrow.parquet as pq
import pytest

from ecs_eco.record.seal import write_manifest
from ecs_eco.runs.run import resume, run_to_folder

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
    seed = MPI.COMM_WORLD.rank if sys.argv[1] == "other" else 1
    return World.from_config("innate", seed=seed, record=False)

together(lead, build, 20, state=sys.argv[2] == "divided")
"""


@pytest.mark.slow
def test_a_run_in_bands_leaves_the_folder_that_one_process_would_leave(mpirun, tmp_path):
    ended = mpirun(2, MAIN, "run", "reflexes", "--bands", "--ticks", "12", "--out", "two", *FEW)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "2 processes, each with the whole world" in ended.stdout
    of_two = json.loads((tmp_path / "two" / "manifest.json").read_text())
    of_one = run_to_folder({**of_two["config"]}, of_two["seed"], 12, tmp_path / "one", report=False)
    assert of_two["finished"]
    assert of_two["digest"] == of_one["digest"]


@pytest.mark.slow
def test_a_divided_run_leaves_the_records_of_one_process_and_goes_on_in_one(mpirun, tmp_path):
    ended = mpirun(
        2,
        MAIN,
        "run",
        "reflexes",
        "--divided",
        "--ticks",
        "24",
        "--checkpoint-every",
        "10",
        "--out",
        "two",
        *FEW,
        "--set",
        "species.goat.ppo.horizon=8",
        "--set",
        "species.goat.reproduction.age_min=5.0",
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "2 processes, each with its own part of the world" in ended.stdout
    of_two = json.loads((tmp_path / "two" / "manifest.json").read_text())
    of_one = run_to_folder(
        {**of_two["config"]}, of_two["seed"], 24, tmp_path / "one", report=False, checkpoint_every=10
    )
    assert of_two["finished"]
    assert of_two["digest"] == of_one["digest"]
    for kind in ("series", "births", "deaths", "snapshots", "actions", "learning"):
        one, two = (pq.read_table(tmp_path / run / kind).to_pydict() for run in ("one", "two"))
        assert one.keys() == two.keys()
        assert len(one["tick"]) == len(two["tick"]) > 0
        for column, values in one.items():  # sums of floats may differ in their last digits
            near = kind in ("series", "learning") and isinstance(values[0], float)
            assert two[column] == (pytest.approx(values, rel=1e-6, nan_ok=True) if near else values), column
    (tmp_path / "two" / "checkpoints" / "tick-000000000024.safetensors").unlink()
    write_manifest(tmp_path / "two", of_two | {"finished": False})  # as if it had been killed
    assert resume(tmp_path / "two", report=False)["digest"] == of_one["digest"]


@pytest.mark.slow
@pytest.mark.parametrize("how", ["--bands", "--divided"])
def test_a_run_is_resumed_by_another_number_of_processes(mpirun, tmp_path, how):
    first = mpirun(
        2,
        MAIN,
        "run",
        "reflexes",
        how,
        "--ticks",
        "12",
        "--out",
        "many",
        *FEW,
        "--set",
        "species.goat.ppo.horizon=8",
    )
    assert first.returncode == 0, first.stdout + first.stderr
    ended = mpirun(3, MAIN, "resume", "many", how, "--until", "24", "--quiet", "--no-report")
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "3 processes" in ended.stdout
    of_many = json.loads((tmp_path / "many" / "manifest.json").read_text())
    of_one = run_to_folder({**of_many["config"]}, of_many["seed"], 24, tmp_path / "one", report=False)
    assert (of_many["finished"], of_many["ticks"]) == (True, 24)
    assert of_many["digest"] == of_one["digest"]


@pytest.mark.slow
def test_a_fork_begins_in_one_process(mpirun, tmp_path):
    run_to_folder("innate", 1, 3, tmp_path / "run", report=False)
    ended = mpirun(2, MAIN, "resume", "run", "--bands", "--from-tick", "2", "--out", "new", timeout=120)
    assert ended.returncode == 2
    assert "a fork must start in one process" in ended.stderr


@pytest.mark.slow
@pytest.mark.parametrize("state", ["whole", "divided"])
@pytest.mark.parametrize(
    ("case", "code", "text"),
    [
        ("error", 1, "ZeroDivisionError"),
        ("other", 1, "2 processes have 2 different worlds"),
        ("stop", 0, "ended at 4"),
    ],
)
def test_what_ends_one_process_ends_all(mpirun, case, code, text, state):
    ended = mpirun(2, FAULT, case, state, timeout=120)
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
    with pytest.raises(ConfigError, match=r"-e \"\.\[mpi\]\""):
        mpi()
