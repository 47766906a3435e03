"""Beginning anew: another world, or the same with another seed, on the same server, for the same pages."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ecs_eco.config.shipped import titles
from ecs_eco.engine.errors import listed, nearest
from ecs_eco.view.messages import short
from ecs_eco.view.source import Message

SEEDS = 2**53  # from here on numbers of a page are not exact


class Picker:
    """Which worlds a page may begin: those that come with the package, and the one that is shown.

    `build(world, seed)` makes the source of one, with its own seed where that is None, a `Pair`; it may raise
    whatever building a world raises.
    """

    def __init__(self, world: str, title: str, build: Callable[[str, int | None], Any]) -> None:
        name = world.replace("_", "-")
        known = titles()
        self.world = self.first = name if name in known else world
        self.titles = known if self.world in known else {world: title, **known}
        self.build = build
        self.wanted: tuple[str, int | None] | None = None  # what is to be begun, as soon as the tick is over
        self.begun = 0  # how often this server has begun anew

    def offered(self) -> Message:
        """Return what a page needs to choose."""
        worlds = [{"name": name, "title": title} for name, title in self.titles.items()]
        return {"worlds": worlds, "world": self.world, "begun": self.begun}

    def ask(self, request: Message) -> Message:
        """Note what is to be begun: {"world", "seed"}; ValueError if it is none of those offered."""
        world, seed = request.get("world", self.world), request.get("seed")
        if not isinstance(world, str) or world not in self.titles:
            raise ValueError(
                f"begin: world = {short(world)}; allowed: {listed(self.titles)}; "
                f"did you mean {nearest(str(world), list(self.titles))!r}?"
            )
        whole = isinstance(seed, int) and not isinstance(seed, bool)
        if seed is not None and not (whole and 0 <= seed < SEEDS):
            raise ValueError(
                f"begin: seed = {short(seed)}; allowed: a whole number from 0 to {SEEDS - 1}, "
                "or null for that of the world"
            )
        self.wanted = world, seed
        words = f"beginning {self.titles[world] or world} …"
        return {"kind": "said", "level": "info", "field": "begin", "text": words}

    def begin(self) -> Any:
        """Return the source of what is wanted, or a text: why it cannot be begun."""
        assert self.wanted is not None
        (world, seed), self.wanted = self.wanted, None
        try:
            made = self.build(world, seed)
        except Exception as error:  # whatever is wrong with it, the one that is shown goes on
            return f"{world} cannot be begun: {error}"
        self.world, self.begun, made.picker = world, self.begun + 1, self
        return made


def reason(first: Any, second: Any) -> str:
    """Return why what is shown cannot be begun anew."""
    from ecs_eco.view.live import Live

    if second is not None:
        return "Two worlds are shown beside each other."
    if not isinstance(first, Live):
        return "A recorded run is shown as it is."
    return "The program that runs this world, and may record it, decides what it begins."
