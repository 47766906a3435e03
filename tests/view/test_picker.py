"""Beginning anew on the same server: what may be chosen, what is refused, and that pages come along."""

import json

import pytest

from ecs_eco.cli.watch import Options
from ecs_eco.view.live import Live
from ecs_eco.view.pair import Pair, Picker
from ecs_eco.view.watch import _begun, served
from tests.view.parks import small

CHANGES = ["species.grass.count=300", "species.deer.count=60", "species.wolf.count=12"]
OPTIONS = Options(CHANGES, None, 1, None, "random")


def begun():
    live = OPTIONS.live("predator-prey", 5)
    return Pair(live, picker=OPTIONS.picker(live, "predator-prey"))


class Page:
    """Keeps the texts that it is sent."""

    def __init__(self):
        self.sent = []

    def send(self, messages):
        self.sent += [json.loads(message) for message in messages if isinstance(message, str)]

    def last(self, kind):
        return [message for message in self.sent if message["kind"] == kind][-1]


def asked(player, page, **what):
    player.say(page, {"kind": "begin", **what})
    player.poll()


def test_shipped_worlds_are_offered_with_their_titles_and_a_file_before_them():
    offered = begun().hello()["begins"]
    assert offered["world"] == "predator-prey"
    assert {"name": "island", "title": "An island: grass, deer, wolves and ravens"} in offered["worlds"]
    own = Picker("my/world.toml", "Mine", lambda world, seed: None).offered()
    assert own["worlds"][0] == {"name": "my/world.toml", "title": "Mine"}
    assert len(own["worlds"]) == len(offered["worlds"]) + 1
    assert Picker("predator_prey", "", lambda world, seed: None).offered()["world"] == "predator-prey"


def test_another_seed_is_another_world_at_tick_0_for_the_same_page():
    player, page = served(begun(), playing=False), Page()
    player.say(page, {"kind": "join"})
    asked(player, page, world="predator-prey", seed=7)
    assert player.halted()
    other = _begun(player)
    assert other is not player
    assert (other.source.first.world.seed, other.source.tick) == (7, 0)
    assert other.source.counts() == {"grass": 300, "deer": 60, "wolf": 12}  # --set is for this world
    hello = other.source.hello()
    assert (hello["begins"]["begun"], hello["seed"]) == (1, 7)
    assert not other.halted()
    assert _begun(other) is None


def test_another_world_has_its_own_values_and_its_own_seed():
    player = served(begun(), playing=False)
    player.source.picker.wanted = "reflexes", None
    other = _begun(player)
    assert other.source.hello()["world"] == "reflexes"
    assert other.source.hello()["begins"]["world"] == "reflexes"
    assert other.source.begun.words[:2] == ["run", "reflexes"]
    assert "--set" not in other.source.begun.words


@pytest.mark.parametrize(
    ("what", "words"),
    [
        ({"world": "iland"}, "did you mean 'island'?"),
        ({"world": "/etc/passwd"}, "expected"),
        ({"world": ["island"]}, "expected"),
        ({"seed": -1}, "a whole number from 0"),
        ({"seed": True}, "a whole number from 0"),
        ({"seed": 1.5}, "a whole number from 0"),
    ],
)
def test_what_is_not_offered_is_refused(what, words):
    player, page = served(begun(), playing=False), Page()
    player.say(page, {"kind": "join"})
    asked(player, page, **what)
    assert page.last("said")["level"] == "error"
    assert words in page.last("said")["text"]
    assert not player.halted()


def test_where_it_cannot_be_begun_the_world_goes_on_and_says_why():
    source = begun()

    def build(world, seed):
        raise ValueError("its file is gone")

    source.picker.build = build
    player, page, world = served(source, None), Page(), source.first.world
    player.say(page, {"kind": "join"})
    wishes = {3: lambda: player.say(page, {"kind": "begin", "world": "island"}), 6: player.close}

    def wish():
        if wish := wishes.pop(world.tick, None):
            wish()

    world.before_tick.append(wish)
    source.run(player.turn)
    assert world.tick == 3
    assert _begun(player) is player
    assert page.last("said")["text"] == "island cannot be started: its file is gone"
    source.run(player.turn)
    assert world.tick == 6


def test_a_world_of_another_program_says_why_it_cannot_be_begun_anew():
    player, page = served(Live(small()), playing=False), Page()
    player.say(page, {"kind": "join"})
    player.poll()
    why = page.last("hello")["begins"]["why"]
    assert "program that runs this world" in why
    asked(player, page, world="island")
    assert why in page.last("said")["text"]
    second = Pair(Live(small()), Live(small()), ("a", "b"))
    assert "side by side" in second.hello()["begins"]["why"]
