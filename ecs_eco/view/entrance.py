"""How people come to a server: an address that is said to them, and a private file that takes their browser there."""

from __future__ import annotations

import os
import shutil
import stat
import sys
import tempfile
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from ecs_eco.view.server import Server

OPENING = 2.0  # [min] that a browser has to open its file
PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="referrer" content="no-referrer"><title>ecs-eco</title>
<meta http-equiv="refresh" content="0; url={address}"><p>To <a href="{address}">ecs-eco</a> …
"""


class Entrance:
    """The addresses of a running server: `announce` hears the first one now, another one when it was used or came too late.

    What is said lets in one page, so whoever reads it later, on the terminal or in the browser's history, is not let in.
    """

    def __init__(self, server: Server, announce: Callable[[str], None]) -> None:
        self.server, self._announce = server, announce
        self._code = ""
        self._folder: Path | None = None
        server.came = self._came
        self._say()

    def open_browser(self) -> bool:
        """Open a page in a browser with windows; return whether there is one.

        What a browser is started with can be read by all users of a machine. So it is given the name of a file that only this
        user may read, which takes it to the address.
        """
        if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            return False  # a browser for terminals would take this one
        try:
            return webbrowser.open(self._file(self.server.address(OPENING)).as_uri())
        except (webbrowser.Error, OSError):
            return False

    def close(self) -> None:
        """LeaveRemains no file behind."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None

    def _say(self) -> None:
        address = self.server.address()
        self._code = address.partition("#code=")[2]
        self._announce(address)

    def _came(self, code: str, good: bool) -> None:
        """Say another address where the last one will not do any more, and somebody used it or another that was good once."""
        if not self.server.credentials.is_good(self._code) and (good or self.server.credentials.was_good(code)):
            with suppress(OSError, ValueError):  # nobody reads what is said any more: the page comes in all the same
                self._say()

    def _file(self, address: str) -> Path:
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="ecs-eco-", dir=_private()))  # of mode 0700
        handle, name = tempfile.mkstemp(suffix=".html", dir=self._folder)  # of mode 0600
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(PAGE.format(address=address))
        return Path(name)


def _private() -> str | None:
    """Return this user's folder for what lives as long as a session, where there is one that nobody else may enter."""
    folder = os.environ.get("XDG_RUNTIME_DIR")
    if not folder or not os.path.isabs(folder):
        return None
    try:
        status = os.lstat(folder)
    except OSError:
        return None
    ours = stat.S_ISDIR(status.st_mode) and status.st_uid == os.geteuid() and not status.st_mode & 0o077
    return folder if ours and os.access(folder, os.W_OK) else None
