"""Malicious world files that name code at every key that accepts it, listed or not; in formulas and texts;
and at positions chosen by mutation."""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ecs_eco.config.edit import as_toml
from studies.common.malicious.ground import Attack, Ground, cli
from studies.common.malicious.templates import KEYS, NAMES, fields_that_name_code, put, renamed, world_of

ENTRIES = (
    "evil",
    "evilpackage",
    "evilpackage.inside",
    "../path/evil.py",
    "os",
    "pydoc",
    "evil.so",
    "evil.pyc",
    "code.py",
    "__main__",
    "antigravity",
    "sitecustomize",
    "evil.py;evil",
    "http://localhost/evil.py",
    "json",
)


def by_hand(ground: Ground) -> Iterator[Attack]:
    """Yield worlds with code at every key that is unlisted, listed but not allowed, or part of Python; then
    worlds with lists of code, formulas and texts."""
    for i, pattern in enumerate(KEYS):
        mine = world_of(pattern)
        yield attack(ground, f"{pattern} names a module on the path", mine, i)
        yield attack(ground, f"{pattern} names a listed file", mine | {"code": ["evil.py"]}, i + 1)
        yield attack(ground, f"{pattern} names a listed module", mine | {"code": ["evil"]}, i + 2)
        for k in range(3):
            name = NAMES[(3 * i + k) % len(NAMES)]
            data = world_of(pattern)
            put(data, pattern, renamed(pattern, name, ground.shell))
            yield attack(ground, f"{pattern} names {name}", data, i + k)
    for i, entry in enumerate([*ENTRIES, *ground.texts[:3], str(ground.home / "path" / "evil.py")]):
        data = world_of("systems.*") | {"code": [entry], "systems": [f"{entry.removesuffix('.py')}:Wait"]}
        yield attack(ground, f"code lists {entry[:40]!r}", data, i)
    for i, (key, value) in enumerate(_elsewhere(ground)):
        data = copy.deepcopy(ground.garden)
        _set(data, key, value)
        yield attack(ground, f"{'.'.join(key)} says {str(value)[:40]!r}", data, i)


def _elsewhere(ground: Ground) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Return keys with formulas, texts, files, and values set later."""
    snail = ("species", "snail")
    for text in ground.texts[:5]:
        yield (*snail, "happiness"), {"formula": text, "minimum": 0.0}
    for text in ground.texts:
        yield ("title",), text
    yield ("name",), ground.texts[1]
    for file in (
        str(ground.home / "path" / "evil.py"),
        "/proc/self/environ",
        ground.texts[3],
        "http://localhost/evil.safetensors",
    ):
        yield (*snail, "policy"), {"kind": "shared", "file": file}
    for key, name in (
        ("species.snail.happiness.function", "evil:feel"),
        ("species.snail.genome.mutate.operator", "pydoc:pipepager"),
        ("water.current_function", "evil:flow"),
        ("systems", ["evil:Wait"]),
        ("code", ["evil.py"]),
    ):
        yield ("training",), {"set": {key: name}}
        yield ("training",), {"ramp": [{"key": key, "values": [name, name]}]}
        yield ("interventions",), [{"kind": "set", "at": 1, "set": {key: name}}]


def by_mutation(ground: Ground, seed: int, number: int) -> Iterator[Attack]:
    """Yield worlds with a payload at a random position, or at a key inserted at a random position."""
    for i in range(number):
        chance = random.Random(seed * 1_000_000 + i)
        data = world_of(chance.choice(list(KEYS))) if chance.random() < 0.5 else copy.deepcopy(ground.garden)
        if chance.random() < 0.3:
            data["code"] = ["evil.py"]
        where = mutate(
            data,
            chance,
            payloads(ground),
            sorted(fields_that_name_code()) + ["code", "policy", "file", "plain"],
        )
        yield attack(ground, f"{seed}.{i}: {where}", data, i)


def payloads(ground: Ground) -> list[Any]:
    """Return values that would run code if interpreted as code, a shell command, a template or a file."""
    names = ["evil:Wait", "evil:feel", "evil:mutate", *NAMES]
    return [
        *names,
        *ground.texts,
        *[{"function": n} for n in names],
        *[{"operator": n, "cmd": ground.shell} for n in names],
        ["evil:Wait"],
        str(ground.home / "path" / "evil.py"),
    ]


def mutate(data: Any, chance: random.Random, values: list[Any], keys: list[str]) -> str:
    """Insert a payload at a random position in the data, at an existing or a new key; return its position."""
    places = list(_places(data))
    holder, key = chance.choice(places)
    value = copy.deepcopy(chance.choice(values))
    if isinstance(holder, dict) and chance.random() < 0.4:
        key = chance.choice(keys)
    holder[key] = value
    return f"{key} = {str(value)[:60]}"


def _places(node: Any) -> Iterator[tuple[Any, Any]]:
    for key in list(node) if isinstance(node, dict) else range(len(node)):
        yield node, key
        if isinstance(node[key], dict | list):
            yield from _places(node[key])


def _set(data: dict[str, Any], key: tuple[str, ...], value: Any) -> None:
    for word in key[:-1]:
        data = data.setdefault(word, {})
    data[key[-1]] = value


def attack(ground: Ground, label: str, data: dict[str, Any], turn: int) -> Attack:
    """Return an attack that checks a world file, runs it, and passes it to another command chosen in
    rotation."""
    folder = ground.beside()
    path = folder / "world.toml"
    try:
        text = as_toml(data)
    except (TypeError, ValueError, AttributeError):  # not expressible as a table: use malformed text
        text = "\n".join(f"{json.dumps(k)} = {json.dumps(v)}" for k, v in data.items())
    path.write_text(text, encoding="utf-8")
    some = ["--ticks", "2", "--seed", "1"]
    more = {
        "draw": cli("draw", path, "--out", folder / "drawn.png"),
        "train": cli("train", path, "--ticks", "2", "--out", folder / "trained", "-q"),
        "search": cli(
            "search",
            path,
            "--trials",
            "1",
            "--ticks",
            "2",
            "--workers",
            "1",
            "--out",
            folder / "searched",
            "-q",
            "--range",
            "species.snail.body.radius=0.05:0.2",
        ),
        "compare": cli(
            "compare",
            path,
            "--treatment",
            "no-mutation",
            "--seeds",
            "1",
            "--ticks",
            "2",
            "--workers",
            "1",
            "--out",
            folder / "compared",
            "-q",
        ),
        "watch": lambda: _watched(path),
    }
    name = list(more)[turn % len(more)]
    commands = [
        ("check", cli("check", path)),
        ("run", cli("run", path, *some, "--out", folder / "out", "-q", "--no-report")),
        (name, more[name]),
    ]
    return Attack(label, [path.name, "WORLD", "this search", str(folder)], commands)


def _watched(path: Path) -> None:
    """Show the world on a page for one tick."""
    from ecs_eco import World
    from ecs_eco.view.live import Live
    from ecs_eco.view.player import Player
    from studies.common.malicious.messages import Page

    world = World.from_config(path, record=False)
    player = Player(Live(world, 1), None, halted=lambda: world.tick >= 1)
    Page(player)
    player.source.run(player.turn)
