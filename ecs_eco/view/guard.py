"""Access control for the viewer's server: codes, the credential, and refusal of requests from other sites."""

import hmac
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

MINUTES = 10.0  # lifetime of a code
REMEMBERED = 64  # used and expired codes to remember, so that a refusal can state the reason


def same(word: str, secret: str) -> bool:
    """Return whether two strings are equal, in an amount of time that does not depend on where they differ."""
    return hmac.compare_digest(word.encode("utf-8", "surrogateescape"), secret.encode())


class Credentials:
    """The codes and the credential of one server, which no other server accepts, even a later one on this port.
    All methods are thread-safe."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.credential = secrets.token_urlsafe(32)
        self._clock, self._lock = clock, threading.Lock()
        self._good: dict[str, float] = {}  # expiry of each code [s]
        self._gone: deque[str] = deque(maxlen=REMEMBERED)

    def code(self, minutes: float = MINUTES) -> str:
        """Return a new code, valid for one exchange within this many minutes."""
        code = secrets.token_urlsafe(24)
        with self._lock:
            self._good[code] = self._clock() + 60 * minutes
        return code

    def exchange(self, code: str) -> str | None:
        """Return the credential in exchange for a code, which is then used up; None if the code is invalid."""
        with self._lock:
            self._forget_old()
            matches = _among(code, self._good)
            for good in matches:
                del self._good[good]
                self._gone.append(good)
            return self.credential if matches else None

    def is_good(self, code: str) -> bool:
        """Return whether a code can be exchanged now."""
        with self._lock:
            self._forget_old()
            return bool(_among(code, self._good))

    def was_good(self, code: str) -> bool:
        """Return whether this server issued a code that has since been used or has expired."""
        with self._lock:
            self._forget_old()
            return bool(_among(code, self._gone))

    def admits(self, credential: str) -> bool:
        """Return whether this is the server's credential."""
        return same(credential, self.credential)

    def _forget_old(self) -> None:
        now = self._clock()
        for code in [code for code, end in self._good.items() if end <= now]:
            del self._good[code]
            self._gone.append(code)


def _among(code: str, secrets_: Iterable[str]) -> list[str]:
    """Return the secrets equal to this code, in a time that does not reveal which one matched."""
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
"""Headers of every response, besides the Content-Security-Policy; a response's own cache-control takes
precedence."""
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "font-src 'self'; worker-src 'self' blob:; base-uri 'none'; form-action 'none'"
)


class Guard:
    """ASGI middleware that responds with 403 to a foreign Host, a foreign Origin, or a WebSocket without the
    credential.

    The Host is checked because a foreign page can make its own name resolve to 127.0.0.1 (DNS rebinding). The
    page's files contain no data and need no credential. WebSockets carry data, so they must name their Origin
    and send the credential as a subprotocol, the only header that a page can set there. There are no cookies,
    because they ignore ports: another server on this machine would receive them too.
    """

    def __init__(
        self, app: ASGIApp, credentials: Credentials, port: int, frames: tuple[str, ...] = ()
    ) -> None:
        self.app, self.credentials = app, credentials
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        self.origins = {f"http://{host}" for host in self.hosts}
        sockets = " ".join(sorted(f"ws://{host}" for host in self.hosts))
        ancestors = " ".join(frames) or "'none'"  # pages that may embed the viewer: none, or a notebook
        policy = f"{POLICY}; frame-ancestors {ancestors}; connect-src 'self' {sockets}"
        self.answers = {"content-security-policy": policy} | {
            n: v for n, v in ANSWERS.items() if not (frames and n == "x-frame-options")
        }

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on or refuse it."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        why = self.refusal(scope)
        if why and scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": why})  # 403
        elif why:
            await PlainTextResponse(f"403: {why}\n", 403)(scope, receive, self._adding(send))
        else:
            await self.app(scope, receive, self._adding(send) if scope["type"] == "http" else send)

    def refusal(self, scope: Scope) -> str:
        """Return why a request is refused, or "" if it is accepted."""
        headers = Headers(scope=scope)
        hosts, origins = headers.getlist("host"), headers.getlist("origin")
        if len(hosts) != 1 or hosts[0].lower() not in self.hosts:
            return "foreign Host"
        if any(origin.lower() not in self.origins for origin in origins) or (
            scope["type"] == "websocket" and len(origins) != 1
        ):
            return "foreign Origin"
        words = scope.get("subprotocols", [])
        shown = len(words) == 2 and words[0] == SUBPROTOCOL and self.credentials.admits(words[1])
        if scope["type"] == "websocket" and not shown:
            return "missing or invalid credential: open the address that ecs-eco printed"
        return ""

    def _adding(self, send: Send) -> Send:
        """Return a `send` that adds the viewer's headers to the response."""

        async def sending(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(raw=list(message["headers"]))
                headers.update({n: v for n, v in self.answers.items() if n != "cache-control"})
                headers.setdefault("cache-control", self.answers["cache-control"])
                message = {**message, "headers": headers.raw}
            await send(message)

        return sending
