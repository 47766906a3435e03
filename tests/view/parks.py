"""A small park that is watched, a page that looks at all of it, and what pages ask for."""

import json
import struct

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.view.live import Live
from ecs_eco.view.player import Player

SMALL = {"species.grass.count": 300, "species.deer.count": 60, "species.wolf.count": 12}
ACTS = {  # by the tick before which they are asked for
    3: {"kind": "cull", "species": "deer", "share": 0.5},
    5: {"kind": "add", "species": "wolf", "count": 4, "at_place": [60, 60]},
    8: {"kind": "set", "set": {"species.deer.metabolism.basal": 0.01}},
    9: {"kind": "fence", "region": [20, 20, 100, 100]},
    12: {"kind": "switch", "species": "deer", "reproduction": False},
}


def small(policies="random", **options):
    return World.from_config(load("predator-prey", SMALL), seed=5, policies=policies, record=False, **options)


class Page:
    """Reads all it gets; looks at everything: colours, panels,
    acts. Asks for one step at each tick that it sees."""

    def __init__(self, player, acts=None):
        self.player, self.acts, self.frames, self.messages, self.ticks = player, dict(acts or {}), [], [], []
        player.say(self, {"kind": "join"})
        player.say(self, {"kind": "params"})

    def send(self, messages):
        for message in messages:
            if isinstance(message, bytes):
                self.frames.append(message)
                number, tick = struct.unpack_from("<II", message, 4)
                self.player.say(self, {"kind": "ack", "frame": number})
                self.player.say(
                    self, {"kind": "colour", "by": ("species", "energy", "happiness", "age")[number % 4]}
                )
                self.player.say(self, {"kind": "select", "uid": 310})
                if tick in self.acts:
                    self.player.say(self, {"kind": "act", "what": self.acts.pop(tick)})
                if tick not in self.ticks:  # where time is short, a tick is seen in its new colour too
                    self.ticks.append(tick)
                    self.player.say(self, {"kind": "step"})
            else:
                self.messages.append(json.loads(message))

    def got(self, kind):
        return [m for m in self.messages if m["kind"] == kind]


def watched(world, ticks, acts=None):
    """Let a world live in front of a page that steps through it, acting on its way."""
    player = Player(Live(world, ticks), playing=False)
    page = Page(player, acts)
    player.halted = lambda: (
        world.tick >= ticks and bool(page.frames) and struct.unpack_from("<I", page.frames[-1], 8)[0] == ticks
    )
    player.source.run(player.turn)
    return page
