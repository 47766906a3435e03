"""How people come in: what is said, what the browser is started with, and what lies in a file meanwhile."""

import os
import stat
import sys
import webbrowser
from pathlib import Path

import pytest

from ecs_eco.view.entrance import Entrance
from ecs_eco.view.guard import MINUTES, Credentials


class Desk:
    """A server that nobody listens to: its credentials, and `knock`, as a page does."""

    def __init__(self):
        self.now = 0.0
        self.credentials = Credentials(lambda: self.now)
        self.came = lambda code, good: None

    def address(self, minutes=MINUTES):
        return f"http://127.0.0.1:1/#code={self.credentials.code(minutes)}"

    def knock(self, address):
        code = address.partition("#code=")[2]
        credential = self.credentials.exchange(code)
        self.came(code, credential is not None)
        return credential is not None


@pytest.fixture
def desk():
    return Desk()


@pytest.fixture
def windows(monkeypatch):
    """A machine with windows: what a browser was started with."""
    opened = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address) or True)
    return opened


def test_another_address_is_said_as_soon_as_one_was_used(desk):
    collected = []
    Entrance(desk, collected.append)
    assert len(collected) == 1
    assert desk.knock(collected[0])
    assert len(collected) == 2
    assert not desk.knock(collected[0])
    assert len(collected) == 2  # the one that was said last is good still
    assert desk.knock(collected[1])
    assert len(set(collected)) == 3


def test_who_comes_too_late_makes_it_say_another_one_and_a_stranger_does_not(desk):
    collected = []
    Entrance(desk, collected.append)
    desk.now = 60 * MINUTES + 1
    assert not desk.knock("http://127.0.0.1:1/#code=guessed")
    assert len(collected) == 1
    assert not desk.knock(collected[0])
    assert len(collected) == 2
    assert desk.knock(collected[1])


def test_a_page_comes_in_though_nobody_reads_what_is_said(desk):
    collected = []

    def announce(address):
        if collected:
            raise BrokenPipeError
        collected.append(address)

    Entrance(desk, announce)
    assert desk.knock(collected[0])


def test_the_browser_is_started_with_no_secret(desk, windows):
    collected = []
    entrance = Entrance(desk, collected.append)
    assert entrance.open_browser()
    (started,) = windows  # its arguments stand in the list of processes, which everybody may read
    codes = [*desk.credentials._good]
    assert len(codes) == 2  # that of the terminal, and that of the file
    assert started.startswith("file:///")
    assert not any(word in started for word in [*codes, desk.credentials.credential])
    (code,) = {*codes} - {collected[0].partition("#code=")[2]}
    assert f'url=http://127.0.0.1:1/#code={code}"' in Path(started.removeprefix("file://")).read_text()
    entrance.close()


def test_a_started_browser_shows_no_secret_in_the_list_of_processes(desk, tmp_path, monkeypatch):
    browser, seen = tmp_path / "browser", tmp_path / "seen"
    browser.write_text(f"#!/bin/sh\ntr '\\0' ' ' < /proc/$$/cmdline > {seen}\n")
    browser.chmod(0o700)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "_browsers", {})
    monkeypatch.setattr(webbrowser, "_tryorder", [])
    webbrowser.register("mine", None, webbrowser.GenericBrowser([str(browser), "%s"]), preferred=True)
    entrance = Entrance(desk, lambda address: None)
    assert entrance.open_browser()
    words = seen.read_text()
    assert "file:///" in words
    assert not any(code in words for code in [*desk.credentials._good, desk.credentials.credential])
    entrance.close()


@pytest.mark.parametrize("mask", [0o022, 0o000, 0o077])
def test_the_file_is_for_this_user_alone_and_gone_at_the_end(desk, windows, mask):
    before = os.umask(mask)
    try:
        entrance = Entrance(desk, lambda address: None)
        entrance.open_browser()
    finally:
        os.umask(before)
    path = Path(windows[0].removeprefix("file://"))
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
    assert path.stat().st_uid == os.geteuid()
    entrance.close()
    assert not path.parent.exists()


def test_the_file_lies_in_the_folder_of_the_session_where_that_is_private(
    desk, windows, tmp_path, monkeypatch
):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    for mode, inside in ((0o700, True), (0o755, False), (0o777, False)):
        tmp_path.chmod(mode)
        entrance = Entrance(desk, lambda address: None)
        entrance.open_browser()
        path = Path(windows[-1].removeprefix("file://"))
        assert path.is_relative_to(tmp_path / path.parent.name) == inside
        assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
        entrance.close()


def test_the_code_of_the_file_is_good_for_two_minutes(desk, windows):
    entrance = Entrance(desk, lambda address: None)
    entrance.open_browser()
    entrance.close()
    (code,) = [code for code, end in desk.credentials._good.items() if end <= 120]
    desk.now = 121
    assert desk.credentials.exchange(code) is None


def test_no_browser_for_terminals_is_opened(desk, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr("webbrowser.open", lambda address: pytest.fail("opened"))
    entrance = Entrance(desk, lambda address: None)
    assert not entrance.open_browser()
    entrance.close()


def test_the_command_says_what_an_address_is_good_for(capsys):
    from ecs_eco.cli.watch import _Announcer

    announce = _Announcer("Savanna")
    announce("http://127.0.0.1:1/#code=a")
    announce("http://127.0.0.1:1/#code=b")
    first, *about, second = capsys.readouterr().out.splitlines()
    assert first == "Savanna: http://127.0.0.1:1/#code=a"
    assert "works once" in " ".join(about)
    assert second == "Link for another page: http://127.0.0.1:1/#code=b"
