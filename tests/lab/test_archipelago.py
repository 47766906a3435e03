"""Archipelagos: the same end with any number of workers, and whoever is killed."""

import os
import shutil
import signal
import subprocess
import sys
import time

import pytest

from ecs_eco import World
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.runs import load_series
from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError
from ecs_eco.lab import archipelago as lab
from ecs_eco.lab.archipelago import Archipelago
from ecs_eco.lab.pool import Pool
from ecs_eco.record import container, resume
from ecs_eco.record.archipelago import digest_of, read
from ecs_eco.record.claim import Claim

TICKS = 20
OPTIONS = {"ticks": TICKS, "policies": "untrained", "learn": True, "snapshot_every": 5}


def config(menagerie, **more):
    plan = {
        "islands": {"a": {}, "b": {"species.moss.count": 100}, "c": {}},
        "migration_interval": 5,
        "migration_probability": {"ram": 0.3, "lynx": 0.3},
    }
    return menagerie(archipelago=plan | more)


@pytest.fixture(scope="module")
def whole(menagerie, tmp_path_factory):
    """One that nobody disturbed, run by this process."""
    out = tmp_path_factory.mktemp("islands") / "whole"
    Archipelago.from_config(config(menagerie), out=out, **OPTIONS).run(report=False)
    return Archipelago(out)


def test_its_manifest_names_the_islands_at_one_tick(whole):
    manifest = whole.manifest
    assert (manifest["finished"], manifest["tick"], whole.tick) == (True, TICKS, TICKS)
    assert list(manifest["islands"]) == ["a", "b", "c"] == list(whole.islands)
    assert whole.digest == digest_of(manifest["islands"])
    for name, state in manifest["islands"].items():
        assert whole.world(name).digest() == state["digest"]
        last = load_series(whole.islands[name]).n[-1].tolist()
        assert last == [state["n"][s] for s in ("moss", "ram", "lynx")]


def test_it_does_not_continue_after_a_damaged_part_of_an_island(whole, tmp_path):
    folder = shutil.copytree(whole.folder, tmp_path / "copy")
    part = folder / "islands" / "b" / "series" / "part-00000.parquet"
    data = bytearray(part.read_bytes())
    data[len(data) // 3] ^= 4
    part.write_bytes(data)
    with pytest.raises(RecordingError, match=r"b/series/part-00000.parquet: is damaged"):
        Archipelago(folder).run(TICKS + 5, report=False)
    assert Archipelago(folder).tick == TICKS


def test_migrants_arrive_in_the_order_of_islands_and_uids(whole):
    world = whole.world("a")
    ram = world.tables["ram"]
    assert len({uid >> 48 for uid in ram.uid[ram.rows()].tolist()}) == 3


class Cluster(Pool):
    """An executor with machines that are prepared before many calls."""

    prepared = 0

    def on_each_machine(self, folder, function, *arguments):
        assert folder.is_absolute()
        self.submit(function, *arguments).result()
        self.prepared += 1


@pytest.mark.slow
def test_machines_of_a_cluster_compile_the_kernels_of_an_island_first(menagerie, tmp_path, whole):
    archipelago = Archipelago.from_config(config(menagerie), out=tmp_path / "cluster", **OPTIONS)
    with Cluster(1) as pool:
        archipelago.run(on=pool, report=False)
    assert pool.prepared == 1
    assert archipelago.digest == whole.digest


@pytest.mark.slow
def test_two_workers_one_of_them_killed_end_the_same(menagerie, tmp_path, whole):
    archipelago, killed = Archipelago.from_config(config(menagerie), out=tmp_path / "two", **OPTIONS), []

    def kill(done, total):
        if done > total // 2 and not killed:
            killed.append(next(iter(pool._processes._processes)))
            os.kill(killed[0], signal.SIGKILL)

    with Pool(2) as pool:
        archipelago.run(on=pool, progress=kill, report=False)
    assert killed
    assert archipelago.digest == whole.digest


@pytest.mark.slow
def test_it_goes_on_where_a_shorter_one_ended_and_after_a_stop_anywhere(
    menagerie, tmp_path, whole, monkeypatch
):
    archipelago = Archipelago.from_config(config(menagerie), out=tmp_path / "run", **OPTIONS)
    archipelago.run(until=7, report=False)
    assert archipelago.tick == 7
    advance, calls = lab.advance, []

    def failing(folder, name, start, until, *more):
        calls.append(name)
        if len(calls) == 5:
            raise KeyboardInterrupt
        return advance(folder, name, start, until, *more)

    with monkeypatch.context() as m:
        m.setattr(lab, "advance", failing)
        with pytest.raises(KeyboardInterrupt):
            Archipelago(tmp_path / "run").run(until=TICKS, report=False)
    halted = Archipelago(tmp_path / "run")
    assert halted.tick == 10  # the island a is further already, and is run again
    halted.run(report=False)
    assert halted.digest == whole.digest


class Killed(BaseException):
    """The end of a process: nothing is released or removed."""


def test_a_beginning_killed_before_the_manifest_begins_again(menagerie, tmp_path, monkeypatch):
    def killed(*_):
        raise Killed

    with monkeypatch.context() as patch:
        patch.setattr(container, "begin", killed)
        patch.setattr(Claim, "release", lambda claim: os.close(claim._handle))
        with pytest.raises(Killed):
            Archipelago.from_config(config(menagerie), out=tmp_path / "run", **OPTIONS)
    assert (tmp_path / "run").is_dir()
    assert Archipelago.from_config(config(menagerie), out=tmp_path / "run", **OPTIONS).tick == 0


@pytest.mark.slow
def test_a_killed_process_resumes(menagerie, tmp_path, whole):
    """kill -9, twice, at moments that nobody chose."""
    Archipelago.from_config(config(menagerie), out=tmp_path / "run", **OPTIONS)
    code = (
        f"from ecs_eco.lab.archipelago import Archipelago\n"
        f"Archipelago({str(tmp_path / 'run')!r}).run(report=False)\n"
    )
    for pause in (0.05, 0.02):
        victim = subprocess.Popen([sys.executable, "-c", code])
        began = time.monotonic()
        tick = read(tmp_path / "run")["tick"]
        while victim.poll() is None and time.monotonic() - began < 60:  # until it has done something
            if read(tmp_path / "run")["tick"] > tick:
                break
            time.sleep(0.02)
        time.sleep(pause)
        victim.kill()
        victim.wait()
    archipelago = Archipelago(tmp_path / "run")
    archipelago.run(report=False)
    assert archipelago.digest == whole.digest


def test_the_lineage_of_all_islands_has_every_parent(whole):
    lineage = Lineage.read(whole.folder)
    series = {name: load_series(path) for name, path in whole.islands.items()}
    for species in ("ram", "lynx"):
        alive = (lineage.species == species) & lineage.alive(TICKS - 1)
        assert alive.sum() == sum(s.of(species)[-1] for s in series.values())
    crossed = (lineage.parent > 0) & ((lineage.parent >> 48) != (lineage.uid >> 48))
    assert crossed.any()  # born elsewhere than their mother


def test_the_lineage_of_one_island_counts_who_is_there(whole):
    for path in whole.islands.values():
        lineage, series = Lineage.read(path), load_series(path)
        for species in ("ram", "lynx"):
            mask = lineage.species == species
            assert (mask & lineage.alive(TICKS - 1)).sum() == series.of(species)[-1]
            assert "emigrated" in lineage.cause[mask]
        assert not any("emigrated" in name for name in series.columns)


def test_an_island_goes_on_only_with_the_others(whole):
    with pytest.raises(RecordingError, match="is the island a of an archipelago"):
        resume(whole.islands["a"], until=30)


def test_what_cannot_be_is_refused(menagerie, tmp_path, whole):
    with pytest.raises(ConfigError, match="this world has no islands"):
        Archipelago.from_config(menagerie(), out=tmp_path / "none")
    with pytest.raises(ConfigError, match="defines several worlds"):
        World.from_config(config(menagerie))
    with pytest.raises(RecordingError, match=r"no archipelago\.json"):
        Archipelago(whole.islands["a"])
    with pytest.raises(RecordingError, match="is already at tick 20"):
        Archipelago(whole.folder).run(until=10)
    with pytest.raises(FileExistsError):
        Archipelago.from_config(config(menagerie), out=whole.folder)
    copy = shutil.copytree(whole.folder, tmp_path / "copy")
    for file in (copy / "islands" / "b" / "checkpoints").glob("tick-*20.safetensors"):
        file.unlink()
    with pytest.raises(CheckpointError, match="cannot continue from tick 20"):
        Archipelago(copy).run(until=25)
    text = (copy / "archipelago.json").read_text()
    (copy / "archipelago.json").write_text(text.replace('"tick": 20', '"tick": 10'))
    with pytest.raises(RecordingError, match="damaged"):
        Archipelago(copy)
