"""The log of what pages do: the same on all of them, with numbers, refusals and what is taken back."""

import json

from ecs_eco.view.live import Live
from ecs_eco.view.pair import Pair
from ecs_eco.view.player import Player
from ecs_eco.view.shown import KEPT, LONGEST, Log, View
from ecs_eco.view.source import said
from tests.view.parks import small

BASAL = {"kind": "set", "set": {"species.deer.metabolism.basal": 0.01}}


class Page:
    """Keeps the texts that it is sent."""

    def __init__(self, player):
        self.sent, self.player = [], player
        player.say(self, {"kind": "join"})

    def send(self, messages):
        self.sent += [json.loads(message) for message in messages if isinstance(message, str)]

    def act(self, what, **more):
        self.player.say(self, {"kind": "act", "what": what} | more)
        self.player.poll()

    @property
    def logged(self):
        return [entry for message in self.sent if message["kind"] == "log" for entry in message["entries"]]


def watched():
    player = Player(Pair(Live(small())), playing=False)
    return player, Page(player), Page(player)


def test_what_one_page_does_is_in_the_log_of_all_also_of_one_that_comes_later():
    player, one, two = watched()
    one.act(BASAL)
    two.act(BASAL | {"set": {"species.deer.metabolism.basal": 0.004}}, **{"as": "undo"})
    wanted = [
        {
            "tick": 0,
            "level": "info",
            "text": "species.deer.metabolism.basal = 0.01",
            "page": 1,
            "asked": "act",
            "what": "species.deer.metabolism.basal = 0.01",
        },
        {
            "tick": 0,
            "level": "info",
            "text": "species.deer.metabolism.basal = 0.004",
            "page": 2,
            "asked": "act",
            "what": "species.deer.metabolism.basal = 0.004",
            "as": "undo",
        },
    ]
    late = Page(player)
    player.poll()
    assert one.logged == two.logged == late.logged == wanted
    firsts = [next(m for m in page.sent if m["kind"] == "log") for page in (one, two, late)]
    assert [message["page"] for message in firsts] == [1, 2, 3]


def test_refusals_are_marked_and_name_what_was_asked_for():
    _, one, two = watched()
    one.act({"kind": "cull", "species": "dear", "share": 0.5})
    one.act("nonsense", **{"as": "burn"})
    cull, nonsense = two.logged
    assert (cull["level"], cull["page"], cull["what"]) == ("error", 1, "cull 50% of dear")
    assert 'did you mean "deer"?' in cull["text"]
    assert (nonsense["level"], nonsense["what"]) == ("error", "")
    assert "as" not in nonsense
    one.player.say(one, {"kind": "seek", "tick": "noon"})
    one.player.say(one, {"kind": "speed", "value": -1})  # of time alone: answered, and not noted
    one.player.poll()
    assert [(entry["asked"], entry["level"]) for entry in two.logged[2:]] == [("seek", "error")]
    assert [m["level"] for m in one.sent if m.get("field") == "speed"] == ["error"]


def test_what_all_pages_are_told_is_noted_of_nobody():
    player, one, _ = watched()
    player.poll()
    player.tell("error", "the world stopped: it was late")
    assert [(entry["page"], entry["text"]) for entry in one.logged] == [
        (None, "the world stopped: it was late")
    ]


def test_the_log_is_bounded_and_its_entries_short():
    view = View()
    log = Log({}, True)
    log.came(view)
    for i in range(KEPT + 5):
        log.answered(i, view, {"kind": "act", "what": None}, [said("error", "no " * LONGEST)])
    assert len(log.entries) == KEPT
    assert log.entries[0]["tick"] == 5
    assert len(log.entries[0]["text"]) == LONGEST


def test_a_recorded_run_has_no_log():
    view = View()
    log = Log({}, False)
    assert log.came(view) == []
    log.answered(1, view, {"kind": "seek"}, [said("error", "no")])
    assert not log.entries
    assert view.number == 1
