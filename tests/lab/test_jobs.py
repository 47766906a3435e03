"""One job of a sweep: done once, gone on with after a kill, refused where it is another."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from ecs_eco.analysis.runs import load_series
from ecs_eco.engine.errors import ConfigError, ForeignFile, RecordingError
from ecs_eco.lab import jobs
from ecs_eco.lab.design import design_of
from ecs_eco.lab.folder import Manifest, Sweep, begin, read_sweep
from ecs_eco.lab.jobs import read_done, run_job
from ecs_eco.lab.plan import read_plan
from ecs_eco.lab.table import row_of
from ecs_eco.lab.treatments import Arm
from ecs_eco.record import container, seal
from ecs_eco.record.checkpoint import tick_of
from ecs_eco.runs.run import Stopped, run_to_folder
from tests.lab.moss import PLAN, written


def begun(folder: Path, plan: str = PLAN) -> Sweep:
    return begin(folder / "out", design_of(read_plan(written(folder, plan))))


def test_a_job_that_is_done_is_left_as_it_is(tmp_path: Path) -> None:
    sweep = begun(tmp_path)
    done = run_job(sweep.folder, 1)
    assert done["values"] == {"species.moss.count": 10}
    assert done["world_seed"] == 2
    assert done["ticks"] == 6
    assert len(done["digest"]) == 64
    before = (sweep.job_folder(1) / "done.json").stat().st_mtime_ns
    assert run_job(sweep.folder, 1) == done
    assert (sweep.job_folder(1) / "done.json").stat().st_mtime_ns == before
    assert sorted(p.name for p in sweep.job_folder(1).iterdir()) == ["done.json", "run"]


def test_a_job_that_was_stopped_goes_on_from_its_checkpoint_to_the_same_digest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep, other = begun(tmp_path / "a"), begun(tmp_path / "b")

    def stop_at_3(arm: Arm, seed: int, ticks: int, folder: Path, *_: object) -> object:
        run_to_folder(
            arm.config,
            seed=seed,
            ticks=ticks,
            out=folder,
            report=False,
            keep=1,
            prepare=lambda world: world.before_tick.append(
                lambda: world.tick == 3 and os.kill(os.getpid(), signal.SIGTERM)
            ),
        )
        raise AssertionError("it was not stopped")

    with monkeypatch.context() as patched:
        patched.setattr(jobs, "run_arm", stop_at_3)
        with pytest.raises(Stopped):
            run_job(sweep.folder, 0)
    assert not (sweep.job_folder(0) / "done.json").exists()
    assert (sweep.job_folder(0) / "run" / "checkpoints").exists()
    assert max(map(tick_of, (sweep.job_folder(0) / "run" / "checkpoints").glob("tick-*"))) == 3
    assert run_job(sweep.folder, 0)["digest"] == run_job(other.folder, 0)["digest"]


def test_a_job_ends_at_a_condition_and_its_means_begin_at_a_tick(tmp_path: Path) -> None:
    plan = PLAN.replace("ticks = 6", 'ticks = 9\nuntil = "moss > 12"\nfrom_tick = 3')
    sweep = begun(tmp_path, plan)
    done = [run_job(sweep.folder, number) for number in (0, 2)]
    rows = [row_of(0, one) for one in done]
    assert rows[1]["ended_by"] == "moss > 12"
    assert rows[1]["ended_at"] == 1
    assert rows[1]["moss.mean"] is None  # it ended before the burn-in
    assert run_job(sweep.folder, 2) == done[1]
    n = load_series(sweep.job_folder(0) / "run").n[:, 0]
    assert rows[0]["moss.mean"] == pytest.approx(n[3:].mean())
    assert rows[0]["moss.final"] == n[-1]
    plain = begun(tmp_path / "plain")
    assert not {"until", "from_tick"} & plain.content["plan"].keys()  # older folders still match their plans


def test_a_failed_job_says_why_until_it_is_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = begun(tmp_path)
    with monkeypatch.context() as patched:
        patched.setattr(jobs, "run_arm", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            run_job(sweep.folder, 0)
    failed = json.loads((sweep.job_folder(0) / "failed.json").read_text())
    assert failed["error"] == "ZeroDivisionError"
    run_job(sweep.folder, 0)
    assert not (sweep.job_folder(0) / "failed.json").exists()


def test_what_is_done_of_another_job_is_refused(tmp_path: Path) -> None:
    sweep = begun(tmp_path)
    run_job(sweep.folder, 0)
    sweep.job_folder(1).mkdir()
    (sweep.job_folder(0) / "done.json").rename(sweep.job_folder(1) / "done.json")
    with pytest.raises(ForeignFile, match=r"belongs to another job \(number, world_seed\)"):
        run_job(sweep.folder, 1)
    (sweep.job_folder(0) / "run").rename(sweep.job_folder(2))
    with pytest.raises(ConfigError, match=r"no such job; expected: a number from 0 to 3"):
        run_job(sweep.folder, 4)
    with pytest.raises(RecordingError, match="is not a folder of a sweep"):
        run_job(tmp_path, 0)


@pytest.mark.slow
def test_a_job_that_was_killed_by_sigkill_ends_with_the_same_digest(tmp_path: Path) -> None:
    long = PLAN.replace("ticks = 6", "ticks = 400\ncheckpoint_every = 20")
    sweep, other = begun(tmp_path / "a", long), begun(tmp_path / "b", long)
    code = (
        f"import os; from ecs_eco.lab import jobs\nbefore = jobs._noting\n"
        f"jobs._noting = lambda *a: lambda n, _: n > 150 and os.kill(os.getpid(), 9)\n"
        f"jobs.run_job({str(sweep.folder)!r}, 0)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == -signal.SIGKILL
    assert not (sweep.job_folder(0) / "done.json").exists()
    assert run_job(sweep.folder, 0)["digest"] == run_job(other.folder, 0)["digest"]


@pytest.mark.slow
def test_policies_are_trained_once_by_the_first_job_that_needs_them_and_shared(tmp_path: Path) -> None:
    small = {
        "species.grass.count": 60,
        "species.deer.count": 12,
        "species.wolf.count": 2,
        "training.ticks": 3,
        "training.set": {},
    }
    plan = {"world": "predator-prey", "ticks": 4, "set": small, "training_seeds": 1, "world_seeds": 2}
    sweep = begin(tmp_path / "out", design_of(read_plan(plan)))
    first = run_job(sweep.folder, 0)
    (trained,) = (sweep.folder / "policies").glob("*/seed-1/training.json")
    before = trained.stat().st_mtime_ns
    second = run_job(sweep.folder, 1)
    assert trained.stat().st_mtime_ns == before
    assert first["weights"] == second["weights"]
    assert set(first["weights"]) == {"deer", "wolf"}
    assert first["digest"] != second["digest"]
    assert not list((sweep.folder / "policies").glob("*/*.training"))


def _reseal(folder: Path, **changes: object) -> None:
    """Change sweep.json as somebody could who knows its seal and its hash."""
    manifest = seal.read_manifest(folder, "sweep.json") | changes
    container.write(folder, Manifest, manifest | {"hash": container._hash(manifest, Manifest)})


def test_a_training_whose_name_leads_elsewhere_is_refused_and_nothing_is_removed(tmp_path: Path) -> None:
    (tmp_path / "victim").mkdir()
    (tmp_path / "victim" / "thesis.txt").write_text("mine")
    sweep = begun(tmp_path)
    config_hash = sweep.jobs[0].config_hash
    for name in ("../../victim", "/victim", f"{config_hash[:16]}/seed-1/../../..", "", "."):
        training = {"name": name, "seed": 1, "values": {}, "treatment": "", "config_hash": config_hash}
        jobs_ = [job | {"training": name, "training_seed": 1} for job in sweep.content["jobs"]]
        _reseal(sweep.folder, trainings=[training], jobs=jobs_)
        with pytest.raises(RecordingError, match=r"sweep\.json: trainings\.0\.name"):
            run_job(sweep.folder, 0)
    assert (tmp_path / "victim" / "thesis.txt").read_text() == "mine"


def test_a_link_out_of_the_sweep_is_refused(tmp_path: Path) -> None:
    (tmp_path / "victim").mkdir()
    sweep = begun(tmp_path)
    sweep.job_folder(0).mkdir(parents=True)
    (sweep.job_folder(0) / "run").symlink_to(tmp_path / "victim")
    with pytest.raises(ForeignFile, match="leads out of"):
        run_job(sweep.folder, 0)
    assert not list((tmp_path / "victim").iterdir())


def test_a_flipped_bit_and_a_wrong_type_in_a_result_are_refused_by_name(tmp_path: Path) -> None:
    sweep = begun(tmp_path)
    done = run_job(sweep.folder, 0)
    file = sweep.job_folder(0) / "done.json"
    whole = file.read_text()
    file.write_text(whole.replace('"mean": 1', '"mean": 9'))
    assert file.read_text() != whole
    with pytest.raises(
        RecordingError, match=r"done\.json: is damaged.*seal does not match; remove this file"
    ):
        read_done(sweep, 0)
    for change, key in (
        ({"seconds": "long"}, "seconds"),
        ({"seconds": 2**70}, "seconds"),
        ({"summary": 3}, "summary"),
        (
            {"summary": done["summary"] | {"species": {"moss": {"extinct": 2**70, "deaths": {}}}}},
            r"summary\.species\.moss\.extinct.*: Input should be a valid number",
        ),
        (
            {"summary": done["summary"] | {"species": {"moss": {"mean": []}}}},
            r"summary\.species\.moss\.deaths",
        ),
    ):
        seal.write_manifest(file.parent, done | change, "done.json")
        with pytest.raises(RecordingError, match=rf"done\.json: {key}"):
            read_done(sweep, 0)


def test_a_sweep_of_an_older_version_is_refused_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "sweep.json").write_text('{"format": 1, "hash": "", "jobs": []}')
    refused = (
        r"sweep\.json: was begun by ecs-eco 0\.2\.0 or an older version.* release 0\.2\.0.* another folder"
    )
    with pytest.raises(RecordingError, match=refused):
        read_sweep(tmp_path)


def test_a_sweep_that_was_begun_in_the_other_mode_is_refused(tmp_path: Path) -> None:
    sweep = begun(tmp_path)
    assert sweep.content["mode"] == "native"
    _reseal(sweep.folder, mode="portable")
    for call, what in ((run_job, 0), (jobs.train, "any")):
        with pytest.raises(ForeignFile, match=r"portable mode.*ECS_ECO_PORTABLE=1"):
            call(sweep.folder, what)
    with pytest.raises(ForeignFile, match="portable mode"):
        begin(sweep.folder, design_of(read_plan(written(tmp_path, PLAN))))
