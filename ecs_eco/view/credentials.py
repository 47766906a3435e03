"""Access to the server: one-time codes that soon expire, each exchanged for the credential of this server."""

from __future__ import annotations

import hmac
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable

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
