"""Who may speak to the viewer's server: pages of its own, on this machine, that know the token."""

from __future__ import annotations

import hmac
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

ANSWERS = {
    "cache-control": "no-cache",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
}
"""Headers of every answer, beside the Content-Security-Policy."""
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self'; "
    "worker-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class Guard:
    """An ASGI application before another one: 403 without token or cookie, for another Origin, for another Host.

    The Host must be one of ours because a foreign page can make its own name stand for 127.0.0.1 (DNS rebinding). A request
    with the token in its address gets a cookie, which later requests show instead. WebSockets must name their Origin.
    """

    def __init__(self, app: Any, token: str, port: int) -> None:
        self.app, self.token, self.cookie = app, token, f"ecs-eco-{port}"
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        self.origins = {f"http://{host}" for host in self.hosts}
        sockets = " ".join(sorted(f"ws://{host}" for host in self.hosts))
        self.policy = f"{POLICY}; connect-src 'self' {sockets}"

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Let a request through, or refuse it."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        why = self.refusal(scope)
        if why and scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": why})  # before it is accepted: 403
        elif why:
            await send({"type": "http.response.start", "status": 403, "headers": self._headers([(b"content-type", b"text/plain")])})
            await send({"type": "http.response.body", "body": f"403: {why}\n".encode()})
        else:
            await self.app(scope, receive, self._adding(scope, send) if scope["type"] == "http" else send)

    def refusal(self, scope: Any) -> str:
        """Return why a request is refused, "" where it is not."""
        found: dict[str, list[str]] = {}
        for name, value in scope["headers"]:
            found.setdefault(name.decode("latin-1").lower(), []).append(value.decode("latin-1"))
        if len(found.get("host", [])) != 1 or found["host"][0].lower() not in self.hosts:
            return "another Host"
        origins = found.get("origin", [])
        if any(origin.lower() not in self.origins for origin in origins) or (scope["type"] == "websocket" and len(origins) != 1):
            return "another Origin"
        if self._asked(scope) or self._shown(found.get("cookie", [])):
            return ""
        return "no token, or another one: open the address that ecs-eco printed"

    def _asked(self, scope: Any) -> bool:
        tokens = parse_qs(scope["query_string"].decode("latin-1")).get("token", [])
        return len(tokens) == 1 and self._same(tokens[0])

    def _shown(self, cookies: list[str]) -> bool:
        for text in cookies:
            try:
                found = SimpleCookie(text)
            except CookieError:
                continue
            if self.cookie in found and self._same(found[self.cookie].value):
                return True
        return False

    def _same(self, word: str) -> bool:
        return hmac.compare_digest(word.encode(), self.token.encode())

    def _adding(self, scope: Any, send: Any) -> Any:
        """Return `send` with our headers on the answer, and the cookie where the address had the token."""

        async def sending(message: Any) -> None:
            if message["type"] == "http.response.start":
                message = message | {"headers": self._headers(message["headers"], self._asked(scope))}
            await send(message)

        return sending

    def _headers(self, own: Any, cookie: bool = False) -> list[tuple[bytes, bytes]]:
        ours = {**ANSWERS, "content-security-policy": self.policy}
        if cookie:
            ours["set-cookie"] = f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"
        return [*((n, v) for n, v in own if n.decode("latin-1").lower() not in ours), *((n.encode(), v.encode()) for n, v in ours.items())]
