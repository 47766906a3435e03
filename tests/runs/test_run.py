import json
import os
import signal
import subprocess
import sys
import time

import pyarrow as pa
import pytest

from ecs_eco import World
from ecs_eco.analysis.report import write_report
from ecs_eco.analysis.why.case import Case
from ecs_eco.engine.errors import CheckpointError, ConfigError, ForeignFile, RecordingError
from ecs_eco.record import fork, resume, run_to_folder, seal
from ecs_eco.record.manifest import WRITTEN
from ecs_eco.record.parquet import read_parts
from ecs_eco.runs.repeat import repeat
from ecs_eco.runs.run import Stopped

TICKS = 40
KINDS = ("series", "births", "deaths", "snapshots")


def _run(config, out, ticks=TICKS, **options):
    options = {
        "seed": 7,
        "policies": "untrained",
        "learn": True,
        "report": False,
        "snapshot_every": 5,
        **options,
    }
    return run_to_folder(config, ticks=ticks, out=out, **options)


def _content(folder):
    """All that was recorded: a table for each kind, whatever the parts."""
    tables = {}
    for kind in KINDS:
        table = read_parts(folder / kind)
        words = [pa.DictionaryArray if pa.types.is_dictionary(f.type) else None for f in table.schema]
        tables[kind] = {n: table[n].to_pylist() for n, _ in zip(table.column_names, words, strict=True)}
    return tables


@pytest.fixture(scope="module")
def whole(menagerie, tmp_path_factory):
    out = tmp_path_factory.mktemp("whole") / "run"
    return _run(menagerie(), out), _content(out)


def _as_whole(folder, whole):
    manifest, content = whole
    mine = json.loads((folder / "manifest.json").read_text())
    assert (mine["finished"], mine["done"], mine["digest"]) == (True, TICKS, manifest["digest"])
    assert _content(folder) == content


def test_a_run_ends_at_the_first_tick_at_which_a_condition_is_true_and_resumes_to_the_same_end(tmp_path):
    moss = {
        "format": 1,
        "name": "moss",
        "species": {
            "moss": {
                "count": 20,
                "body": {"radius": 0.1},
                "reproduction": {"kind": "spread", "rate": 0.5, "spacing": 0.1},
            }
        },
        "reporters": {"both": "count(moss) / 2", "each": "count()"},
        "space": {"size": [12.0, 12.0]},
    }
    for until in ("both > 15", "each.moss > 30 and moss > 30"):
        out = tmp_path / until[:4]
        ended = _run(moss, out, until=["moss == 0", until])
        n = read_parts(out / "series")["n"].to_pylist()
        first = next(i for i, number in enumerate(n) if number > 30)
        assert (ended["ended"], ended["done"]) == ({"by": until, "tick": first + 1}, first + 1)
        assert len(n) == first + 1 < TICKS
        assert ended["finished"]
        again = resume(out, report=False)  # as after a kill between the last checkpoint and the manifest
        assert (again["digest"], again["ended"]) == (ended["digest"], ended["ended"])
    assert fork(out, tmp_path / "fork", report=False)["done"] == TICKS
    with pytest.raises(ConfigError, match=r'(?s)--until.*unknown name "mss" at character 1.*mean "moss"'):
        _run(moss, tmp_path / "no", until=["mss == 0"])
    with pytest.raises(ConfigError, match=r'unknown name "each"'):
        _run(moss, tmp_path / "no", until=["each > 3"])


@pytest.mark.parametrize(("of", "share"), [("moss", 0.02), ("2 * half", 0.02), ("double.moss / 2", 0.0)])
def test_a_run_ends_when_a_mean_has_settled_however_it_was_resumed(tmp_path, of, share):
    moss = {
        "format": 1,
        "name": "moss",
        "species": {
            "moss": {
                "count": 20,
                "body": {"radius": 0.1},
                "reproduction": {"kind": "spread", "rate": 0.5, "spacing": 1.0},
            }
        },
        "reporters": {"half": "count(moss) / 2", "double": "2 * count()"},
        "space": {"size": [12.0, 12.0]},
    }
    rule = f"settled({of}, 4, {share})"
    whole = _run(moss, tmp_path / "whole", until=[rule])
    n = read_parts(tmp_path / "whole" / "series")["n"].to_pylist()
    means = [sum(n[i : i + 4]) / 4 for i in range(0, len(n) - 3, 4)]
    near = [abs(b - a) <= share * a for a, b in zip(means, means[1:], strict=False)]
    assert near.index(True) == len(near) - 1
    assert (whole["ended"], whole["done"]) == ({"by": rule, "tick": len(n)}, 4 * len(means))
    assert 8 < len(n) < TICKS
    for first in (1, 7, len(n) - 1):
        out = tmp_path / str(first)
        _run(moss, out, ticks=first, until=[rule])
        again = resume(out, until=TICKS, report=False)
        assert (again["digest"], again["ended"]) == (whole["digest"], whole["ended"])
    with pytest.raises(ConfigError, match=r"not a rule of convergence.*settled\(NUMBER, TICKS, SHARE\)"):
        _run(moss, tmp_path / "no", until=["settled(moss, 0.1)"])
    with pytest.raises(ConfigError, match="not a rule of convergence"):
        _run(moss, tmp_path / "no", until=[f"settled(moss, {10**30}, 0.1)"])


def test_checkpoints_change_nothing_and_the_last_ones_stay(menagerie, tmp_path, whole):
    _run(menagerie(), tmp_path / "run", checkpoint_every=6, keep=2)
    _as_whole(tmp_path / "run", whole)
    assert [p.name for p in sorted((tmp_path / "run" / "checkpoints").iterdir())] == [
        f"tick-{t:012d}.safetensors" for t in (36, 40)
    ]


@pytest.mark.parametrize("first", [0, 1, 23])
def test_a_run_goes_on_where_a_shorter_one_ended(menagerie, tmp_path, whole, first):
    _run(menagerie(), tmp_path / "run", ticks=first)
    manifest = resume(tmp_path / "run", until=TICKS, report=False)
    _as_whole(tmp_path / "run", whole)
    assert manifest["ticks"] == TICKS


class _PowerCut(BaseException):
    """Something from outside."""


def _cut(monkeypatch, tick, phase="Feed"):
    """Let the power fail within a tick, so hard that nothing is written any more."""
    from ecs_eco import systems
    from ecs_eco.runs import run

    system = getattr(systems, phase)
    process = system.process

    def failing(self, *arguments):
        process(self, *arguments)
        if self.world.tick == tick:
            raise _PowerCut

    monkeypatch.setattr(system, "process", failing)
    monkeypatch.setattr(run, "close", lambda *_, **__: None)


@pytest.mark.parametrize("tick", [0, 3, 12, 29])
def test_after_a_power_cut_a_run_goes_on_from_its_last_checkpoint(
    menagerie, tmp_path, monkeypatch, whole, tick
):
    with monkeypatch.context() as m:
        _cut(m, tick)
        with pytest.raises(_PowerCut):
            _run(menagerie(), tmp_path / "run", checkpoint_every=6)
    (tmp_path / "run" / "series").mkdir(exist_ok=True)
    (tmp_path / "run" / "series" / ".part-00090.parquet.ecs-eco-7-0123abcd.tmp").write_bytes(b"half")
    (tmp_path / "run" / "checkpoints" / ".tick-000000000090.safetensors.ecs-eco-7-0123abcd.tmp").write_bytes(
        b"half"
    )
    resume(tmp_path / "run", report=False)
    _as_whole(tmp_path / "run", whole)
    assert list((tmp_path / "run").rglob("*.tmp")) == []


def test_a_run_without_any_checkpoint_begins_anew(menagerie, tmp_path, monkeypatch, whole):
    with monkeypatch.context() as m:
        _cut(m, 12)
        with pytest.raises(_PowerCut):
            _run(menagerie(), tmp_path / "run")
    for kept in (tmp_path / "run" / "checkpoints").iterdir():  # as if the first one had not been written yet
        kept.unlink()
    resume(tmp_path / "run", report=False)
    _as_whole(tmp_path / "run", whole)


def _damage(checkpoint):
    data = bytearray(checkpoint.read_bytes())
    data[len(data) // 2] ^= 4
    checkpoint.write_bytes(data)


def test_a_damaged_checkpoint_of_an_unfinished_run_is_skipped_with_a_warning(
    menagerie, tmp_path, monkeypatch, whole
):
    with monkeypatch.context() as m:
        _cut(m, 32)
        with pytest.raises(_PowerCut):
            _run(menagerie(), tmp_path / "run", checkpoint_every=10)
    _damage(tmp_path / "run" / "checkpoints" / "tick-000000000030.safetensors")
    heard = []
    resume(tmp_path / "run", report=False, complain=heard.append)
    assert len(heard) == 1
    assert "tick-000000000030" in heard[0]
    assert "damaged" in heard[0]
    _as_whole(tmp_path / "run", whole)


@pytest.mark.parametrize(("damaged", "last"), [("*", "no intact checkpoint"), ("*30.*", "is from tick 20")])
def test_resuming_deletes_nothing_of_a_finished_run_without_an_intact_last_checkpoint(
    menagerie, tmp_path, whole, damaged, last
):
    run = tmp_path / "run"
    _run(menagerie(), run, ticks=30, checkpoint_every=10)
    for checkpoint in (run / "checkpoints").glob(damaged):
        _damage(checkpoint)
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    for until in (30, TICKS):
        with pytest.raises(CheckpointError, match=rf"{last}.*ecs-eco resume .*run --from-tick 30 --out NEW"):
            resume(run, until=until, report=False, complain=lambda _: None)
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before
    forked = fork(run, tmp_path / "fork", 30, until=TICKS, report=False, complain=lambda _: None)
    assert (forked["digest"], forked["done"]) == (whole[0]["digest"], TICKS)


@pytest.mark.parametrize("name", ["checkpoints", "series"])
def test_resuming_writes_and_deletes_nothing_behind_a_link(menagerie, tmp_path, name):
    _run(menagerie(), tmp_path / "run", ticks=8, checkpoint_every=2)
    (tmp_path / "run" / name).rename(tmp_path / "mine")
    (tmp_path / "run" / name).symlink_to(tmp_path / "mine")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(ForeignFile, match=rf"{name}: is a link that leads out"):
        resume(tmp_path / "run", until=12, report=False)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_a_resealed_manifest_with_a_wrong_value_is_refused_by_its_key(tmp_path):
    moss = {"count": 2, "body": {"radius": 0.1}}
    moss["reproduction"] = {"kind": "spread", "rate": 0.5, "spacing": 0.1}
    world = {"format": 1, "name": "moss", "species": {"moss": moss}, "space": {"size": [12.0, 12.0]}}
    _run(world, tmp_path / "run", ticks=1, policies="trained", learn=None)
    manifest = seal.read_manifest(tmp_path / "run")
    config = manifest["config"]
    moss = config["species"]["moss"] | {"lethal": [{"min": 0.0}]}
    changes = [({key: value}, key) for key in ("until", "forked", "island") for value in (None, {}, [[]])]
    changes += [
        ({"until": "x"}, "until"),
        ({"config": config | {"terrain": "x"}}, r"config\.terrain"),
        ({"config": config | {"species": {}}}, r"config\.species"),
        ({"config": config | {"species": {"moss": moss}}}, r"config\.species\.moss\.lethal\.0\.property"),
        ({"config": {key: value for key, value in config.items() if key != "space"}}, r"config\.space"),
        ({"config": None}, "config"),
        ({"config": config | {"objects": "x"}}, r"config\.objects"),
        ({"config": config | {"space": config["space"] | {"size": [-1.0, 1.0]}}}, r"config\.space\.size\.0"),
        (
            {"config": config | {"species": {"moss": moss | {"lethal": [], "diet": 1e300}}}},
            r"config.*moss\.diet",
        ),
    ]
    whole = [(manifest | change, f"{key}.*: ") for change, key in changes]
    stranger = {"config": config | {"species": {"mass": moss | {"lethal": []}}}}
    whole += [(manifest | stranger, r"content: config\.species\.moss is missing")]
    whole += [
        ({k: v for k, v in manifest.items() if k != key}, f"the key {key} is missing") for key in WRITTEN
    ]
    for content, said in whole:
        seal.write_manifest(tmp_path / "run", content)
        for read in (resume, repeat, write_report, Case.read):
            with pytest.raises(RecordingError, match=rf"manifest\.json: {said}"):
                read(tmp_path / "run")
    seal.write_manifest(tmp_path / "run", manifest | {"config": config | {"interventions": [{"kind": "x"}]}})
    with pytest.raises(RecordingError, match=r"interventions are invalid.*'x'"):
        repeat(tmp_path / "run")


@pytest.mark.parametrize("kind", ["series", "births", "snapshots"])
def test_a_damaged_older_part_is_refused_and_nothing_is_recorded_after_it(menagerie, tmp_path, kind):
    _run(menagerie(), tmp_path / "run", ticks=10)
    part = tmp_path / "run" / kind / "part-00000.parquet"
    data = bytearray(part.read_bytes())
    data[len(data) // 3] ^= 4
    part.write_bytes(data)
    before = {path: path.read_bytes() for path in (tmp_path / "run").rglob("*.*") if path.is_file()}
    with pytest.raises(RecordingError, match=rf"{kind}/part-00000.parquet: is damaged.*Fork it"):
        resume(tmp_path / "run", until=20, report=False)
    assert before == {path: path.read_bytes() for path in (tmp_path / "run").rglob("*.*") if path.is_file()}
    assert fork(tmp_path / "run", tmp_path / "fork", until=12, report=False)["done"] == 12


def test_the_first_signal_stops_after_the_tick_with_a_checkpoint(menagerie, tmp_path, whole):
    def press(done, ticks):
        if done >= 9:
            os.kill(os.getpid(), signal.SIGTERM)

    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(Stopped) as stop:
        _run(menagerie(), tmp_path / "run", ticks=100_000, progress=press)
    assert signal.getsignal(signal.SIGTERM) is before
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert manifest["finished"] is False
    assert manifest["done"] == stop.value.tick >= 9
    assert f"ecs-eco resume {tmp_path / 'run'}" in str(stop.value)
    if stop.value.tick <= TICKS:
        resume(tmp_path / "run", until=TICKS, report=False)
        _as_whole(tmp_path / "run", whole)


def test_a_full_disk_ends_a_run_with_one_message_and_what_was_recorded_is_whole(
    menagerie, tmp_path, monkeypatch, whole
):
    from ecs_eco.record import checkpoint

    write = checkpoint.write

    def full(path, meta, arrays):
        if meta["clock"]["tick"] >= 12:
            raise OSError(28, "No space left on device")
        write(path, meta, arrays)

    with monkeypatch.context() as m:
        m.setattr(checkpoint, "write", full)
        with pytest.raises(
            RecordingError, match=r"No space left on device.*last checkpoint is from tick 6.*ecs-eco resume"
        ):
            _run(menagerie(), tmp_path / "run", checkpoint_every=6)
    resume(tmp_path / "run", report=False)
    _as_whole(tmp_path / "run", whole)


@pytest.mark.slow
def test_a_fork_goes_on_exactly_and_then_otherwise(menagerie, tmp_path, whole):
    _run(menagerie(), tmp_path / "run", checkpoint_every=10, keep=9)
    same = fork(tmp_path / "run", tmp_path / "same", from_tick=17, report=False)
    assert same["digest"] == whole[0]["digest"]
    other = fork(
        tmp_path / "run",
        tmp_path / "other",
        from_tick=17,
        changes=["species.ram.metabolism.basal=0.02"],
        report=False,
    )
    assert other["digest"] != whole[0]["digest"]
    assert other["forked"]["tick"] == 17
    assert other["config"]["species"]["ram"]["metabolism"]["basal"] == 0.02
    series = read_parts(tmp_path / "other" / "series").to_pydict()
    assert (min(series["tick"]), max(series["tick"])) == (17, TICKS - 1)
    by_hand = fork(
        tmp_path / "run",
        tmp_path / "again",
        from_tick=20,
        changes={"species.ram.metabolism.basal": 0.02},
        report=False,
    )
    assert by_hand["digest"] not in (other["digest"], same["digest"])


def test_what_cannot_go_on_says_why(menagerie, tmp_path):
    with pytest.raises(RecordingError, match="no such folder"):
        resume(tmp_path / "nowhere")
    with pytest.raises(RecordingError, match=r"has no manifest\.json"):
        resume(tmp_path)
    _run(menagerie(), tmp_path / "run", ticks=5)
    with pytest.raises(
        RecordingError, match=r"already at tick 5, later than --until 3.*--from-tick 3 --out NEW"
    ):
        resume(tmp_path / "run", until=3)
    with pytest.raises(FileExistsError, match="not an empty folder"):
        fork(tmp_path / "run", tmp_path / "run")
    for text, word in (("{", "is damaged"), ("[]", "not the manifest"), ('{"format": 7}', "another version")):
        (tmp_path / "run" / "manifest.json").write_text(text)
        with pytest.raises(RecordingError, match=word):
            resume(tmp_path / "run")


@pytest.mark.slow
def test_a_killed_process_resumes(menagerie, tmp_path, whole):
    """kill -9, three times, at moments that nobody chose."""
    script = (
        "import json, sys\nfrom ecs_eco.record import resume, run_to_folder\nfrom pathlib import Path\n"
        "out, config = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text())\n"
        "if (out / 'manifest.json').exists():\n    resume(out, report=False)\nelse:\n"
        "    run_to_folder(config, seed=7, ticks=40, out=out, policies='untrained', learn=True, "
        "report=False, snapshot_every=5,\n                  checkpoint_every=3)\n"
    )
    (tmp_path / "config.json").write_text(json.dumps(menagerie()))
    arguments = [sys.executable, "-c", script, str(tmp_path / "run"), str(tmp_path / "config.json")]
    for wait in (0.3, 0.1, 0.2):
        victim = subprocess.Popen(arguments)
        patience = time.monotonic() + 60
        while (
            not list((tmp_path / "run").glob("checkpoints/*"))
            and victim.poll() is None
            and time.monotonic() < patience
        ):
            time.sleep(0.01)
        time.sleep(wait)
        victim.kill()
        victim.wait()
    subprocess.run(arguments, check=True)
    _as_whole(tmp_path / "run", whole)
    assert list((tmp_path / "run").rglob("*.tmp")) == []


def test_resumed_runs_take_any_number_of_threads(menagerie, tmp_path, whole):
    _run(menagerie(), tmp_path / "run", ticks=10)
    resume(tmp_path / "run", until=TICKS, threads=2, report=False)
    _as_whole(tmp_path / "run", whole)


def test_the_world_of_a_run_is_that_of_the_library(menagerie, whole):
    assert (
        World.from_config(menagerie(), seed=7, policies="untrained", learn=True).run(TICKS).digest()
        == whole[0]["digest"]
    )


def test_a_part_that_is_gone_is_missed(menagerie, tmp_path):
    from ecs_eco.analysis.runs import load_series

    _run(menagerie(), tmp_path / "run", ticks=9, checkpoint_every=4)
    assert load_series(tmp_path / "run").n.shape[0] == 9
    (tmp_path / "run" / "series" / "part-00001.parquet").unlink()
    with pytest.raises(RecordingError, match="1 of 3 parts of series are missing"):
        load_series(tmp_path / "run")


@pytest.mark.parametrize("done", [0, 1, 5, 6, 7])
def test_a_run_with_interventions_still_to_come_is_repeated(tmp_path, done):
    interventions = [
        {"kind": "cull", "at": 2, "every": 3, "species": "moss", "count": 1},
        {"kind": "add", "at": 6, "species": "moss", "count": 2},
    ]
    config = {
        "format": 1,
        "name": "bog",
        "ticks": 7,
        "space": {"size": [9.0, 9.0]},
        "species": {"moss": {"count": 20, "body": {"radius": 0.1}}},
        "interventions": interventions,
    }
    run_to_folder(config, 1, done, tmp_path / "run", report=False)
    repeated = repeat(tmp_path / "run")
    assert repeated["same"]
    assert repeated["interventions"] == {0: 0, 1: 0, 5: 1, 6: 2, 7: 3}[done]
    assert repeat(tmp_path / "run", tmp_path / "again")["same"]
