"""The dead of recorded runs keep their last state, as far as it was recorded or is run again."""

import json

import pytest

from ecs_eco.record.parquet import read_parts
from tests.view.replays import answered


def deaths(replay, species="ram", after=7, before=30):
    """Deaths of some that lived for more than a moment."""
    births = {row["uid"]: row["tick"] for row in read_parts(replay.recording.path / "births").to_pylist()}
    return [
        row
        for row in read_parts(replay.recording.path / "deaths").to_pylist()
        if row["species"] == species and after < row["tick"] < before and births[row["uid"]] < row["tick"] - 6
    ]


def seen(replay, uid, tick):
    replay.handle({"kind": "seek", "tick": tick})
    shown = replay.organism(uid)
    json.dumps(shown, allow_nan=False)
    return shown


def test_of_full_details_the_last_tick_stays_with_the_cause_of_death(full):
    died = deaths(full)
    assert len(died) > 2
    for death in died[:8]:
        uid, tick = death["uid"], death["tick"]
        rows = [
            row for row in read_parts(full.recording.path / "details-ram").to_pylist() if row["uid"] == uid
        ]
        shown = seen(full, uid, tick + 9)
        assert (shown["alive"], shown["as_of"], shown["detail"]) == (False, rows[-1]["tick"], "full")
        assert (shown["died"]["cause"], shown["died"]["tick"]) == (death["cause"], tick)
        assert shown["note"] == f"State in its last tick, {tick}."
        assert {s["name"]: s["value"] for s in shown["nerves"]["sensors"]} == {
            name.removeprefix("sensor: "): pytest.approx(value, rel=1e-5, abs=1e-6)
            for name, value in rows[-1].items()
            if name.startswith("sensor: ")
        }
        assert shown["trace"]["tick"][-1] == tick
        assert "; in its last tick: " in shown["sentence"]
        assert seen(full, uid, tick) == shown == seen(full, uid, 47)


def test_before_it_dies_it_is_as_it_is_then(full):
    death = deaths(full)[0]
    alive = seen(full, death["uid"], death["tick"] - 1)
    assert alive["alive"]
    assert "as_of" not in alive
    assert alive["trace"]["tick"][-1] == death["tick"] - 1


def test_without_details_the_last_snapshot_stays_and_says_of_which_tick_it_is(plain):
    death = deaths(plain)[0]
    last = (death["tick"] - 1) // 6 * 6
    shown = seen(plain, death["uid"], death["tick"] + 9)
    before = seen(plain, death["uid"], last)
    assert (shown["alive"], shown["detail"], shown["as_of"], shown["nerves"]) == (
        False,
        "snapshot",
        last,
        None,
    )
    assert [shown[k] for k in ("place", "energy", "heading", "trace")] == [
        before[k] for k in ("place", "energy", "heading", "trace")
    ]
    assert shown["note"].startswith(
        f"State at tick {last}, in its last snapshot, without the nervous system. “Fill in”"
    )


def test_of_one_that_no_snapshot_shows_birth_and_death_are_known(plain):
    births = {row["uid"]: row["tick"] for row in read_parts(plain.recording.path / "births").to_pylist()}
    short = next(
        row
        for row in read_parts(plain.recording.path / "deaths").to_pylist()
        if births[row["uid"]] // 6 == (row["tick"] - 1) // 6 and births[row["uid"]] % 6
    )
    shown = seen(plain, short["uid"], 47)
    assert (shown["detail"], shown["place"], shown["died"]["cause"]) == ("record", None, short["cause"])
    assert "as_of" not in shown
    assert shown["note"].startswith("The run recorded nothing between its birth and its death. “Fill in”")


def test_what_is_filled_in_of_a_dead_one_is_what_full_details_say(plain, full):
    death = deaths(plain)[-1]
    uid, tick = death["uid"], death["tick"]
    assert plain.handle({"kind": "seek", "tick": 47}) == []
    (said,) = plain.handle({"kind": "fill", "uid": uid})
    assert said["text"].endswith(f"before tick {tick + 1}")
    _, panel, _ = answered(plain)
    theirs = seen(full, uid, 47)
    assert panel["note"].startswith(f"State in its last tick, {tick}. Rerun from a checkpoint")
    assert panel["sex"] in ("female", "male")
    for key in ("alive", "as_of", "nerves", "place", "energy", "heading", "died", "sentence"):
        assert panel[key] == theirs[key], key
    assert plain.handle({"kind": "fill", "uid": uid})[0]["as_of"] == tick  # it is there already


def test_an_unborn_one_is_not_dead(plain):
    births = read_parts(plain.recording.path / "births").to_pylist()
    late = next(row for row in births if row["tick"] > 9 and row["species"] == "ram")
    shown = seen(plain, late["uid"], 3)
    assert (shown["alive"], shown["note"], shown["nerves"]) == (False, "Not born yet.", None)


def test_to_fill_in_one_that_never_was_is_refused(plain):
    with pytest.raises(ValueError, match="fill: no organism of this run has the uid 99999"):
        plain.handle({"kind": "fill", "uid": 99999})
