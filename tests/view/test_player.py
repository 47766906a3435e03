"""The player, with a source of numbers and pages that note what they get."""

import json
from types import SimpleNamespace

import pytest

from ecs_eco.view import player as module

TICK = 0.0005  # [s] that a tick takes


class Clock:
    """Time that passes only where somebody waits or works: tests need none of the machine's."""

    def __init__(self):
        self.now = 100.0

    def wait(self, seconds):
        self.now += seconds + 1e-6


CLOCK = Clock()


class Player(module.Player):
    """A player that lives by that clock."""

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        self._wake = SimpleNamespace(set=lambda: None, clear=lambda: None, wait=CLOCK.wait)


@pytest.fixture(autouse=True)
def _clock(monkeypatch):
    monkeypatch.setattr(
        module, "time", SimpleNamespace(monotonic=lambda: CLOCK.now, perf_counter=lambda: CLOCK.now)
    )


class Numbers:
    """A source whose frames are (number, tick, colour)."""

    def __init__(self, last=None):
        self.tick, self.last, self.made, self.asked, self.ranges = 0, last, 0, [], {}
        self.died = ()

    @property
    def done(self):
        return self.last is not None and self.tick >= self.last

    def hello(self):
        return {"kind": "hello", "colours": ["species", "age"]}

    def greeting(self):
        return [{"kind": "marks"}]

    def news(self):
        return []

    def passed(self):
        pass

    def counts(self):
        return {"deer": self.tick}

    def scales(self, colour):
        return self.ranges.get(colour, {})

    def frame(self, number, colour):
        self.made += 1
        self.ranges[colour] = {"deer": (0.0, 9.0)}  # known once somebody has looked
        return json.dumps([number, self.tick, colour]).encode()

    def fates(self, after):
        return [
            (tick, 0, tick, 1.0, 2.0, 0.0, 0) for tick in range(max(0, after), self.tick) if tick in self.died
        ]

    def field(self, name):
        return {"kind": "field", "name": name, "tick": self.tick}

    def sample(self):
        pass

    def series(self, after):
        return None if after >= self.tick else {"kind": "series", "tick": [self.tick]}

    def organism(self, uid):
        if uid > 100:
            raise KeyError(uid)
        return {"kind": "organism", "uid": uid, "tick": self.tick}

    def handle(self, request):
        if request["kind"] == "act":
            raise RuntimeError("a bug")
        return [{"kind": "said", "level": "info", "text": request["kind"]}]


class Notes:
    """A page that notes what it gets, and acknowledges where it is told to."""

    def __init__(self, player, reads=True):
        self.player, self.reads, self.frames, self.texts = player, reads, [], []
        player.say(self, {"kind": "join"})

    def send(self, messages):
        for message in messages:
            if isinstance(message, bytes):
                self.frames.append(json.loads(message))
                if self.reads:
                    self.player.say(self, {"kind": "ack", "frame": self.frames[-1][0]})
            else:
                self.texts.append(json.loads(message))

    def say(self, kind, **more):
        self.player.say(self, {"kind": kind, **more})

    def got(self, kind):
        return [t for t in self.texts if t["kind"] == kind]


def play(player, seconds, most=10**9):
    """Let it play for a while; return how many ticks passed."""
    ticks, source = 0, player.source
    end = CLOCK.now + seconds
    player.halted = lambda: CLOCK.now > end
    while ticks < most and player.turn():
        CLOCK.now += TICK
        if not source.done:
            source.tick += 1
            ticks += 1
    return ticks


def test_a_page_is_greeted_then_told_and_shown():
    player = Player(Numbers(), playing=False)
    page = Notes(player)
    play(player, 0.1)
    assert [t["kind"] for t in page.texts[:4]] == ["hello", "marks", "series", "state"]
    assert page.frames == [[1, 0, "species"]]  # one, for nothing changes


def test_frames_are_made_no_faster_than_pages_can_see():
    source = Numbers()
    player = Player(source, speed=None)
    page = Notes(player)
    ticks = play(player, 0.5)
    assert 990 <= ticks <= 1000
    assert len(page.frames) == 3  # one every 0.2 s, and the first
    assert page.frames[-1][1] > ticks / 2


def test_a_page_that_acknowledges_nothing_gets_one_frame_and_delays_nobody():
    source = Numbers()
    player = Player(source, speed=None)
    stalled, page = Notes(player, reads=False), Notes(player)
    ticks = play(player, 0.5)
    assert ticks >= 990
    assert len(stalled.frames) == 1
    assert len(page.frames) == 3
    assert len(stalled.texts) < 8
    stalled.say("ack", frame=999)  # not the one that it got
    play(player, 0.1)
    assert len(stalled.frames) == 1
    stalled.say("ack", frame=stalled.frames[0][0])
    play(player, 0.1)
    assert len(stalled.frames) == 2
    assert stalled.frames[1][1] > 1000  # what is now, not what was when it stalled


def test_pages_share_frames_of_one_colour():
    source = Numbers()
    player = Player(source, playing=False)
    pages = [Notes(player) for _ in range(3)]
    pages[2].say("colour", by="age")
    play(player, 0.15)
    assert [p.frames[-1][2] for p in pages] == ["species", "species", "age"]
    assert source.made <= 3  # of both colours, and perhaps the third page's first look


@pytest.mark.parametrize("playing", [False, True])
def test_what_another_colour_means_is_told_with_its_first_frame(playing):
    player = Player(Numbers(), speed=1.0, playing=playing)
    page = Notes(player, reads=False)
    play(player, 0.1)
    page.say("colour", by="age")
    play(player, 0.1)
    # the frame of before is not acknowledged, so that there is none of this colour
    assert page.got("state")[-1]["scales"] == {}
    page.say("ack", frame=1)
    play(player, 0.1)
    assert [frame[2] for frame in page.frames] == ["species", "age"]
    assert page.got("state")[-1]["scales"] == {"deer": [0.0, 9.0]}


def test_the_speed_is_kept():
    player = Player(Numbers(), speed=100.0)
    assert play(player, 0.5) in (50, 51)


def test_pages_pause_step_and_play():
    source = Numbers()
    player = Player(source, speed=None)
    page = Notes(player)
    page.say("pause")
    assert play(player, 0.1) == 0
    page.say("step", ticks=3)
    assert play(player, 0.2) == 3
    assert page.frames[-1][1] == 3
    assert page.got("state")[-1]["playing"] is False
    page.say("step")
    assert play(player, 0.1) == 1
    page.say("speed", value=50)
    page.say("play")
    assert play(player, 0.2) in (10, 11)
    assert page.got("state")[-1]["speed"] == 50


def test_nothing_plays_beyond_the_end():
    source = Numbers(last=5)
    player = Player(source, speed=None)
    page = Notes(player)
    assert play(player, 0.15) == 5
    assert page.got("state")[-1]["done"] is True
    assert page.frames[-1][1] == 5
    page.say("step")
    assert play(player, 0.05) == 0


def test_who_is_selected_is_shown_with_every_frame_and_once_while_nothing_moves():
    source = Numbers()
    player = Player(source, playing=False)
    page = Notes(player)
    page.say("select", uid=7)
    play(player, 0.3)
    assert [m["tick"] for m in page.got("organism")] == [0]
    page.say("step")
    play(player, 0.3)
    assert [m["tick"] for m in page.got("organism")] == [0, 1]
    page.say("select", uid=None)
    page.say("step")
    play(player, 0.2)
    assert len(page.got("organism")) == 2
    page.say("select", uid=101)
    play(player, 0.1)
    assert "101" in page.got("said")[-1]["text"]


def test_each_point_of_the_series_is_sent_once():
    source = Numbers()
    player = Player(source, playing=False)
    page = Notes(player)
    page.say("step", ticks=2)
    play(player, 0.3)
    page.say("step", ticks=1)
    play(player, 0.3)
    ticks = [t for m in page.got("series") for t in m["tick"]]
    assert ticks == sorted(set(ticks))
    assert ticks[-1] == 3


@pytest.mark.parametrize(
    "request_",
    [
        {"kind": "speed", "value": -1},
        {"kind": "speed", "value": "x"},
        {"kind": "speed", "value": True},
        {"kind": "speed", "value": float("nan")},
        {"kind": "step", "ticks": 0},
        {"kind": "step", "ticks": 10**9},
        {"kind": "step", "ticks": 1.5},
        {"kind": "colour", "by": "aeg"},
        {"kind": "select", "uid": "7"},
        {"kind": "select", "uid": -1},
        {"kind": "paly"},
        {"kind": ["play"]},
        {},
        {"kind": None},
        {"kind": "act"},
    ],
)
def test_what_cannot_be_is_refused_in_words_and_the_run_goes_on(request_):
    player = Player(Numbers(), speed=None)
    page = Notes(player)
    player.say(page, request_)
    assert play(player, 0.05) > 10
    (refusal,) = page.got("said")
    assert refusal["level"] == "error"
    assert len(refusal["text"]) > 10


def test_a_page_that_left_is_forgotten():
    player = Player(Numbers(), speed=None)
    page = Notes(player, reads=False)
    play(player, 0.05)
    page.say("leave")
    page.say("pause")
    assert play(player, 0.05) > 10
    assert not player._views


def test_a_closed_player_ends_the_world():
    player = Player(Numbers(), playing=False)
    player.close()
    assert player.turn() is False


def test_at_the_end_nothing_plays_any_more():
    player = Player(Numbers(last=3), speed=None)
    page = Notes(player)
    play(player, 0.15)
    assert page.got("state")[-1]["playing"] is False


def test_a_world_that_runs_as_fast_as_it_can_is_asked_for_fewer_frames_than_one_at_a_pace():
    def frames(speed):
        source = Numbers()
        player = Player(source, speed)
        page = Notes(player)
        play(player, 4.0)
        return len(page.frames)

    assert frames(200.0) >= 70
    assert 16 <= frames(None) <= 17


def test_an_acknowledgement_is_no_reason_to_look_at_the_world_before_the_next_frame_is_due():
    source, looks = Numbers(), []
    source.news = lambda: looks.append(source.tick) or []
    player = Player(source, None)
    page = Notes(player)
    play(player, 4.0)
    assert len(looks) <= len(page.frames) + 4.0 / 0.1 + 4.0 / module.PATIENCE + 3
