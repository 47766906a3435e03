"""Access control of the viewer's server: one-time codes, each exchanged for the credential of this server;
requests from its own pages on this machine alone, and data for pages with the credential."""

from __future__ import annotations

import hmac
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

MINUTES = 10.0  # a code is good for
REMEMBERED = 64  # used and expired codes that are kept, so that the refusal can name the reason


def same(word: str, secret: str) -> bool:
    """Return whether two words are equal, in a time that does not depend on where they differ."""
    return hmac.compare_digest(word.encode("utf-8", "surrogateescape"), secret.encode())


class Credentials:
    """The codes of one server, and its credential; any thread may ask.

    Each server draws a new credential, which opens no other server, not even a later one on the same port.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.credential = secrets.token_urlsafe(32)
        self._clock, self._lock = clock, threading.Lock()
        self._good: dict[str, float] = {}  # when each ends [s]
        self._gone: deque[str] = deque(maxlen=REMEMBERED)

    def code(self, minutes: float = MINUTES) -> str:
        """Return a new code, valid for one exchange within these minutes."""
        code = secrets.token_urlsafe(24)
        with self._lock:
            self._good[code] = self._clock() + 60 * minutes
        return code

    def exchange(self, code: str) -> str | None:
        """Return the credential for a code, which is then used up; None for an invalid one."""
        with self._lock:
            self._forget_old()
            matches = _among(code, self._good)
            for good in matches:
                del self._good[good]
                self._gone.append(good)
            return self.credential if matches else None

    def is_good(self, code: str) -> bool:
        """Return whether a code could be exchanged now."""
        with self._lock:
            self._forget_old()
            return bool(_among(code, self._good))

    def was_good(self, code: str) -> bool:
        """Return whether a code was one of ours, and is used up or too old."""
        with self._lock:
            self._forget_old()
            return bool(_among(code, self._gone))

    def admits(self, credential: str) -> bool:
        """Return whether this is the credential of this server."""
        return same(credential, self.credential)

    def _forget_old(self) -> None:
        now = self._clock()
        for code in [code for code, end in self._good.items() if end <= now]:
            del self._good[code]
            self._gone.append(code)


def _among(code: str, secrets_: Iterable[str]) -> list[str]:
    """Return those equal to this code; all are compared, so that the time does not reveal which."""
    return [secret for secret in secrets_ if same(code, secret)]


SUBPROTOCOL = "ecs-eco"
ANSWERS = {
    "cache-control": "no-cache",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
}
"""Headers of every response, beside the Content-Security-Policy;
a response's own cache-control takes precedence."""
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "font-src 'self'; worker-src 'self' blob:; base-uri 'none'; form-action 'none'"
)


def headers_of(scope: Any) -> dict[str, list[str]]:
    """Return the headers of a request: each name in lower case, with all its values."""
    headers: dict[str, list[str]] = {}
    for name, value in scope["headers"]:
        headers.setdefault(name.decode("latin-1").lower(), []).append(value.decode("latin-1"))
    return headers


class Guard:
    """An ASGI application before another one: 403 for another Host, for another Origin,
    and for a WebSocket without the credential.

    The Host must be one of ours because a foreign page can make its own name resolve to 127.0.0.1 (DNS
    rebinding). The page's files hold no data and need no credential. WebSockets carry data: they must name
    their Origin, and send the credential as a subprotocol, the only header that a page may set there. Cookies
    are not used, because they ignore ports: another server on this machine would get them too.
    """

    def __init__(self, app: Any, credentials: Credentials, port: int, frames: tuple[str, ...] = ()) -> None:
        self.app, self.credentials = app, credentials
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        self.origins = {f"http://{host}" for host in self.hosts}
        sockets = " ".join(sorted(f"ws://{host}" for host in self.hosts))
        ancestors = " ".join(frames) or "'none'"  # who may show the page in a frame: nobody, or a notebook
        self.policy = f"{POLICY}; frame-ancestors {ancestors}; connect-src 'self' {sockets}"
        self.answers = {n: v for n, v in ANSWERS.items() if not (frames and n == "x-frame-options")}

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Let a request through, or refuse it."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        why = self.refusal(scope)
        if why and scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": why})  # before it is accepted: 403
        elif why:
            await send(
                {
                    "type": "http.response.start",
                    "status": 403,
                    "headers": self._headers([(b"content-type", b"text/plain")]),
                }
            )
            await send({"type": "http.response.body", "body": f"403: {why}\n".encode()})
        else:
            await self.app(scope, receive, self._adding(send) if scope["type"] == "http" else send)

    def refusal(self, scope: Any) -> str:
        """Return why a request is refused, "" if it is not."""
        headers = headers_of(scope)
        if len(headers.get("host", [])) != 1 or headers["host"][0].lower() not in self.hosts:
            return "another Host"
        origins = headers.get("origin", [])
        if any(origin.lower() not in self.origins for origin in origins) or (
            scope["type"] == "websocket" and len(origins) != 1
        ):
            return "another Origin"
        if scope["type"] == "websocket" and not self._shown(scope["subprotocols"]):
            return "no credential, or another one: open the address that ecs-eco printed"
        return ""

    def _shown(self, subprotocols: list[str]) -> bool:
        return (
            len(subprotocols) == 2
            and subprotocols[0] == SUBPROTOCOL
            and self.credentials.admits(subprotocols[1])
        )

    def _adding(self, send: Any) -> Any:
        """Return `send` with our headers on the response."""

        async def sending(message: Any) -> None:
            if message["type"] == "http.response.start":
                message = message | {"headers": self._headers(message["headers"])}
            await send(message)

        return sending

    def _headers(self, own: Any) -> list[tuple[bytes, bytes]]:
        given = {n.decode("latin-1").lower() for n, _ in own}
        ours = {
            n: v
            for n, v in {**self.answers, "content-security-policy": self.policy}.items()
            if n != "cache-control" or n not in given
        }
        return [
            *((n, v) for n, v in own if n.decode("latin-1").lower() not in ours),
            *((n.encode(), v.encode()) for n, v in ours.items()),
        ]
