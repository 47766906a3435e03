"""The ends and numbers of runs and forks, and what a killed run with measurements leaves."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from ecs_eco.engine.errors import RecordingError
from ecs_eco.record import fork, resume, run_to_folder, seal


def _run(config, out, ticks, **options):
    how = {"seed": 7, "policies": "untrained", "learn": True, "report": False, "snapshot_every": 5}
    return run_to_folder(config, ticks=ticks, out=out, **how | options)


def test_a_fork_has_at_least_one_tick(tmp_path, menagerie):
    _run(menagerie(), tmp_path / "run", ticks=6)
    for tick, until in ((None, None), (6, None), (4, 4), (99, None)):
        with pytest.raises(RecordingError, match=rf"the fork begins at tick {tick or 6}, .*--until above"):
            fork(tmp_path / "run", tmp_path / "fork", tick, until=until, report=False)
        assert not (tmp_path / "fork").exists()


def test_the_command_of_a_run_names_its_new_end(tmp_path, menagerie):
    for command in ("ecs-eco run x.toml --seed 6 --ticks 6 --until 'ram == 6'", "ecs-eco resume x --until 6"):
        out = tmp_path / command[-1]
        _run(menagerie(), out, ticks=6, command=command)
        resume(out, until=8, report=False)
        assert seal.read_manifest(out)["command"] == (
            command.replace("--ticks 6", "--ticks 8").replace("--until 6", "--until 8")
        )


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("snapshot_every", -1),
        ("snapshot_every", 1.5),
        ("snapshot_every", 0),
        ("checkpoint_every", True),
        ("checkpoint_every", "x"),
        ("keep", "x"),
        ("keep", 0),
        ("until", 8.0),
        ("from_tick", 1.5),
    ],
)
def test_numbers_that_are_no_whole_numbers_are_refused_by_name_before_anything_is_written(
    tmp_path, menagerie, name, value
):
    early, run = name not in ("until", "from_tick"), tmp_path / "run"
    if not early:
        _run(menagerie(), run, ticks=2)
    calls = {
        True: lambda: _run(menagerie(), run, ticks=2, **{name: value}),
        False: lambda: fork(run, tmp_path / "fork", **({"until": 9} | {name: value}), report=False),
        "until": lambda: resume(run, until=value, report=False),
    }
    for call in [calls[early], *([calls[name]] if name in calls else [])]:
        with pytest.raises((TypeError, ValueError), match=f"{name} is {value!r}"):
            call()
    assert not (tmp_path / "fork").exists()
    assert not run.exists() if early else seal.read_manifest(run)["ticks"] == 2


@pytest.mark.parametrize("kill", range(1, 5))
def test_a_run_with_measurements_that_is_killed_early_begins_anew_and_its_forks_keep_them(tmp_path, kill):
    (tmp_path / "m.csv").write_text("t,moss\n" + "".join(f"{t},{t + 3}\n" for t in range(12)))
    (tmp_path / "moss.toml").write_text(
        "format = 1\nname = 'moss'\nspace = { size = [12.0, 12.0] }\ndata = { file = 'm.csv' }\n"
        "[species.moss]\ncount = 3\nbody = { radius = 0.1 }\n"
    )
    killed = (
        "import os, signal, sys\n"
        "from ecs_eco.record import run_to_folder\n"
        "left, replace = int(sys.argv[1]), os.replace\n"
        "def counted(*a, **k):\n"
        "    global left\n"
        "    left -= 1\n"
        "    left or os.kill(os.getpid(), signal.SIGKILL)\n"
        "    return replace(*a, **k)\n"
        "os.replace = counted\n"
        "run_to_folder('moss.toml', ticks=3, out='run', report=False)\n"
    )
    code = subprocess.run([sys.executable, "-c", killed, str(kill)], cwd=tmp_path, check=False).returncode
    if (tmp_path / "run" / "manifest.json").exists():
        resume(tmp_path / "run", report=False)
    else:
        assert code == -signal.SIGKILL
        run_to_folder(tmp_path / "moss.toml", ticks=3, out=tmp_path / "run", report=False)
    (tmp_path / "m.csv").unlink()
    for number, path in enumerate((tmp_path / "run", Path(os.path.relpath(tmp_path / "run")))):
        fork(path, tmp_path / f"fork-{number}", until=5, report=False)
        kept = [tmp_path / name / "data.csv" for name in ("run", f"fork-{number}")]
        assert kept[0].read_bytes() == kept[1].read_bytes()
