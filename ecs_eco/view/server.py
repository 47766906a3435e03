"""The viewer's server, in a separate thread: it serves the page's files and a WebSocket for each page."""

from __future__ import annotations

import asyncio
import json
import mimetypes
import re
import socket
import threading
from collections.abc import Callable

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.http.h11_impl import H11Protocol

from ecs_eco.view.guard import MINUTES, SUBPROTOCOL, Credentials, Guard
from ecs_eco.view.modules import STATIC, modules
from ecs_eco.view.shown import Inbox

HOST = "127.0.0.1"
PAGES = 32  # maximum number of pages open at the same time
STRANGERS = 64  # maximum number of connections without the credential; opening another closes the oldest
BACKLOG = 32  # maximum number of connections waiting to be accepted
PATIENCE = 10.0  # [s] time limit for the header of a first request
UNREAD = 1 << 18  # [bytes] buffered by the operating system for a page that does not read
WAITING = 64  # maximum number of pending messages for a page; beyond that, it is disconnected
ASKED = 16  # maximum number of pending requests from a page
LARGEST = 1 << 18  # [bytes] maximum size of a message from a page
SCRIPT = re.compile(r'<script type="module" src="(\w+\.js)">')
TYPES = {
    ".js": "text/javascript",
    ".css": "text/css",
    ".svg": "image/svg+xml",
    ".woff2": "font/woff2",
    ".html": "text/html",
}


class Client:
    """One page and its outgoing messages. Only `send` may be called from the world's thread."""

    def __init__(self, socket: WebSocket) -> None:
        self.socket, self.loop = socket, asyncio.get_running_loop()
        self._waiting: asyncio.Queue[str | bytes] = asyncio.Queue()
        self.behind = asyncio.Event()

    def send(self, messages: list[str | bytes]) -> None:
        """Queue messages and return immediately."""
        if not self.loop.is_closed():
            self.loop.call_soon_threadsafe(self._take, messages)

    def _take(self, messages: list[str | bytes]) -> None:
        if self._waiting.qsize() + len(messages) > WAITING:
            self.behind.set()
            return
        for message in messages:
            self._waiting.put_nowait(message)

    async def pour(self) -> None:
        """Send queued messages as fast as the page reads them."""
        while True:
            message = await self._waiting.get()
            if isinstance(message, str):
                await self.socket.send_text(message)
            else:
                await self.socket.send_bytes(message)


class Strangers(dict[object, asyncio.Transport]):
    """Connections without the credential, by address, oldest first, limited in number to protect file handles."""

    def add(self, address: object, transport: asyncio.Transport) -> None:
        """Add a connection; close the oldest if there are too many."""
        self.pop(address, None)
        self[address] = transport
        if len(self) > STRANGERS:
            self.pop(next(iter(self))).abort()

    def protocol(self) -> type[H11Protocol]:
        """Return the protocol class for new connections."""
        strangers = self

        class Arriving(H11Protocol):
            def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
                super().connection_made(transport)
                # a small message does not wait for the acknowledgement of the one before
                transport.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                strangers.add(self.client or id(transport), transport)
                self.loop.call_later(PATIENCE, self.lose_patience)

            def lose_patience(self) -> None:
                if self.scope is None:  # no request has arrived yet
                    self.transport.abort()

            def connection_lost(self, exc: Exception | None) -> None:
                super().connection_lost(exc)
                strangers.pop(self.client or id(self.transport), None)

        return Arriving


class Server:
    """The server of one player, from `start` to `stop`. Raises OSError if the port is taken; port 0 selects
    any free port.

    `frames` are the origins of pages that may embed the viewer (none, except for a notebook). `page` is the
    file shown first. The server's thread calls `came(code, accepted)` for each code.
    """

    def __init__(
        self, player: Inbox, port: int = 0, frames: tuple[str, ...] = (), page: str = "index.html"
    ) -> None:
        self.player, self.credentials, self.page = player, Credentials(), page
        self.came: Callable[[str, bool], None] = lambda code, good: None
        # browsers load all modules at once, instead of one level of imports after the other
        script = SCRIPT.search((STATIC / page).read_text(encoding="utf-8"))
        names = modules(script[1], folder=STATIC) if script else ()
        self._preload = ", ".join(f"<{name}>; rel=modulepreload" for name in names)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNREAD)
            self._socket.bind((HOST, port))
        except OSError:
            self._socket.close()
            raise
        self.port = self._socket.getsockname()[1]
        self.clients: set[Client] = set()
        self._strangers = Strangers()
        self.app = Guard(self._pages(), self.credentials, self.port, frames)
        config = uvicorn.Config(
            self.app,
            lifespan="off",
            log_config=None,
            log_level="critical",
            access_log=False,
            ws="websockets-sansio",
            backlog=BACKLOG,
            http=self._strangers.protocol(),
            ws_per_message_deflate=False,
            ws_max_size=LARGEST,
            server_header=False,
            timeout_graceful_shutdown=1,
            proxy_headers=False,
        )
        self._uvicorn = uvicorn.Server(config)
        self._thread = threading.Thread(
            target=self._uvicorn.run, kwargs={"sockets": [self._socket]}, name="ecs-eco viewer", daemon=True
        )

    def start(self) -> Server:
        """Start listening; return when pages can connect."""
        self._thread.start()
        while not self._uvicorn.started and self._thread.is_alive():
            threading.Event().wait(0.01)
        return self

    def address(self, minutes: float = MINUTES) -> str:
        """Return an address that admits one page in time; browsers do not send its code, which is the fragment."""
        return f"http://{HOST}:{self.port}/#code={self.credentials.code(minutes)}"

    def show(self, player: Inbox) -> None:
        """Replace the player; all pages join the new one."""

        def swap() -> None:
            self.player = player
            for client in self.clients:
                player.say(client, {"kind": "join"})

        loops = {client.loop for client in list(self.clients)}
        if loops:
            loops.pop().call_soon_threadsafe(swap)  # in the thread in which pages join and leave
        else:
            swap()

    def stop(self) -> None:
        """Disconnect all pages and stop listening."""
        self._uvicorn.should_exit = True
        if self._thread.ident is not None:
            self._thread.join(5)
        self._socket.close()

    __enter__ = start

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _pages(self) -> Starlette:
        # this machine's media types may differ, and browsers would then refuse scripts
        for suffix, kind in TYPES.items():
            mimetypes.add_type(kind, suffix)

        async def page(_: Request) -> FileResponse:
            return FileResponse(STATIC / self.page, headers={"link": self._preload})

        files = Mount("/", StaticFiles(directory=STATIC, check_dir=False))
        entrance = Route("/enter", self._enter, methods=["POST"])
        return Starlette(routes=[Route("/", page), entrance, WebSocketRoute("/ws", self._speak), files])

    async def _enter(self, request: Request) -> Response:
        """Exchange a page's code for the credential, or confirm its credential; otherwise respond with 403."""
        kind, _, word = request.headers.get("authorization", "").partition(" ")
        handed = None
        if kind == "Code":
            self.came(word, (handed := self.credentials.exchange(word)) is not None)
        elif kind == "Bearer" and self.credentials.admits(word):
            handed = self.credentials.credential
        if handed is None:
            return PlainTextResponse(
                "403: this code was used or has expired; open the address that ecs-eco printed last\n", 403
            )
        return JSONResponse({"credential": handed}, headers={"cache-control": "no-store"})

    async def _speak(self, websocket: WebSocket) -> None:
        """Serve one page until it disconnects."""
        if len(self.clients) >= PAGES:
            await websocket.close(1013, f"{PAGES} pages are already open")
            return
        transport = self._strangers.pop(tuple(websocket.scope["client"] or ()), None)
        await websocket.accept(SUBPROTOCOL)
        client = Client(websocket)
        self.clients.add(client)
        self.player.say(client, {"kind": "join"})
        pouring = asyncio.create_task(client.pour())
        listening = asyncio.create_task(self._listen(client))
        falling = asyncio.create_task(client.behind.wait())
        tasks = (pouring, listening, falling)
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self.player.say(client, {"kind": "leave"})
            self.clients.discard(client)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        if client.behind.is_set():
            if transport is not None:
                # a page that does not read would never receive the closing message
                client.loop.call_later(1.0, transport.abort)
            await websocket.close(1013, "too far behind")

    async def _listen(self, client: Client) -> None:
        """Deliver messages from a page until it disconnects."""
        while True:
            try:
                text = await client.socket.receive_text()
            except (WebSocketDisconnect, KeyError, RuntimeError):  # disconnected, or bytes instead of text
                return
            try:
                request = json.loads(text)
            except (ValueError, RecursionError):
                request = None
            if not isinstance(request, dict) or request.get("kind") in ("join", "leave"):
                request = {"kind": "not a request"}
            # a page that sends requests faster than they are answered must wait, without delaying other pages
            while sum(page is client for page, _ in self.player.inbox.copy()) >= ASKED:
                await asyncio.sleep(0.005)
            self.player.say(client, request)
