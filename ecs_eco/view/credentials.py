"""What lets pages in: codes that work once and not for long, each exchanged for the credential of this server."""

from __future__ import annotations

import hmac
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable

MINUTES = 10.0  # a code is good for
REMEMBERED = 64  # codes that were good once: whoever comes with one of these is told so


def same(word: str, secret: str) -> bool:
    """Return whether two words are equal; takes equally long for all that are as long as the secret."""
    return hmac.compare_digest(word.encode("utf-8", "surrogateescape"), secret.encode())


class Credentials:
    """The codes of one server, and its credential; any thread may ask.

    The credential is drawn anew for each server: it opens no other one, not even a later one on the same port.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.credential = secrets.token_urlsafe(32)
        self._clock, self._lock = clock, threading.Lock()
        self._good: dict[str, float] = {}  # when each ends [s]
        self._gone: deque[str] = deque(maxlen=REMEMBERED)

    def code(self, minutes: float = MINUTES) -> str:
        """Return a new code, good for one exchange within so many minutes."""
        code = secrets.token_urlsafe(24)
        with self._lock:
            self._good[code] = self._clock() + 60 * minutes
        return code

    def exchange(self, code: str) -> str | None:
        """Return the credential for a code, which is used up then; None for one that is not good (any more)."""
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
        """Return whether somebody shows the credential of this server."""
        return same(credential, self.credential)

    def _forget_old(self) -> None:
        now = self._clock()
        for code in [code for code, end in self._good.items() if end <= now]:
            del self._good[code]
            self._gone.append(code)


def _among(code: str, secrets_: Iterable[str]) -> list[str]:
    """Return those that are this code, after a look at all of them: how long it takes says nothing of which."""
    return [secret for secret in secrets_ if same(code, secret)]
