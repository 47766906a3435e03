import json

import numpy as np
import pyarrow.parquet as pq
import pytest

from ecs_eco import World
from ecs_eco.components import Metabolism, Nervous, Position
from ecs_eco.engine.errors import ConfigError, RecordingError
from ecs_eco.nervous.thoughts import minds, thinkers
from ecs_eco.record import Recorder, fork, resume, run_to_folder
from ecs_eco.record.details import columns_of, how_many
from ecs_eco.record.parquet import read_parts

TICKS = 40


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


def _bytes(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*.parquet")}


def _details(folder, species):
    return {
        name: column.to_numpy()
        for name, column in zip(*_named(read_parts(folder / f"details-{species}")), strict=True)
    }


def _named(table):
    return table.column_names, table.columns


@pytest.mark.parametrize(
    "word", ["focal", "focal=", "focal=0", "focal=-3", "focal=1.5", "all", "fulll", "focal=9999999"]
)
def test_other_words_than_focal_and_full_are_refused(word):
    with pytest.raises(ConfigError, match=r"focal=N with N from 1 to 1000000, or full"):
        how_many(word)


def test_words_that_are_understood():
    assert [how_many(w) for w in (None, "focal=50", "full")] == [0, 50, None]


def test_details_need_a_sink(meadow):
    with pytest.raises(ValueError, match="no sink to receive the details"):
        Recorder(meadow(options={"record": False}), record="full")


class _Sink(dict):
    def __call__(self, kind, columns):
        self.setdefault(kind, []).append(columns)


def test_full_details_are_those_of_all_who_live_and_die(menagerie):
    world = World.from_config(menagerie(), policies="untrained", learn=True, record=False)
    sink = _Sink()
    recorder = Recorder(world, sink, record="full")
    for tick in range(30):
        table = world.tables["ram"]
        before = set(table.uid[table.rows()].tolist())
        world.run(1)
        recorder.flush()
        block = sink["details-ram"].pop()
        assert set(block["tick"].tolist()) == {tick}
        # who sensed: also those that died of it, none of the newborn
        assert block["uid"].tolist() == sorted(before)
        rows, at = thinkers(table)
        mind, n, mine = minds(table, rows, at), table[Nervous], np.isin(block["uid"], table.uid[rows])
        for name, expected in zip(
            ("x", "energy", "happiness", "reward"),
            (table[Position].x, table[Metabolism].energy, n.happiness, n.reward),
            strict=True,
        ):
            assert block[name][mine].tolist() == expected[rows].tolist()
        nerves = table.species.nerves
        sensed = np.stack([block[f"sensor: {c}"][mine] for c in nerves.channels], axis=1)
        decided = np.stack([block[f"decision: {g}.{a}"][mine] for g, a in nerves.actions], axis=1)
        assert (sensed == mind.x).all()
        assert (decided == mind.decision).all()
    assert "details-moss" not in sink  # it has no nervous system


def test_columns_leave_out_what_the_policy_has_no_say_in(menagerie):
    world = World.from_config(menagerie(), policies="untrained")
    ram, lynx = (columns_of(world.tables[name].species.nerves) for name in ("ram", "lynx"))
    assert "probability: speed.run" in ram
    assert [c for c in lynx if c.startswith("probability")] == []
    assert [c for c in lynx if c.startswith("decision")][-1] == "decision: eat.eat"


def test_a_focal_sample_follows_newborn_from_birth_to_death(menagerie, tmp_path):
    _run(menagerie(), tmp_path / "run", ticks=80, record="focal=12")
    details = _details(tmp_path / "run", "ram")
    births, deaths = (read_parts(tmp_path / "run" / kind).to_pylist() for kind in ("births", "deaths"))
    born = {b["uid"]: b["tick"] for b in births if b["species"] == "ram"}
    died = {d["uid"]: d["tick"] for d in deaths if d["species"] == "ram"}
    founders = sorted(b["uid"] for b in births if b["species"] == "ram" and not b["parent"])
    first = founders[:12]
    seen = {int(u): details["tick"][details["uid"] == u] for u in np.unique(details["uid"])}
    assert len(seen) > 15  # some were replaced
    sample = set(first)
    for tick in range(80):  # the rule, the slow way
        assert set(details["uid"][details["tick"] == tick].tolist()) == {
            u for u in sample if born[u] < tick or u in first
        }
        dying = {u for u in sample if died.get(u) == tick}
        sample -= dying
        newborn = sorted(u for u, t in born.items() if t == tick and u not in founders)
        sample |= set(newborn[: 12 - len(sample)])
    for uid, ticks in seen.items():
        if uid not in first and uid in died:
            assert ticks.tolist() == list(range(born[uid] + 1, died[uid] + 1))


@pytest.mark.parametrize("record", ["focal=6", "full"])
def test_details_change_no_result(menagerie, tmp_path, record):
    plain, detailed = (
        _run(menagerie(), tmp_path / word, record=r) for word, r in (("plain", None), ("detailed", record))
    )
    assert detailed["digest"] == plain["digest"]
    kinds = {k: v for k, v in _bytes(tmp_path / "detailed").items() if not k.startswith("details-")}
    assert kinds == _bytes(tmp_path / "plain")
    assert {k for k in detailed["parts"] if k.startswith("details-")} == {"details-ram", "details-lynx"}


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, 12, 17])
def test_a_run_that_goes_on_has_the_same_details(menagerie, tmp_path, first):
    _run(menagerie(), tmp_path / "whole", checkpoint_every=6, record="focal=6")
    _run(menagerie(), tmp_path / "cut", ticks=first, checkpoint_every=6, record="focal=6")
    resume(tmp_path / "cut", until=TICKS, report=False)
    for species in ("ram", "lynx"):
        whole, cut = (_details(tmp_path / word, species) for word in ("whole", "cut"))
        assert list(whole) == list(cut)
        assert all(whole[name].tobytes() == cut[name].tobytes() for name in whole)


@pytest.mark.slow
def test_after_a_power_cut_the_parts_are_the_same_bytes(menagerie, tmp_path, monkeypatch):
    from ecs_eco import systems
    from ecs_eco.runs import run

    _run(menagerie(), tmp_path / "whole", checkpoint_every=6, record="focal=6")
    process = systems.Feed.process

    def failing(self, *arguments):
        process(self, *arguments)
        if self.world.tick == 29:
            raise SystemExit

    with monkeypatch.context() as m:
        m.setattr(systems.Feed, "process", failing)
        m.setattr(run, "close", lambda *_, **__: None)
        with pytest.raises(SystemExit):
            _run(menagerie(), tmp_path / "cut", checkpoint_every=6, record="focal=6")
    stray = tmp_path / "cut" / "details-lynx" / "part-00077.parquet"
    stray.write_bytes(b"of somebody else")
    with pytest.raises(RecordingError, match=r"details-lynx/part-00077\.parquet: is damaged"):
        resume(tmp_path / "cut", report=False)
    stray.unlink()
    resume(tmp_path / "cut", report=False)
    assert _bytes(tmp_path / "cut") == _bytes(tmp_path / "whole")
    assert len([name for name in _bytes(tmp_path / "whole") if name.startswith("details-ram")]) > 4


def test_a_fork_begins_a_sample_of_its_own(menagerie, tmp_path):
    _run(menagerie(), tmp_path / "run", checkpoint_every=10, record="focal=5")
    fork(tmp_path / "run", tmp_path / "fork", from_tick=20, report=False)
    details = _details(tmp_path / "fork", "ram")
    assert details["tick"].min() == 20
    assert set(np.unique(details["uid"], return_counts=True)[1]) - {1}
    assert (np.unique(details["tick"], return_counts=True)[1] <= 5).all()
    assert json.loads((tmp_path / "fork" / "manifest.json").read_text())["record"] == "focal=5"


def test_large_samples_are_handed_over_in_parts(menagerie, tmp_path, monkeypatch):
    monkeypatch.setattr("ecs_eco.record.details.ROWS", 200)
    _run(menagerie(), tmp_path / "run", record="full")
    parts = sorted((tmp_path / "run" / "details-ram").glob("*.parquet"))
    assert len(parts) > 3
    assert all(pq.read_metadata(p).num_rows < 300 for p in parts)


def test_the_command_line_hands_it_on_and_refuses_other_words(tmp_path):
    from typer.testing import CliRunner

    from ecs_eco.cli.app import app

    def run(out, record):
        words = [
            "run",
            "lamb",
            "--ticks",
            "5",
            "-q",
            "--no-report",
            "--out",
            str(tmp_path / out),
            "--record",
            record,
        ]
        return CliRunner().invoke(app, words)

    assert run("good", "focal=2").exit_code == 0
    manifest = json.loads((tmp_path / "good" / "manifest.json").read_text())
    assert (manifest["record"], manifest["parts"]["details-lamb"]) == ("focal=2", 1)
    assert "--record focal=2" in manifest["command"]
    assert len(_details(tmp_path / "good", "lamb")["uid"]) == 10
    refused = run("bad", "some")
    assert (refused.exit_code, (tmp_path / "bad").exists()) == (2, False)
    assert "expected: focal=N with N from 1 to 1000000, or full" in refused.output


def test_the_rewards_of_a_life_add_up_to_the_least_happiness_minus_the_first(menagerie, tmp_path):
    _run(menagerie(), tmp_path / "run", ticks=60, record="full")
    details = _details(tmp_path / "run", "ram")
    deaths = {d["uid"]: d["tick"] for d in read_parts(tmp_path / "run" / "deaths").to_pylist()}
    lives = 0
    for uid in np.unique(details["uid"]).tolist():
        own = details["uid"] == uid
        tick, happiness, reward = (details[name][own] for name in ("tick", "happiness", "reward"))
        last = -1.0 if deaths.get(uid) == tick[-1] else happiness[-1]
        assert reward.sum(dtype=float) == pytest.approx(last - happiness[0], abs=1e-5)
        lives += tick.size > 1 and last == -1.0
    assert lives > 5
