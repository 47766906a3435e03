"""Opening the page: print an address, and redirect the browser to it through a private file."""

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

OPENING = 2.0  # [min] time for the browser to open its file
PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="referrer" content="no-referrer"><title>ecs-eco</title>
<meta http-equiv="refresh" content="0; url={address}"><p>To <a href="{address}">ecs-eco</a> …
"""


class Entrance:
    """The addresses of a running server. `announce` receives the first address immediately, and a new one
    whenever the latest address has been used or has expired. `browser` also opens a page.

    Each address admits one page, so an address left in a terminal or in the browser's history is useless to
    other users.
    """

    def __init__(self, server: Server, announce: Callable[[str], None], browser: bool = False) -> None:
        self.server, self._announce = server, announce
        self._code = ""
        self._folder: Path | None = None
        server.came = self._came
        self._say()
        if browser:
            self.open_browser()

    def open_browser(self) -> bool:
        """Open a page in a graphical browser; return whether one is available. Because other users can read its
        command line, it receives the name of a file that only this user can read and that redirects it."""
        if sys.platform.startswith("linux") and not (
            os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
        ):
            return False  # a text browser would take over the terminal
        try:
            return webbrowser.open(self._file(self.server.address(OPENING)).as_uri())
        except (webbrowser.Error, OSError):
            return False

    def close(self) -> None:
        """Remove the file."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None

    def _say(self) -> None:
        address = self.server.address()
        self._code = address.partition("#code=")[2]
        self._announce(address)

    def _came(self, code: str, good: bool) -> None:
        """Announce a new address if a page has used one of this server's and the latest is now invalid."""
        if not self.server.credentials.is_good(self._code) and (
            good or self.server.credentials.was_good(code)
        ):
            with suppress(OSError, ValueError):  # the page is admitted even if the output is closed
                self._say()

    def _file(self, address: str) -> Path:
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="ecs-eco-", dir=_private()))  # mode 0700
        handle, name = tempfile.mkstemp(suffix=".html", dir=self._folder)  # mode 0600
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(PAGE.format(address=address))
        return Path(name)


def _private() -> str | None:
    """Return this user's runtime folder if no other user can enter it."""
    folder = os.environ.get("XDG_RUNTIME_DIR")
    if not folder or not os.path.isabs(folder):
        return None
    try:
        status = os.lstat(folder)
    except OSError:
        return None
    ours = stat.S_ISDIR(status.st_mode) and status.st_uid == os.geteuid() and not status.st_mode & 0o077
    return folder if ours and os.access(folder, os.W_OK) else None
