"""Malicious messages from a page to the viewer's player, which passes them to a live world or to a
recording."""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Iterator
from functools import cache
from typing import Any

from studies.common.malicious.ground import Attack, Ground
from studies.common.malicious.templates import KEYS, NAMES, renamed
from studies.common.malicious.worlds import mutate, payloads

MESSAGES: list[dict[str, Any]] = [
    {"kind": "act", "what": {"kind": "set", "set": {"species.snail.metabolism.basal": 0.01}}},
    {"kind": "act", "what": {"kind": "add", "species": "snail", "count": 1, "genome": {"g": 0.5}}},
    {
        "kind": "act",
        "what": {
            "kind": "cull",
            "species": "snail",
            "count": 1,
            "which": "oldest",
            "region": [1.0, 1.0, 2.0],
        },
    },
    {"kind": "act", "what": {"kind": "switch", "species": "snail", "reproduction": False}},
    {"kind": "params"},
    {"kind": "select", "uid": 1},
    {"kind": "colour", "by": "energy"},
    {"kind": "speed", "value": 10.0},
    {"kind": "step", "ticks": 1},
    {"kind": "seek", "tick": 2},
    {"kind": "fill", "uid": 1},
    {"kind": "ack", "frame": 1},
]


class Page:
    """A page that stores the messages it receives."""

    def __init__(self, player: Any) -> None:
        self.received: list[dict[str, Any]] = []
        self.player = player
        player.say(self, {"kind": "join"})

    def send(self, messages: list[str | bytes]) -> None:
        """Store a message from the player."""
        self.received += [json.loads(m) for m in messages if isinstance(m, str)]

    def ask(self, message: dict[str, Any]) -> str:
        """Send a message, run one tick, and return the resulting errors."""
        self.received.clear()
        self.player.say(self, message)
        self.player.playing = False
        while self.player.inbox:
            self.player._answer(*self.player.inbox.popleft())
        self.player._serve(1e12)
        return "\n".join(
            f"{m.get('field')}: {m['text']}"
            for m in self.received
            if m["kind"] == "said" and m["level"] == "error"
        )


def by_hand(ground: Ground) -> Iterator[Attack]:
    """Return interventions that name code at every key, or have invalid kinds, colors or targets."""
    for i, pattern in enumerate(KEYS):
        key = pattern.replace("*", "snail", 1).removesuffix(".*")
        for k, name in enumerate(("evil:feel", "os:system", NAMES[i % len(NAMES)])):
            value = renamed(pattern, name, ground.shell)
            whole = key.rpartition(".")[0] if isinstance(value, dict) else key
            yield attack(
                ground, {"kind": "act", "what": {"kind": "set", "set": {whole: value} if k else {key: name}}}
            )
    for text in ("evil:Wait", "os:system", *ground.texts):
        yield attack(ground, {"kind": text})
        yield attack(ground, {"kind": "colour", "by": f"gene:{text}"})
        yield attack(ground, {"kind": "act", "what": {"kind": text, "species": text}})


def by_mutation(ground: Ground, seed: int, number: int) -> Iterator[Attack]:
    """Return messages that contain a payload."""
    for i in range(number):
        chance = random.Random(seed * 1_000_000 + i)
        message = copy.deepcopy(chance.choice(MESSAGES))
        mutate(
            message,
            chance,
            payloads(ground),
            ["function", "operator", "code", "set", "kind", "what", "species"],
        )
        yield attack(ground, message)


def attack(ground: Ground, message: dict[str, Any]) -> Attack:
    """Return an attack that sends a message to the player of a live world, then to the player of a
    recording."""
    kind = str(message.get("kind"))[:40]
    live, recorded = _players(ground)
    return Attack(
        json.dumps(message)[:150],
        [
            "set.",
            "kind",
            "act",
            "species",
            kind,
            "what",
            "unknown request",
            "search",
            "which",
            "intervention",
        ],
        [("a living world", lambda: live.ask(message)), ("a recording", lambda: recorded.ask(message))],
    )


@cache
def _players(ground: Ground) -> tuple[Page, Page]:
    from ecs_eco import World
    from ecs_eco.view.live import Live
    from ecs_eco.view.player import Player
    from ecs_eco.view.replay import Replay

    world = World.from_config(ground.garden, record=False).run(1)
    pages = Page(Player(Live(world, 100), playing=False)), Page(Player(Replay(ground.run), playing=False))
    for page in pages:
        page.ask({"kind": "params"})
    return pages
