"""What reaches the terminal."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.cli.terminal import printable, recorded
from ecs_eco.engine.errors import ConfigError

EVIL = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202egnp\u2066\x00\r\x08"
MOSS = {"count": 3, "body": {"radius": 0.1}}
WORLD = {"format": 1, "name": "garden", "ticks": 3, "space": {"size": [9.0, 9.0]}, "species": {"moss": MOSS}}


def controls(text: str) -> list[str]:
    return [
        c
        for c in text
        if (ord(c) < 32 and c not in "\n\t") or 127 <= ord(c) < 160 or c in "\u202e\u2066\u2028"
    ]


def test_control_characters_are_shown_and_all_else_is_as_it_was() -> None:
    assert controls(printable(EVIL)) == []
    assert printable("\x1b[2J") == "\\u001b[2J"
    assert printable("Waldrand, grün\tund\n日本 🦌 [bold]") == "Waldrand, grün\tund\n日本 🦌 [bold]"
    assert json.loads(printable(json.dumps({"a": "\x9b\u202e"}, ensure_ascii=False))) == {"a": "\x9b\u202e"}


@pytest.mark.parametrize("command", [["check"], ["run", "--ticks", "1", "--no-report"], ["draw"]])
@pytest.mark.parametrize("key", ["title", "description", "unknown", "cause"])
def test_texts_of_a_world_reach_the_terminal_without_control_characters(
    command: list[str], key: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ecs_eco.config.edit import as_toml

    data = json.loads(json.dumps(WORLD)) | {"title": f"T{EVIL}", "description": EVIL}
    if key == "unknown":
        data[f"k{EVIL}"] = f"[red]{EVIL}"
    if key == "cause":
        data["interventions"] = [{"kind": "cull", "species": f"m{EVIL}", "count": 1, "cause": EVIL, "at": 1}]
    path = tmp_path / "world.toml"
    path.write_text(as_toml(data), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, [command[0], str(path), *command[1:]])
    assert controls(done.output) == []
    assert done.exit_code == 2 or (done.exit_code == 0 and "T\\u001b" in done.output) or command[0] == "run"


def test_a_folder_of_a_run_that_was_killed_early_is_refused_with_advice(tmp_path):
    (tmp_path / ".lock").touch()
    with pytest.raises(ConfigError, match="was killed there before it started: run it again with --out"):
        recorded(tmp_path)
