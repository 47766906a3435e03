"""Two worlds through one source: frames of both, one clock, what differs, an original that stays as it is."""

import struct
import time
import tomllib

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.runs.repeat import repeat
from ecs_eco.view.branch import Start
from ecs_eco.view.frames import HEADER
from ecs_eco.view.live import Live
from ecs_eco.view.pair import Pair
from ecs_eco.view.player import PATIENCE
from ecs_eco.view.replay import Replay
from ecs_eco.view.watch import Window, served
from tests.view.parks import ACTS, SMALL, Page, small

WITHOUT = {"kind": "cull", "species": "wolf", "share": 1.0}
START = Start(["run", "predator-prey", "--seed", "5", "--policies", "random"])


def asks(kind, **more):
    return {"kind": kind, **more}


def watched(source, ticks, requests=None, speed=None):
    """Let pages see the ticks of a source, or of a pair, one after the other; `requests` by the tick at which
    they are made. Returns the pair and the page."""
    player = served(source, speed, playing=False)
    page, due = Page(player), dict(requests or {})
    say = page.player.say

    def then(one, request):
        if request["kind"] == "step":
            for asked in due.pop(player.source.tick, []):
                say(one, asked)
        say(one, request)

    page.player = type("Through", (), {"say": staticmethod(then)})
    player.halted = lambda: player.source.tick >= ticks and bool(page.frames) and ticks in page.ticks
    player.source.run(player.turn)
    return player.source, page


def parts(message):
    """The frames in a binary message: (tick, numbers of each kind)."""
    out, at = [], 0
    while at < len(message):
        _, _, tick, wide, _, _, kinds = HEADER.unpack_from(message, at)
        n = struct.unpack_from(f"<{kinds}I", message, at + HEADER.size)
        out.append((tick, n))
        at += HEADER.size + 4 * kinds + sum(n) * (16 if wide else 12)
    assert at == len(message)
    return out


def beside(page, what):
    return [message[what] for message in page.got("beside") if what in message]


def deer_by_tick(series):
    return {tick: n for one in series for tick, n in zip(one["tick"], one["n"]["deer"], strict=True)}


def test_the_original_is_the_same_with_a_fork_and_without():
    pair, _ = watched(Live(small()), 20, {8: [asks("whatif", tick=None, what=WITHOUT)]})
    alone, _ = watched(Live(small()), 20)
    assert pair.second.told["change"] == "cull 100% of wolf"
    assert pair.first.world.digest() == alone.first.world.digest() == small().run(20).digest()
    assert pair.second.source.world.digest() != pair.first.world.digest()
    assert pair.first.counts()["wolf"] > pair.second.source.counts()["wolf"] == 0


def test_a_message_holds_a_frame_of_each_at_the_same_tick():
    _, page = watched(Live(small()), 14, {8: [asks("whatif", what=WITHOUT)]})
    frames = [parts(frame) for frame in page.frames]
    assert {len(both) for both in frames if both[0][0] < 8} == {1}
    for one, other in (both for both in frames if both[0][0] > 8):
        assert one[0] == other[0]
        assert other[1][2] == 0 < one[1][2]
    names = [kind["name"] for kind in beside(page, "hello")[0]["species"]]
    assert names == ["grass", "deer", "wolf"]


def test_a_fork_of_an_earlier_tick_comes_up_while_time_stands_still():
    pair, page = watched(Live(small()), 24, {20: [asks("whatif", tick=4, what=None)]})
    assert (pair.second.start, pair.second.tick) == (4, 24)
    assert pair.second.source.world.digest() == pair.first.world.digest()
    forked, original = (deer_by_tick(series) for series in (beside(page, "series"), page.got("series")))
    assert min(forked) >= 4
    both = set(forked) & set(original)
    assert len(both) > 3
    assert {tick: forked[tick] for tick in both} == {tick: original[tick] for tick in both}
    assert pair.second.sentence()["state"]["text"] == "After 20 ticks: the same numbers in both."


def test_a_page_that_is_slow_gets_no_more_of_two_worlds_than_of_one():
    """What it cannot read yet would wait in front of what it asks for: a pause among others."""

    class Slow(Page):
        def send(self, messages):
            self.messages += messages

    player = served(Pair(Live(small(), 200), Live(small(), 200), ("one", "other")), None)
    page = Slow(player, {})
    player.halted = lambda: player.source.done
    began = time.monotonic()
    player.source.run(player.turn)
    assert player.source.tick == 200 == player.source.second.tick
    greeting, waits = 20, (time.monotonic() - began) / PATIENCE
    assert len([message for message in page.messages if isinstance(message, bytes)]) == 1
    assert len(page.messages) < greeting + 5 * waits


def test_the_log_says_when_the_worlds_parted_and_by_what():
    pair, page = watched(
        Live(small()), 12, {8: [asks("whatif", what=WITHOUT)], 10: [asks("whatif", close=True)]}
    )
    logs = [marks["interventions"] for marks in page.got("marks")]
    assert [{"tick": 8, "text": "what if: cull 100% of wolf"}] in logs
    assert logs[-1] == []  # it is closed
    assert pair.second is None
    assert "closed" in page.got("beside")[-1]
    assert len(parts(page.frames[-1])) == 1


def test_what_pages_do_is_done_to_both():
    pair, _ = watched(Live(small()), 16, {8: [asks("whatif", what=None)], 11: [asks("act", what=ACTS[3])]})
    assert [tick for tick, _ in pair.second.source.world.intervened] == [11]
    assert pair.second.source.world.digest() == pair.first.world.digest()


def test_both_go_back_together_and_before_the_fork_there_is_one():
    pair, _ = watched(Live(small()), 20, {8: [asks("whatif", what=WITHOUT)]})
    assert pair.second.tick == pair.tick == 20
    pair.handle(asks("seek", tick=12))
    assert pair.second.tick == pair.tick == 12
    assert pair.second.there
    pair.handle(asks("seek", tick=5))
    assert (pair.tick, pair.second.tick, pair.second.there) == (5, 8, False)
    assert len(parts(pair.frame(1, "species"))) == 1
    assert pair.second.sentence()["state"]["text"] == "It diverges from the original at tick 8."
    with pytest.raises(ValueError, match="the worlds diverge at tick 8"):
        pair.handle(asks("act", what=ACTS[3]))
    pair.first.world.run(15)
    while not pair.second.there:  # each call lets the second world run for a twentieth of a second
        pair.passed()
    assert pair.second.tick == pair.tick == 20
    assert pair.first.world.digest() == small().run(20).digest()


def test_what_does_not_fit_is_said_and_nothing_is_opened():
    wrong = {"kind": "set", "set": {"species.deer.metabolism.basl": 0.1}}
    pair, page = watched(
        Live(small()),
        8,
        {
            5: [
                asks("whatif", what=wrong),
                asks("whatif", tick=9),
                asks("whatif", tick=2.5),
                asks("whatif", what="fire"),
            ]
        },
    )
    said = [m["text"] for m in page.got("said")]
    assert pair.second is None
    assert all(m["level"] == "error" for m in page.got("said"))
    for text, part in zip(
        said,
        (
            'did you mean "basal"',
            "expected at most 5, the current tick",
            "expected a whole number",
            "not an intervention",
        ),
        strict=True,
    ):
        assert part in text


def test_the_second_world_stops_alone(monkeypatch):
    pair = Pair(Live(small()))
    pair.handle(asks("whatif", what=None))

    def fails():
        raise FloatingPointError("lost")

    pair.second.source.world.before_tick.append(fails)
    pair.first.world.run(1)
    pair.passed()
    assert pair.second is None
    assert [m["text"] for m in pair.news() if m["kind"] == "said"] == ["the second world stopped: lost"]


def test_lines_and_command_give_the_fork_again():
    live = Live(small())
    live.handle(asks("act", what=ACTS[3]))
    live.world.run(6)
    pair = Pair(live, start=START)
    pair.handle(asks("whatif", what=ACTS[8]))
    live.world.run(10)
    pair.second.follow(60)
    recipe = pair.second.told["recipe"]
    word = recipe["command"].split("--set ")[1].partition(" --out")[0].strip("'")
    assert recipe["command"].startswith("ecs-eco run predator-prey --seed 5 --policies random --set ")
    for text in (recipe["toml"], f"interventions = {word.removeprefix('interventions=')}"):
        planned = tomllib.loads(text)["interventions"]
        assert [one["at"] for one in planned] == [0, 6]
        again = World.from_config(
            load("predator-prey", SMALL | {"interventions": planned}), seed=5, policies="random", record=False
        )
        assert again.run(16).digest() == pair.second.source.world.digest()


def test_a_recorded_run_is_forked_at_the_tick_that_it_shows(tmp_path):
    run_to_folder(load("predator-prey", SMALL), 5, 20, tmp_path, "random", report=False)
    barren = {"kind": "set", "set": {"species.deer.reproduction.rate": 0.0}}
    pair, _ = watched(Replay(tmp_path), 19, {7: [asks("whatif", what=barren)]})
    assert (pair.second.start, pair.second.tick) == (7, 19)
    assert pair.second.told["recipe"]["command"] == (
        f"ecs-eco resume {tmp_path} --from-tick 8 --set species.deer.reproduction.rate=0.0 --out NEW"
    )
    same, seen = watched(Replay(tmp_path), 19, {7: [asks("whatif", what=None)]})
    mine, theirs = same.first.counts(), same.second.source.counts()
    assert mine == theirs
    for both in (parts(frame) for frame in seen.frames if len(parts(frame)) > 1):
        assert both[0][1] == both[1][1]
        assert both[1][0] == both[0][0] + 1  # a living world says the tick that comes next
    same.handle(asks("seek", tick=10))
    while not same.second.there:
        same.passed()
    assert same.second.tick == 10
    assert same.first.counts() == same.second.source.counts()
    (said,) = pair.handle(asks("whatif", tick=3))
    assert "expected 19, the displayed tick" in said["text"]


def test_a_run_that_is_recorded_can_be_forked_while_it_is_watched(tmp_path):
    window, pages = Window(16, lambda address: None), []

    def prepare(world):
        window.open(world)
        window.player.playing = False
        pages.append(Page(window.player))
        world.before_tick.append(
            lambda: world.tick == 6 and window.player.say(pages[0], asks("whatif", what=WITHOUT))
        )

    with window:
        manifest = run_to_folder(
            load("predator-prey", SMALL), 5, 16, tmp_path / "run", "random", prepare=prepare, report=False
        )
    assert beside(pages[0], "state")[-1]["n"]["wolf"] == 0
    alone = run_to_folder(load("predator-prey", SMALL), 5, 16, tmp_path / "alone", "random", report=False)
    assert manifest["digest"] == alone["digest"]
    assert manifest["intervened"] == []
    assert repeat(tmp_path / "run")["same"]


def test_two_worlds_are_compared(tmp_path):
    other = World.from_config(load("predator-prey", SMALL), seed=6, policies="random", record=False)
    pair, page = watched(
        Pair(Live(small()), Live(other), ("five", "six")), 12, {5: [asks("act", what=ACTS[3])]}
    )
    assert other.tick == 12
    assert pair.first.world.digest() != other.digest()
    assert [tick for tick, _ in other.intervened] == [tick for tick, _ in pair.first.world.intervened]
    assert beside(page, "names")[0] == ["five", "six"]
    assert pair.second.sentence()["state"]["text"].startswith("At tick 12: ")
    assert pair.second.mark is None


@pytest.mark.parametrize("first", ["live", "replay"])
def test_recorded_runs_are_compared_with_each_other_and_with_a_living_world(tmp_path, first):
    run_to_folder(load("predator-prey", SMALL), 5, 10, tmp_path, "random", report=False)
    source = Live(small()) if first == "live" else Replay(tmp_path)
    _, page = watched(Pair(source, Replay(tmp_path), ("a", "b")), 9)
    numbers = [(one[1], other[1]) for one, other in map(parts, page.frames[1:])]
    assert len(numbers) >= 9
    assert all(np.array_equal(one, other) for one, other in numbers)
