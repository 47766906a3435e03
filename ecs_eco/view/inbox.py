"""What pages ask, from the server's thread to the one that answers."""

from __future__ import annotations

import threading
from collections import deque

from ecs_eco.view.shown import Page
from ecs_eco.view.source import Message


class Inbox:
    """Messages of pages that wait for an answer; `say` and `close` may be called from any thread."""

    def __init__(self) -> None:
        self.inbox: deque[tuple[Page, Message]] = deque()
        self.closing = False
        self._wake = threading.Event()

    def say(self, page: Page, request: Message) -> None:
        """Deliver a page's message: {"kind": …}; "join" and "leave" mark its presence."""
        self.inbox.append((page, request))
        self._wake.set()

    def close(self) -> None:
        """End what serves the pages."""
        self.closing = True
        self._wake.set()
