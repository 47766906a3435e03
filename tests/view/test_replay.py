import json
import struct

import numpy as np
import pytest

from ecs_eco.record import resume
from ecs_eco.record.parquet import read_parts
from ecs_eco.view.frames import HEADER, MAGIC
from ecs_eco.view.recording import Recording
from ecs_eco.view.replay import Replay
from ecs_eco.view.rerun import compute
from tests.view.replays import MADE, TICKS, answered, record


def _decoded(frame, kinds):
    magic, number, tick, *_, n = HEADER.unpack_from(frame)
    assert (magic, n) == (MAGIC, kinds)
    counts = struct.unpack_from(f"<{n}I", frame, HEADER.size)
    words = np.frombuffer(frame, "<u4", offset=HEADER.size + 4 * n).reshape(-1, 3)
    assert len(words) == sum(counts)
    return number, tick, counts, words


def test_all_messages_are_json_and_say_what_was_recorded(plain):
    hello = plain.hello()
    json.dumps([hello, *plain.greeting(), plain.series(-1)], allow_nan=False)
    assert [hello[k] for k in ("kind", "mode", "first", "last", "tick", "acts")] == [
        "hello",
        "replay",
        0,
        47,
        0,
        False,
    ]
    assert [k["name"] for k in hello["species"]] == ["moss", "ram", "lynx"]
    # carcasses come and go: they are not recorded
    assert [k["name"] for k in hello["objects"]] == ["boulder", "cone", "cairn"]
    assert hello["colours"] == ["species", "energy", "happiness", "age", "family", "gene:pace"]
    assert "every 6 ticks" in hello["note"]
    assert hello["terrain"]["lakes"][0]["radius"] == 4.0
    assert [k["learns"] for k in hello["species"]] == [False, True, False]
    marks = plain.greeting()[0]
    assert (sum(marks["deaths"]), marks["interventions"], marks["fences"]) == (
        plain.recording.deaths.rows,
        [],
        [],
    )


def test_curves_are_those_of_the_recorder(plain):
    series = plain.series(-1)
    assert series["tick"] == list(range(TICKS))
    assert series["n"]["ram"][30] == plain.recording.numbers(30)["ram"]
    assert set(series["happiness"]) == {"ram"}
    assert plain.series(TICKS - 1) is None
    genes = series["genes"]["ram.pace"]
    plain.handle({"kind": "seek", "tick": 30})
    paces = plain.crowd("ram").value("gene:pace")
    assert genes[30] == pytest.approx(float(paces.mean()), rel=1e-4)


@pytest.mark.parametrize("colour", ["species", "energy", "happiness", "age", "family", "gene:pace"])
def test_a_frame_holds_all_who_live_then(plain, colour):
    for tick in (0, 17, 47):
        plain.handle({"kind": "seek", "tick": tick})
        number, at, counts, words = _decoded(plain.frame(5, colour), 6)
        assert (number, at) == (5, tick)
        kinds = ("moss", "ram", "lynx", "boulder", "cone", "cairn")
        assert dict(zip(kinds, counts, strict=True)) == plain.counts()
        ram = words[counts[0] : counts[0] + counts[1]]
        crowd = plain.organisms("ram")
        assert ram[:, 2].tolist() == crowd.uid.tolist()
        assert (ram[:, 0] & 0xFFFF) / 65535 * 40 == pytest.approx(crowd.x, abs=1e-3)
        value = ram[:, 1] >> 24
        if colour == "energy":
            assert value == pytest.approx(1 + 254 * crowd.energy.clip(0), abs=1)
        assert (value == 0).all() == (colour == "species")


def test_time_goes_on_to_the_last_tick_and_back(plain):
    turns = iter([True] * 50 + [False])
    plain.run(lambda: next(turns))
    assert (plain.tick, plain.done) == (47, True)
    for asked, tick in ((3, 3), (-5, 0), (10**9, 47), (12.6, 13)):
        assert plain.handle({"kind": "seek", "tick": asked}) == []
        assert plain.tick == tick
    for wrong in ("x", None, True, float("nan")):
        with pytest.raises(ValueError, match="expected a tick from 0 to 47"):
            plain.handle({"kind": "seek", "tick": wrong})


def test_a_recording_is_not_acted_upon(plain):
    answer = plain.handle({"kind": "act", "what": {"kind": "cull", "species": "ram", "share": 0.5}})
    assert (answer[0]["kind"], answer[0]["level"]) == ("said", "warning")
    assert "resume" in answer[0]["text"]


def test_of_full_details_the_panel_says_all(full, folders):
    table = read_parts(folders / "full" / "details-ram").to_pylist()
    for row in table[:: len(table) // 20]:
        full.handle({"kind": "seek", "tick": row["tick"]})
        shown = full.organism(row["uid"])
        json.dumps(shown, allow_nan=False)
        note = "" if shown["alive"] else f"State in its last tick, {row['tick']}."
        assert (shown["detail"], shown["note"], shown["species"]) == ("full", note, "ram")
        assert shown["nerves"]["sensors"][0] == {
            "name": "energy",
            "value": pytest.approx(row["sensor: energy"]),
        }
        run = next(a for a in shown["nerves"]["actions"] if a["name"] == "run")
        assert [run[k] for k in ("group", "reflex", "chosen", "decision")] == [
            "speed",
            row["reflex: speed.run"],
            row["chosen: speed.run"],
            row["decision: speed.run"],
        ]
        assert run["probability"] == pytest.approx(row["probability: speed.run"])
        assert shown["trace"]["tick"][-1] == row["tick"]
        assert shown["genome"]["genes"][0]["name"] == "pace"


def test_without_details_the_panel_says_so(plain):
    uid = int(plain.recording.organisms(30, "ram").uid[0])
    plain.handle({"kind": "seek", "tick": 32})
    shown = plain.organism(uid)
    assert (shown["detail"], shown["nerves"]) == ("snapshot", None)
    assert shown["note"].startswith(
        "State at tick 30. Recorded every 6 ticks, without the nervous system. “Fill in”"
    )
    assert shown["trace"]["tick"] == [0, 6, 12, 18, 24, 30]
    plain.handle({"kind": "seek", "tick": 30})
    assert plain.organism(uid)["note"].startswith("Recorded every 6 ticks")


def test_the_dead_and_the_unborn_have_their_pedigree(plain):
    deaths = read_parts(plain.recording.path / "deaths").to_pylist()
    death = next(d for d in deaths if d["species"] == "ram" and d["tick"] > 5)
    plain.handle({"kind": "seek", "tick": 47})
    shown = plain.organism(death["uid"])
    assert (shown["alive"], shown["died"]["tick"], shown["died"]["cause"]) == (
        False,
        death["tick"],
        death["cause"],
    )
    births = read_parts(plain.recording.path / "births").to_pylist()
    born = next(b for b in births if b["parent"] and b["species"] == "ram" and b["tick"] > 3)
    plain.handle({"kind": "seek", "tick": 1})
    young = plain.organism(born["uid"])
    assert (young["alive"], young["note"], young["parents"], young["detail"]) == (
        False,
        "Not born yet.",
        [born["parent"]],
        "record",
    )
    assert born["uid"] in plain.organism(born["parent"])["children"]
    plain.handle({"kind": "seek", "tick": born["tick"]})
    # nothing was recorded nearer than its birth
    assert plain.organism(born["uid"])["energy"] == pytest.approx(born["energy"])
    with pytest.raises(KeyError, match="no organism of this run has the uid 99999"):
        plain.organism(99999)


def test_what_is_filled_in_is_what_full_details_would_have_been(plain, full):
    living = [full.recording.organisms(tick, "ram").uid.tolist() for tick in (22, 33, 40)]
    uid = min(set.intersection(*map(set, living)))
    for replay in (plain, full):
        replay.handle({"kind": "seek", "tick": 33})
    assert plain.handle({"kind": "fill", "uid": uid})[0]["level"] == "info"
    answer, panel, marks = answered(plain)
    assert [s["kind"] for s in marks["stretches"]] == ["filled"]
    assert (answer["kind"], answer["level"]) == ("said", "info")
    assert panel["uid"] == uid
    for tick in (22, 33, 40):
        for replay in (plain, full):
            replay.handle({"kind": "seek", "tick": tick})
        mine, theirs = plain.organism(uid), full.organism(uid)
        assert mine["sex"] in ("female", "male")  # what no record says
        assert mine["nerves"] == theirs["nerves"]
        assert [mine[k] for k in ("detail", "energy", "place", "heading")] == [
            theirs[k] for k in ("detail", "energy", "place", "heading")
        ]
    assert plain.organisms("ram").x.tolist() == full.organisms("ram").x.tolist()
    assert plain.organisms("ram").exact.all()
    assert plain.handle({"kind": "fill", "uid": uid})[0]["kind"] == "organism"  # it is there already


def test_what_was_done_by_hand_is_done_again(menagerie, tmp_path):
    def prepare(world):
        def between():
            if world.tick == 11:
                world.intervene({"kind": "cull", "species": "ram", "share": 0.4})
                world.intervene({"kind": "set", "set": {"species.ram.reproduction.rate": 0.5}})
            if world.tick == 14:
                world.intervene({"kind": "fence", "line": [[5, 5], [20, 5]]})

        world.before_tick.append(between)

    planned = menagerie(interventions=[{"kind": "add", "at": 11, "species": "lynx", "count": 3}])
    record(planned, tmp_path / "run", ticks=30, prepare=prepare)
    recording = Recording(tmp_path / "run")
    assert [i["tick"] for i in recording.interventions()] == [11, 11, 11, 14]
    stretch = compute(recording.path, recording.manifest, 20, 29, recording.recorded)
    assert (stretch.first, stretch.last, stretch.wrong) == (0, 29, None)
    replay = Replay(tmp_path / "run")
    assert [recording.land(tick)["fences"] for tick in (13, 14)] == [[], [{"line": [[5, 5], [20, 5]]}]]
    replay.handle({"kind": "seek", "tick": 20})
    marks = replay.news()
    assert marks[0]["fences"] == [[[5.0, 5.0], [20.0, 5.0]]]
    assert replay.news() == []


def test_a_stretch_that_comes_out_otherwise_says_so(plain):
    def recorded(tick):
        return plain.recording.recorded(tick) | ({"n": np.zeros(3, np.int32)} if tick == 25 else {})

    stretch = compute(plain.recording.path, plain.recording.manifest, 24, 47, recorded)
    assert stretch.wrong == 25


@pytest.mark.slow
def test_without_a_checkpoint_before_it_a_run_is_run_from_its_start(menagerie, tmp_path):
    record(menagerie(), tmp_path / "run", checkpoint_every=20, keep=1)
    replay = Replay(tmp_path / "run")
    assert [p.name for p in (tmp_path / "run" / "checkpoints").iterdir()] == ["tick-000000000048.safetensors"]
    replay.handle({"kind": "seek", "tick": 9})
    replay.handle({"kind": "fill", "uid": int(replay.recording.organisms(9, "ram").uid[0])})
    assert answered(replay)[0]["level"] == "info"


def test_a_run_that_went_on_is_one_run(menagerie, tmp_path, folders):
    record(menagerie(**MADE), tmp_path / "run", ticks=20)
    resume(tmp_path / "run", until=TICKS, report=False)
    once, twice = Replay(folders / "plain"), Replay(tmp_path / "run")
    for replay in (once, twice):
        replay.handle({"kind": "seek", "tick": 23})
    assert once.frame(1, "age") == twice.frame(1, "age")


def test_the_sun_of_a_recording_stands_where_it_stood(plain):
    assert plain.hello()["day"] == {"length": 24.0, "start": 0.25}
    # from sunrise
    for tick, light, elevation in ((0, 0.0, 0), (12, 0.8, 90), (24, 0.0, 0), (36, 0.0, -90), (12, 0.8, 90)):
        plain.handle({"kind": "seek", "tick": tick})
        assert HEADER.unpack_from(plain.frame(1, "species"))[4:6] == pytest.approx(
            (light, np.radians(elevation)), abs=1e-6
        )
    series = plain.series(-1)
    assert series["light"][series["tick"].index(12)] == 0.8


def test_the_extinct_are_not_said_to_be_unhappy(menagerie, tmp_path):
    cull = {"kind": "cull", "species": "ram", "share": 1.0, "at": 4}
    record(
        menagerie(**MADE) | {},
        tmp_path / "gone",
        ticks=8,
        prepare=lambda world: world.intervene({k: v for k, v in cull.items() if k != "at"}),
    )
    series = Replay(tmp_path / "gone").series(-1)
    assert series["n"]["ram"][-1] == 0
    assert series["happiness"]["ram"][-1] is None
