"""How to have a branch again without the page: lines for a world file, and a command."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ecs_eco.compiled import portable
from ecs_eco.view.source import Message


class Start(NamedTuple):
    """How the original began: words of a command line after `ecs-eco`: ("run", "lamb", "--seed", "1").

    `planned` are the interventions of its world file, which an assignment on the command line replaces.
    """

    words: Sequence[str]
    planned: Sequence[Message] = ()


def of_run(folder: str, code: bool, tick: int, change: Message | None) -> Message:
    """Return {"toml", "command"} for a branch of a recorded run, with `code` of its own or without, from the
    start of a tick."""
    done = [] if change is None else [dated(change, tick)]
    words = ["ecs-eco", *portable.option().split(), "resume", folder, "--from-tick", str(tick)]
    words += ["--trust"] if code else []
    if change is not None and change["kind"] == "set":
        for key, value in change["set"].items():
            words += ["--set", f"{key}={inline(value)}"]
    elif change is not None:
        words += ["--set", f"interventions={inline(done)}"]
    return {"toml": tables(done), "command": shlex.join([*words, "--out", "NEW"])}


def of_world(start: Start | None, acts: Sequence[Message], tick: int, change: Message | None) -> Message:
    """Return {"toml", "command"} for a branch of a living world; `acts` are what was done to it by hand, each
    with its tick. No command where it is not known how the world began."""
    done = [dated(what, what["at"]) for what in acts] + ([] if change is None else [dated(change, tick)])
    if start is None:
        return {"toml": tables(done), "command": ""}
    words = ["ecs-eco", *start.words]
    if done:
        words += ["--set", f"interventions={inline([*start.planned, *done])}"]
    return {"toml": tables(done), "command": shlex.join([*words, "--out", "NEW"])}


def dated(what: Message, tick: int) -> Message:
    """Return an intervention as a world file has it: with its tick first."""
    return {"at": tick} | {key: value for key, value in what.items() if key != "at" and value is not None}


def tables(done: Sequence[Message]) -> str:
    """Return interventions as TOML, a table each."""
    return "\n".join(
        "\n".join(
            ["[[interventions]]", *(f"{_key(key)} = {inline(value)}" for key, value in what.items()), ""]
        )
        for what in done
    )


def inline(value: Any) -> str:
    """Return a value of JSON's types as TOML in one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(key)} = {inline(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(inline, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


def _key(key: str) -> str:
    return key if key.replace("_", "").replace("-", "").isalnum() and key.isascii() else json.dumps(key)
