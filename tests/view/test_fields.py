"""Maps of fields that a page lays over its scene."""

import base64
import json

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.view import scene
from ecs_eco.view.live import Live
from ecs_eco.view.player import Player
from ecs_eco.view.scene import SIDE, map_of, names_of
from tests.view.parks import small


class Notes:
    """A page that notes the messages that it gets, and acknowledges frames."""

    def __init__(self, player):
        self.player, self.texts = player, []
        player.say(self, {"kind": "join"})

    def send(self, messages):
        for message in messages:
            if isinstance(message, bytes):
                number = int.from_bytes(message[4:8], "little")
                self.player.say(self, {"kind": "ack", "frame": number})
            else:
                self.texts.append(json.loads(message))

    def say(self, kind, **more):
        self.player.say(self, {"kind": kind, **more})

    def got(self, kind):
        return [t for t in self.texts if t["kind"] == kind]


def values(message):
    return np.frombuffer(base64.b64decode(message["values"]), np.uint8).reshape(message["ny"], message["nx"])


def test_a_smell_on_land_is_a_map_from_the_south_west():
    world = small()
    field = world.fields["wolf_smell"]
    field.value[:] = 0
    field.value[0, 3, 7] = 2.0
    message = map_of(world, "wolf_smell")
    assert (message["nx"], message["ny"]) == field.shape[:2]
    assert (message["low"], message["high"]) == (0.0, 2.0)
    assert np.argwhere(values(message) > 0).tolist() == [[3, 7]]
    assert values(message)[3, 7] == 255


def test_an_empty_field_and_a_large_one_are_sent_too():
    world = small()
    world.fields["wolf_smell"].value[:] = 0
    assert map_of(world, "wolf_smell")["high"] == 0.0
    assert not values(map_of(world, "wolf_smell")).any()
    world.fields["wolf_smell"].value = np.ones((1, 3 * SIDE, 2 * SIDE), np.float32)
    message = map_of(world, "wolf_smell")
    assert max(message["nx"], message["ny"]) <= SIDE


def test_light_in_water_is_a_column_of_depths_that_darkens_downwards():
    world = World.from_config(load("diel-migration"), seed=1, policies="random", record=False)
    assert names_of(world) == ["light", "krill_smell"]
    world.tick = 75  # noon is a quarter of the day after sunrise
    light = values(map_of(world, "light"))
    assert light.shape[1] == 1
    assert (np.diff(light[:, 0].astype(int)) >= 0).all()
    assert light[-1, 0] == 255
    assert light[0, 0] < 10
    assert map_of(world, "krill_smell")["ny"] == world.fields["krill_smell"].shape[2]


def test_what_is_no_field_is_refused_and_names_the_nearest():
    player = Player(Live(small()), playing=False)
    page = Notes(player)
    page.say("field", name="wolf_smel")
    page.say("field", name="wolf_smell")
    player.poll()
    player.poll()
    (refused,) = page.got("said")
    assert "did you mean 'wolf_smell'" in refused["text"]
    with pytest.raises(KeyError):
        map_of(small(), "wolf_smel")


def test_a_page_gets_the_field_that_it_asked_for_and_then_no_more():
    player = Player(Live(small()), playing=False)
    page = Notes(player)
    for _ in range(3):
        player.poll()
    assert page.got("field") == []
    page.say("field", name="deer_smell")
    for _ in range(5):
        player._looks = (0.0, 0.0)
        player.poll()
    assert [m["name"] for m in page.got("field")] == ["deer_smell"]  # nothing changes: one is enough


def test_land_cover_follows_water_rock_and_the_names_of_classes():
    kinds, wet = np.array([[1, 2, 3], [1, 0, 3]]), np.array([[False] * 3, [False, False, True]])
    ground = np.array([[0, 0, 0], [1, 2, 0]])
    cover = scene._cover(ground, kinds, wet, ["Mixed Forest", "cropland", "heath"])
    assert cover.tolist() == [[1, 2, 0], [4, 3, 4]]
