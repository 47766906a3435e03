"""The panel of two worlds: an organism of either, and of which of them it is."""

import json
import math
import struct

import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.view.families import KIN
from ecs_eco.view.live import Live
from ecs_eco.view.pair import Pair
from ecs_eco.view.replay import Replay
from ecs_eco.view.watch import served
from tests.view.parks import SMALL, small

WITHOUT = {"kind": "cull", "species": "wolf", "share": 1.0}
MORE = {"kind": "add", "species": "wolf", "count": 3}


class Reader:
    """A page that reads what it gets, and asks for what it is told to."""

    def __init__(self, pair):
        self.player, self.messages = served(pair, playing=False), []
        self.asks("join")

    def asks(self, kind, **more):
        self.player.say(self, {"kind": kind, **more})

    def send(self, messages):
        for message in messages:
            if isinstance(message, bytes):
                self.asks("ack", frame=struct.unpack_from("<I", message, 4)[0])
            else:
                self.messages.append(json.loads(message))

    def sees(self, kind):
        """What it gets of a kind as soon as the player serves it again."""
        self.messages.clear()
        for _ in range(2):  # to take what was asked for, and to serve
            self.player._looks = -math.inf, -math.inf
            for view in self.player._views.values():
                view.panel_at = view.frame_at = -math.inf
            self.player.poll()
        return [message for message in self.messages if message["kind"] == kind]


def forked(change=WITHOUT, at=4, until=8):
    """Two worlds that have parted at a tick, some ticks later, and a page that looks at them."""
    pair = Pair(Live(small()))
    pair.first.world.run(at)
    pair.handle({"kind": "whatif", "what": change})
    pair.first.world.run(until - at)
    pair.passed()
    pair.second.follow(60)
    return pair, Reader(pair)


def uids(source, species):
    table = source.world.tables[species]
    return table.uid[table.rows()].tolist()


def test_an_organism_of_either_world_is_shown_with_the_name_of_its_world():
    pair, page = forked()
    uid = min(set(uids(pair.first, "deer")) & set(uids(pair.second.source, "deer")))
    for second, name, source in ((False, "original", pair.first), (True, "what if", pair.second.source)):
        page.asks("select", uid=uid, second=second)
        (shown,) = page.sees("organism")
        assert (shown["uid"], shown["world"], shown["second"], shown["both"]) == (uid, name, second, True)
        assert shown["energy"] == source.organism(uid)["energy"]
        assert shown["nerves"] is not None


def test_one_that_was_culled_there_is_dead_there_and_alive_here():
    pair, page = forked()
    uid = uids(pair.first, "wolf")[0]
    page.asks("select", uid=uid)
    assert page.sees("organism")[0]["alive"]
    page.asks("select", uid=uid, second=True)
    (shown,) = page.sees("organism")
    assert (shown["alive"], shown["died"]["tick"], shown["both"]) == (False, 4, True)


def test_one_that_lives_in_the_second_world_alone_is_known_there_alone():
    pair, page = forked(MORE)
    uid = max(uids(pair.second.source, "wolf"))
    assert uid not in uids(pair.first, "wolf")
    page.asks("select", uid=uid, second=True)
    (shown,) = page.sees("organism")
    assert (shown["species"], shown["alive"], shown["both"], shown["born"]) == ("wolf", True, False, 4)
    before = shown["age"]
    pair.first.world.run(1)
    pair.passed()
    pair.second.follow(60)
    assert page.sees("organism")[0]["age"] > before


@pytest.mark.parametrize("at", [4, 6])
def test_those_born_before_the_worlds_parted_are_in_both_and_no_others(at):
    pair = Pair(Live(small()))
    pair.first.ring.used = True
    for _ in range(6):
        pair.first.ring.look()
        if pair.tick == at:
            next_uid = pair.first.world.next_uid
        pair.first.world.run(1)
    if at == 6:
        next_uid = pair.first.world.next_uid
    pair.handle({"kind": "whatif", "tick": at, "what": MORE})
    pair.first.world.run(3)
    pair.second.follow(60)
    assert pair.second.shares(next_uid - 1)
    assert not pair.second.shares(next_uid)
    pair.handle({"kind": "seek", "tick": 7})
    pair.second.follow(60)
    assert [pair.second.shares(next_uid - by) for by in (1, 0)] == [True, False]


def test_two_worlds_that_never_were_one_have_nobody_in_common():
    other = World.from_config(load("predator-prey", SMALL), seed=6, policies="random", record=False)
    page = Reader(Pair(Live(small()), Live(other), ("five", "six")))
    for second, name in ((False, "five"), (True, "six")):
        page.asks("select", uid=310, second=second)
        (shown,) = page.sees("organism")
        assert shown["world"] == name
        assert "both" not in shown


def test_descendants_of_one_that_the_second_world_does_not_have_are_not_coloured_there():
    pair, _ = forked(MORE)
    mine, both = pair.first.world.next_uid - 1, 310
    pair.second.common = mine
    assert pair.second.frame(1, f"{KIN}{mine}") == pair.second.frame(1, "species")
    assert pair.second.frame(1, f"{KIN}{both}") != pair.second.frame(1, "species")


def test_what_is_asked_of_a_second_world_that_is_not_there_is_refused():
    page = Reader(Pair(Live(small())))
    page.asks("select", uid=310, second=True)
    page.asks("select", uid=310, second="yes")
    page.asks("select", uid=310)
    said = page.sees("said")
    assert [(one["level"], one["field"]) for one in said] == [("error", "select")] * 2
    assert "no second world is shown" in said[0]["text"]
    assert "expected true or false" in said[1]["text"]
    (shown,) = [m for m in page.messages if m["kind"] == "organism"]
    assert "world" not in shown


def test_whoever_is_selected_there_is_not_asked_for_when_it_is_closed():
    _, page = forked()
    page.asks("select", uid=310, second=True)
    assert page.sees("organism")
    page.asks("whatif", close=True)
    assert page.sees("said")[0]["level"] == "info"
    page.messages.clear()
    assert page.sees("organism") == page.sees("said") == []


def test_the_panel_of_the_first_says_at_once_that_there_are_two_worlds():
    page = Reader(Pair(Live(small())))
    page.asks("select", uid=310)
    assert "world" not in page.sees("organism")[0]
    page.asks("whatif", what=None)
    assert page.sees("organism")[0]["world"] == "original"


def test_of_two_recorded_runs_either_is_filled_in(tmp_path):
    run_to_folder(load("predator-prey", SMALL), 5, 10, tmp_path, "random", report=False)
    pair = Pair(Replay(tmp_path), Replay(tmp_path), ("a", "b"))
    page = Reader(pair)
    pair.handle({"kind": "seek", "tick": 5})
    pair.passed()
    page.asks("select", uid=310, second=True)
    (shown,) = page.sees("organism")
    assert (shown["world"], shown["detail"]) == ("b", "snapshot")
    page.asks("fill", uid=310, second=True)
    assert "rerunning" in page.sees("said")[0]["text"]
    pair.second.source._rerun._thread.join(60)
    filled = page.sees("organism")
    assert {(one["world"], one["detail"]) for one in filled} == {("b", "full")}
    page.asks("select", uid=310)
    assert page.sees("organism")[0]["detail"] == "snapshot"
