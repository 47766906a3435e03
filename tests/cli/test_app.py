"""The command line: what commands call, say and leave; how they end; how quickly they start."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
import typing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

import ecs_eco
from ecs_eco.cli import app
from ecs_eco.cli.app import COMMANDS, loaded
from ecs_eco.cli.run import command_of
from ecs_eco.config import load
from ecs_eco.config.models.sensors import AnySensor
from ecs_eco.config.shipped import shipped
from ecs_eco.view.branch import of_run

ROOT = Path(ecs_eco.__path__[0]).parent
FEW = ["--set", "species.grass.count=60", "--set", "species.deer.count=12", "--set", "species.wolf.count=2"]
MAIN = "from ecs_eco.cli import main; main()"


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def invoke(*arguments: str, code: int = 0) -> str:
    done = CliRunner().invoke(app, [*arguments])
    assert done.exit_code == code, done.output + repr(done.exception)
    return done.output


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-c", MAIN, *arguments]


def environment() -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(ROOT)}


# starting


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["list"]])
def test_it_starts_quickly_and_loads_nothing_heavy(arguments: list[str]) -> None:
    code = f"""
import sys
sys.argv = ["ecs-eco", *{arguments}]
try:
    {MAIN.replace("; ", chr(10) + "    ")}
except SystemExit:
    heavy = ("torch", "numba", "matplotlib", "pyarrow", "numpy", "scipy", "rich",
             "ecs_eco.config.models.world")
    print([m for m in heavy if m in sys.modules], file=sys.stderr)
"""
    seconds, bare = [], []
    for _ in range(3):
        bare.append(_seconds("import typer")[0])
        used, output = _seconds(code)
        seconds.append(used)
        assert output == "[]"
    assert min(seconds) < max(0.3, 6 * min(bare)), (
        "seconds of a processor; or what loading typer alone takes, six times"
    )


def _seconds(code: str) -> tuple[float, str]:
    """Seconds of a processor that a process with this code takes, and what it says on stderr."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
        env=environment(),
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, done.stderr.strip()


def test_help_of_a_command_loads_no_torch() -> None:
    code = """
import sys
from ecs_eco.cli.app import COMMANDS, loaded
for name in COMMANDS:
    loaded(name)
print([m for m in ("torch", "matplotlib", "ray", "optuna", "deap") if m in sys.modules], file=sys.stderr)
"""
    assert _seconds(code)[1] == "[]"


@pytest.mark.parametrize("name", COMMANDS)
def test_the_list_of_commands_has_the_help_of_each(name: str) -> None:
    assert COMMANDS[name][1] == loaded(name).help


def test_no_command_is_help() -> None:
    assert "Usage" in invoke(code=2)


def test_version_is_said() -> None:
    assert invoke("--version").startswith("ecs-eco")


def test_the_package_can_be_run_as_a_module() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "ecs_eco", "--version"],
        check=True,
        capture_output=True,
        text=True,
        env=environment(),
    )
    assert done.stdout == invoke("--version")


def test_the_list_has_every_world_sensor_component_and_system() -> None:
    from ecs_eco import components, systems

    output = invoke("list")
    union = typing.get_args(typing.get_args(AnySensor)[0])
    kinds = [typing.get_args(sensor.model_fields["kind"].annotation)[0] for sensor in union]
    words = {line.split()[0] for line in output.splitlines() if line.startswith("  ")}
    assert words == {*shipped(), *kinds, *components.__all__, *systems.__all__}


def test_check_says_what_is_in_a_world() -> None:
    output = invoke("check", "predator-prey", "--set", "species.deer.count=12")
    assert "deer: 12" in output
    assert "wolf_near" in output
    assert "speed.run" in output


# run


def test_run_leaves_a_folder_with_what_was_asked_for(here: Path) -> None:
    output = invoke(
        "run", "predator-prey", *FEW, "--ticks", "3", "--seed", "5", "--out", "a/b", "--no-report", "--quiet"
    )
    manifest = json.loads((here / "a" / "b" / "manifest.json").read_text())
    assert (manifest["seed"], manifest["ticks"], manifest["finished"]) == (5, 3, True)
    assert manifest["config"]["species"]["deer"]["count"] == 12
    assert load(manifest["config"]).config_hash == manifest["config_hash"]
    assert "3 ticks of predator-prey, seed 5, in a/b" in output
    assert "at the end: " in output


def test_run_without_a_folder_makes_one_in_runs_and_never_writes_into_an_old_one(here: Path) -> None:
    for _ in range(2):
        invoke("run", "predator-prey", *FEW, "--ticks", "1", "--no-report")
    assert sorted(p.name for p in (here / "runs").iterdir()) == ["predator-prey-1", "predator-prey-1-2"]


class Caught(Exception):
    """What a call was given."""


def catch(monkeypatch: pytest.MonkeyPatch, place: str) -> None:
    """Replaces a function by one that raises what it was given."""

    def fake(*args: Any, **kwargs: Any) -> None:
        raise Caught(args, kwargs)

    monkeypatch.setattr(place, fake, raising=False)


def caught(*arguments: str) -> tuple[tuple[Any, ...], dict[str, Any]]:
    done = CliRunner().invoke(app, [*arguments])
    assert isinstance(done.exception, Caught), done.output
    return done.exception.args[0], done.exception.args[1]


@pytest.mark.parametrize(
    ("arguments", "policies", "learn", "threads", "report"),
    [
        ([], "trained", None, 1, True),
        (["--policies", "random", "--no-learn"], "random", False, 1, True),
        (["--policies", "folder", "--learn", "--threads", "2", "--no-report"], "folder", True, 2, False),
    ],
)
def test_run_hands_on_its_options(
    arguments: list[str],
    policies: str,
    learn: bool | None,
    threads: int,
    report: bool,
    here: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (here / "folder").mkdir()
    for name in ("deer", "wolf"):
        (here / "folder" / f"{name}.safetensors").write_bytes(b"")
    catch(monkeypatch, "ecs_eco.cli.run.run_to_folder")
    args, kwargs = caught("run", "predator-prey", "--ticks", "7", "--seed", "3", *arguments)
    config, seed, ticks, out, *rest = args
    assert (config.name, seed, ticks, out.path) == ("predator-prey", 3, 7, Path("runs/predator-prey-3"))
    command = kwargs.pop("command")
    others = {"record": None, "until": [], "checkpoint_every": None, "keep": 3, "prepare": None}
    assert (rest[0], rest[1], kwargs) == (policies, learn, {"threads": threads, "report": report} | others)
    assert command.startswith(f"ecs-eco run predator-prey --seed 3 --ticks 7 --policies {policies}")
    assert ("--learn" in command, "--no-learn" in command) == (learn is True, learn is False)
    assert not (here / "runs").exists()


def test_commands_that_repeat_a_run_allow_its_code_and_name_the_mode(monkeypatch: pytest.MonkeyPatch) -> None:
    for code in ([], ["mine.py"]):
        run = command_of("own.toml", SimpleNamespace(code=code), 1, 5, "random", [], None, None)
        fork = of_run("my-run", bool(code), 3, None)["command"]
        assert ["--trust" in command.split() for command in (run, fork)] == [bool(code)] * 2
        assert "--portable" not in run + fork
    monkeypatch.setattr("ecs_eco.compiled.portable._on", True)
    assert command_of("own.toml", SimpleNamespace(code=[]), 1, 5, "random", [], None, None) == (
        "ecs-eco --portable run own.toml --seed 1 --ticks 5 --policies random --out DIR"
    )
    assert of_run("my-run", False, 3, None)["command"].startswith("ecs-eco --portable resume my-run ")


def test_the_world_has_ticks_and_seed_where_none_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    catch(monkeypatch, "ecs_eco.cli.run.run_to_folder")
    args, _ = caught("run", "predator-prey", "--set", "seed=9", "--set", "ticks=77")
    assert args[1:3] == (9, 77)


def test_an_interrupt_says_how_far_it_came(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*args: Any, **_: Any) -> None:
        args[-1](3, args[2])
        raise KeyboardInterrupt

    monkeypatch.setattr("ecs_eco.cli.run.run_to_folder", interrupted)
    output = invoke("run", "predator-prey", "--ticks", "10", code=130)
    assert "Stopped at tick 3 of 10; nothing was recorded" in output


def interrupt(out: Path, *arguments: str, runs: int = 1) -> str:
    """Starts a command, presses Ctrl-C when `runs` runs have each written a block of series; what it said
    on stderr."""

    def written() -> int:
        return len({block.parent for block in out.rglob("series/*.parquet")})

    run = subprocess.Popen(
        command(*arguments, *FEW, "--ticks", "100000000", "--out", str(out)),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    )
    deadline = time.monotonic() + 120
    while written() < runs and run.poll() is None and time.monotonic() < deadline:
        time.sleep(0.05)
    run.send_signal(signal.SIGINT)
    output, err = run.communicate(timeout=60)
    assert (run.returncode, output) == (130, ""), err
    assert "Traceback" not in err
    return err


@pytest.mark.slow
def test_ctrl_c_ends_a_run_and_keeps_what_was_recorded(here: Path) -> None:
    from ecs_eco.analysis.runs import load_series

    output = interrupt(here / "out", "run", "predator-prey")
    manifest = json.loads((here / "out" / "manifest.json").read_text())
    assert manifest["finished"] is False
    assert f"Stopped at tick {manifest['done']} of 100000000; the recording up to that point" in output
    last = load_series(here / "out").ticks[-1]
    assert last > 0
    assert manifest["done"] - last in (0, 1)  # the tick that was interrupted may have been recorded already


@pytest.mark.slow
def test_ctrl_c_ends_a_comparison_and_keeps_what_was_recorded(here: Path) -> None:
    output = interrupt(here / "out", "compare", "predator-prey", "--seeds", "3", runs=2)
    assert "Stopped after 0 of 6 jobs; finished recordings are in " in output
    manifests = [json.loads(p.read_text()) for p in (here / "out").glob("*/*/manifest.json")]
    assert len(manifests) == 2
    assert max(m["done"] for m in manifests) > 0


# train and report


def test_train_hands_on_its_options(monkeypatch: pytest.MonkeyPatch) -> None:
    catch(monkeypatch, "ecs_eco.lab.pretraining.pretrain")
    args, _ = caught("train", "predator-prey", "--seed", "3", "--out", "x")
    assert (args[0].name, *args[1:4]) == ("predator-prey", 3, load("predator-prey").training.ticks, Path("x"))
    args, _ = caught("train", "predator-prey", "--ticks", "5")
    assert args[1:4] == (1, 5, Path("runs/predator-prey-policies-1"))


def test_a_world_without_policies_is_not_trained(here: Path) -> None:
    (here / "w.toml").write_text(
        'format = 1\nname = "w"\nspace = { size = [9, 9] }\n[species.x]\ncount = 1\nbody = { radius = 1 }\n'
    )
    assert "no species has a policy" in invoke("train", "w.toml", code=2)


def test_report_is_written_for_a_run_folder(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (here / "manifest.json").write_text("{}")
    catch(monkeypatch, "ecs_eco.cli.telling.write_report")
    assert caught("report", ".") == ((Path(), None, None, {}), {})
