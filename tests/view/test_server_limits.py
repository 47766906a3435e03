"""What the viewer's server allows: connections without the credential, and pages that ask without end."""

import os
import socket
import time
from collections import deque
from contextlib import ExitStack, suppress
from types import SimpleNamespace

import pytest

from ecs_eco import World
from ecs_eco.view import server as module
from ecs_eco.view.live import Live
from ecs_eco.view.player import Player
from ecs_eco.view.server import ASKED, STRANGERS, Server
from tests.view.test_server import get, page, receive, until


def connected(server, number):
    """Connections to a server that say nothing."""
    crowd, address = ExitStack(), ("127.0.0.1", server.port)
    return crowd, [crowd.enter_context(socket.create_connection(address)) for _ in range(number)]


@pytest.mark.slow
def test_connections_without_the_credential_take_few_handles_and_no_page_loses_its_own(served):
    handles = len(os.listdir("/proc/self/fd"))
    with page(served.server) as ws:
        receive(ws, "frame")
        crowd, idle = connected(served.server, 400)
        with crowd:
            until(lambda: len(os.listdir("/proc/self/fd")) - handles - len(idle) < STRANGERS + 10)
            assert get(served.server, "/")[0] == 200
            with page(served.server) as other:
                receive(other, "frame")
            receive(ws, "frame")
            idle[0].settimeout(10)
            with suppress(ConnectionResetError):
                assert idle[0].recv(1) == b""  # the oldest was ended


def test_a_connection_that_asks_for_nothing_is_ended(served, monkeypatch):
    monkeypatch.setattr(module, "PATIENCE", 0.2)
    crowd, (silent, slow) = connected(served.server, 2)
    with crowd:
        slow.sendall(b"GET / HTTP/1.1\r\nHost: ")
        for one in (silent, slow):
            one.settimeout(10)
            with suppress(ConnectionResetError):
                assert one.recv(1) == b""


@pytest.mark.slow
def test_a_page_that_asks_without_end_waits_for_itself_alone():
    asked = SimpleNamespace(inbox=deque())
    asked.say = lambda page, request: asked.inbox.append((page, request))
    with Server(asked) as server, page(server) as greedy, page(server) as other:
        for _ in range(500):
            greedy.send('{"kind": "params"}')
        until(lambda: len(asked.inbox) == ASKED + 1)  # the first is that it came, the last that the other did
        other.send('{"kind": "table"}')
        until(lambda: asked.inbox[-1][1]["kind"] == "table")
        time.sleep(0.1)
        assert len(asked.inbox) == ASKED + 2


def test_a_tick_is_not_put_off_by_requests_that_arrive_while_others_are_answered():
    player, one = Player(Live(World([10.0, 10.0])), speed=None), SimpleNamespace(send=lambda messages: None)
    answered = []
    player._answer = lambda page, request: (answered.append(request), player.say(page, request))
    player.say(one, {"kind": "params"})
    assert player.poll() == (True, 0.0)
    assert len(answered) == 1
