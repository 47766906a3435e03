"""Animals of all islands are found by a click: their uids are longer than 32 bits."""

import threading
from contextlib import contextmanager

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Position, Velocity
from ecs_eco.engine.uids import first_uid
from ecs_eco.testing.browser import until
from ecs_eco.view.live import Live
from ecs_eco.view.player import Player
from ecs_eco.view.server import Server
from tests.view.pages import IN_A_BROWSER, opened

pytestmark = IN_A_BROWSER


def herd(islands):
    """Two animals of each island, in a row from south to north."""
    world = World([10.0, 10.0], seed=1)
    table = world.add_table("animal", Position, Velocity, Biology)
    table.species.color, table.species.radius = "#d95f02", 0.3
    for at, island in enumerate(islands):
        world.next_uid = first_uid(island)
        x = np.array([3.0, 7.0], np.float32)
        table.request(
            np.zeros(2, np.uint64), {(Position, "x"): x, (Position, "y"): np.full(2, 2 + 3 * at, np.float32)}
        )
        world.flush()
    return world


@contextmanager
def shown(make):
    """The address of a world that stands still in a thread of its own."""
    ready, box = threading.Event(), []

    def live():
        source = Live(make())
        player = Player(source, playing=False)
        with Server(player) as server:
            box.extend([player, server.address()])
            ready.set()
            source.run(player.turn)

    thread = threading.Thread(target=live)
    thread.start()
    try:
        assert ready.wait(120)
        yield box[1]
    finally:
        if box:
            box[0].close()
        thread.join(60)


@pytest.mark.parametrize("island", [0, 1, 31])
def test_who_was_born_on_any_island_is_selected_by_a_click(browser, island):
    with shown(lambda: herd([0, 1, 31])) as address, opened(browser, address) as page:
        until(page, "ecs.still && ecs.counts.animal === 6")
        uid = first_uid(island) + 1
        at = page.evaluate(f"ecs.screen({uid})")
        page.mouse.click(at["x"], at["y"])
        until(page, "ecs.selected !== null && document.querySelector('#organism .who')")
        assert page.evaluate("ecs.selected") == uid
        assert f"#{uid}" in page.locator("#organism .who").inner_text()
