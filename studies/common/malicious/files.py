"""Malicious checkpoints, manifests, recordings, policies and journals: harmless files that were changed and
resealed."""

from __future__ import annotations

import copy
import json
import random
import shutil
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from studies.common.malicious.ground import EVERY, TICKS, Attack, Ground, cli
from studies.common.malicious.templates import KEYS, NAMES, put, renamed
from studies.common.malicious.worlds import mutate, payloads

WORDS = [
    "manifest.json",
    "checkpoints",
    "tick-",
    "part-",
    "safetensors",
    "journal.jsonl",
    "world.toml",
    "case-",
    "`code` does not list",
    "not allowed yet",
    "controls",
]


def _named(ground: Ground) -> Iterator[tuple[str, Callable[[dict[str, Any]], None]]]:
    """Return changes to a recorded configuration that name code at every key, both from a listed file and
    from other sources such as Python's own modules."""

    def naming(pattern: str, name: str) -> Callable[[dict[str, Any]], None]:
        def change(data: dict[str, Any]) -> None:
            put(data["config"], pattern, renamed(pattern, name, ground.shell))
            if name.startswith("evil:"):
                data["config"]["code"] = ["evil.py"]
                data["code"] = [{"entry": "evil.py", "sha256": "0" * 64}]

        return change

    for i, pattern in enumerate(KEYS):
        own = next(word for word in json.dumps(KEYS[pattern]).split('"') if word.startswith("evil:"))
        for name in (own, NAMES[i], NAMES[(i + 9) % len(NAMES)]):
            yield f"{pattern} names {name}", naming(pattern, name)


def _setting(key: str, value: Any) -> Callable[[dict[str, Any]], None]:
    return lambda data: data.__setitem__(key, copy.deepcopy(value))


def _put_evil(ground: Ground, run: Path) -> None:
    ground.put_evil(run / "code")


# --- checkpoints


def checkpoints(ground: Ground) -> Iterator[Attack]:
    """Return checkpoints that name code in their configuration, list of code, components or folder, and files
    of other kinds in place of checkpoints."""
    evil = str(ground.home / "path")
    others: dict[str, Any] = {
        "plain": [[1, "evil:Wool"]],
        "code": [{"entry": "evil.py", "sha256": "0" * 64}],
        "folder": evil,
        "instances": ["evil:Wait"],
        "systems": ["evil:Wait"],
        "environment": ["evil:flow"],
        "intervened": [[1, {"kind": "set", "set": {"systems": ["evil:Wait"]}}]],
        "causes": ground.texts,
        "options": {"policies": {"snail": f"{evil}/evil.py"}, "learn": "evil:Wait"},
    }
    changes = [
        *_named(ground),
        *((f"{key} says {str(value)[:40]}", _setting(key, value)) for key, value in others.items()),
    ]
    for name in ("os:system", "pydoc:pipepager", "evil:Wool"):
        changes.append((f"a plain component {name}", _setting("plain", [[1, name]])))
    for i, (label, change) in enumerate(changes):
        meta = copy.deepcopy(ground.checkpoint[0])
        change(meta)
        yield _checkpoint(ground, label, meta, i)
    for label, blob in ground.blobs.items():
        yield _checkpoint(ground, f"is {label}", blob, 0)


def checkpoints_by_mutation(ground: Ground, seed: int, number: int) -> Iterator[Attack]:
    """Return a checkpoint with a payload in its metadata."""
    for i in range(number):
        chance, meta = random.Random(seed * 1_000_000 + i), copy.deepcopy(ground.checkpoint[0])
        part = meta if chance.random() < 0.4 else meta["config"]
        yield _checkpoint(
            ground,
            f"{seed}.{i}: {mutate(part, chance, payloads(ground), ['systems', 'function', 'code', 'plain'])}",
            meta,
            i,
        )


def _checkpoint(ground: Ground, label: str, content: Any, turn: int) -> Attack:
    from ecs_eco import World
    from ecs_eco.record import checkpoint as file, fork

    run = ground.copy_of_run()
    _put_evil(ground, run)
    path = sorted((run / "checkpoints").iterdir())[-1]
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        file.write(path, content, ground.checkpoint[1])
    more = [
        ("resume", cli("resume", run, "--until", str(TICKS + 2), "-q", "--no-report")),
        (
            "fork",
            lambda: _none(
                fork(
                    run,
                    ground.new(),
                    TICKS,
                    ["species.snail.metabolism.basal=0.02"],
                    TICKS + 2,
                    report=False,
                    complain=lambda text: None,
                )
            ),
        ),
    ]
    return Attack(
        f"a checkpoint: {label}",
        WORDS,
        [("restore", lambda: _none(World.restore(path).run(1))), more[turn % 2]],
    )


def _none(_: Any) -> None:
    """Never report a refusal."""


# --- manifests


def manifests(ground: Ground) -> Iterator[Attack]:
    """Return manifests that name code in their configuration or in another entry."""
    for i, (label, change) in enumerate(_named(ground)):
        yield _manifest(ground, label, change, i)
    evil = str(ground.home / "path" / "evil.py")
    others: dict[str, Any] = {
        "policies": evil,
        "weights": {"snail": "0" * 64},
        "controls": ["evil:Wait"],
        "code": [{"entry": evil, "sha256": ""}],
        "command": ground.texts[1],
        "causes": ground.texts,
        "colors": {"snail": ground.texts[0]},
        "world": ground.texts[0],
        "genomes": ground.texts,
        "versions": {"python": ground.texts[0]},
        "species": ground.texts,
        "id": ground.texts[3],
        "intervened": [
            [1, {"kind": "set", "set": {"species.snail.genome.mutate.operator": "pydoc:pipepager"}}]
        ],
        "forked": {"from": evil, "tick": 1},
    }
    for i, (key, value) in enumerate(others.items()):
        yield _manifest(ground, f"{key} says {str(value)[:40]}", _setting(key, value), i)


def manifests_by_mutation(ground: Ground, seed: int, number: int) -> Iterator[Attack]:
    """Return a manifest that contains a payload."""
    for i in range(number):
        chance = random.Random(seed * 1_000_000 + i)

        def change(data: dict[str, Any], chance: random.Random = chance) -> None:
            mutate(
                data if chance.random() < 0.4 else data["config"],
                chance,
                payloads(ground),
                ["systems", "function", "code", "controls"],
            )

        yield _manifest(ground, f"{seed}.{i}", change, i)


def _manifest(ground: Ground, label: str, change: Callable[[dict[str, Any]], None], turn: int) -> Attack:
    from ecs_eco.record import seal

    run = ground.copy_of_run()
    _put_evil(ground, run)
    manifest = seal.read_manifest(run)
    change(manifest)
    seal.write_manifest(run, manifest)
    return Attack(f"a manifest: {label}", WORDS, _of_run(ground, run, turn))


def _of_run(ground: Ground, run: Path, turn: int) -> list[tuple[str, Callable[[], Any]]]:
    """Return three uses of a recorded run; successive calls rotate through the uses."""
    out = ground.new()
    every = [
        ("repeat", cli("repeat", run, "-q")),
        ("why", cli("why", run, "--out", out / "why")),
        ("resume", cli("resume", run, "--until", str(TICKS + EVERY), "-q", "--no-report")),
        ("lineage", cli("lineage", run)),
        ("picture", cli("picture", run, out / "tick.png", "-q", "--size", "320x320")),
        ("watch", lambda: _watched(run)),
        ("picture of an organism", cli("picture", run, out / "snail.png", "-q", "--organism", "1")),
        ("report", cli("report", run, "--out", out / "report")),
    ]
    return [every[(3 * turn + k) % len(every)] for k in range(3)]


def _watched(run: Path) -> str:
    """Show the recording on a page that requests unrecorded data."""
    from ecs_eco.view.player import Player
    from ecs_eco.view.replay import Replay
    from studies.common.malicious.messages import Page

    page = Page(Player(Replay(run), playing=False))
    return page.ask({"kind": "seek", "tick": 3}) or page.ask({"kind": "fill", "uid": 1})


# --- recordings and policies


def recordings(ground: Ground) -> Iterator[Attack]:
    """Return files of other kinds in place of parts, and parts that make the reader unpickle a custom
    type."""
    for i, (label, blob) in enumerate(ground.blobs.items()):
        for kind in ("series", "births"):
            yield _part(ground, f"{kind}: {label}", kind, blob, i)
    for i, kind in enumerate(("series", "births", "snapshots")):
        yield _part(ground, f"{kind}: a type of its own", kind, None, i)


def _part(ground: Ground, label: str, kind: str, content: bytes | None, turn: int) -> Attack:
    run = ground.copy_of_run()
    path = sorted((run / kind).glob("part-*.parquet"))[0]
    path.write_bytes(_pickled_type(path, ground.blobs["a pickle"]) if content is None else content)
    return Attack(f"a recording: {label}", WORDS, _of_run(ground, run, turn))


def _pickled_type(path: Path, pickled: bytes) -> bytes:
    """Return the part, validly sealed, with a column of an Arrow type that claims its content must be
    unpickled."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from ecs_eco.record import seal

    table, metadata_of = pq.read_table(path), pq.read_metadata(path).metadata
    kept = {k: v for k, v in metadata_of.items() if k.startswith(b"ecs-eco") and k != seal.KEY.encode()}
    name = table.schema.names[0]
    field = pa.field(
        name,
        table.schema.field(0).type,
        metadata={"ARROW:extension:name": "arrow.py_extension_type", "ARROW:extension:metadata": pickled},
    )
    memory = pa.BufferOutputStream()
    with pq.ParquetWriter(memory, table.schema.set(0, field).with_metadata(None)) as writer:
        writer.write_table(
            pa.table(
                dict(zip(table.schema.names, table.columns, strict=True)),
                schema=table.schema.set(0, field).with_metadata(None),
            )
        )
        writer.add_key_value_metadata(
            {k.decode(): v.decode() for k, v in kept.items()} | {seal.KEY: seal.BLANK}
        )
    return seal.sealed(memory.getvalue().to_pybytes())[0]


def policies(ground: Ground) -> Iterator[Attack]:
    """Return files that replace policies: passed to a run, named in a world, and in a run's folder."""
    import numpy as np
    from safetensors.numpy import save

    head = save(
        {"a": np.zeros(3, np.float32)}, {"format": "pt", "code": ground.texts[0], "__class__": "evil:Wait"}
    )
    for label, blob in {**ground.blobs, "weights that name code": head}.items():
        folder = ground.new()
        folder.mkdir()
        for species in ("deer", "wolf"):
            (folder / f"{species}.safetensors").write_bytes(blob)
        few = [w for name in ("grass", "deer", "wolf") for w in ("--set", f"species.{name}.count=4")]
        run = cli(
            "run",
            "predator-prey",
            *few,
            "--ticks",
            "2",
            "-q",
            "--no-report",
            "--out",
            folder / "out",
            "--policies",
            folder,
        )
        check = cli(
            "check", "predator-prey", "--set", f'species.deer.policy.file="{folder}/deer.safetensors"'
        )
        named = cli(
            "run",
            "predator-prey",
            *few,
            "--ticks",
            "2",
            "-q",
            "--no-report",
            "--out",
            folder / "out2",
            "--set",
            f'species.deer.policy.file="{folder}/deer.safetensors"',
        )
        yield Attack(
            f"a policy: {label}",
            WORDS,
            [("--policies", run), ("check of a world that names it", check), ("run of it", named)],
        )


# --- journals of searches


def journals(ground: Ground) -> Iterator[Attack]:
    """Return journals that name code in their header or values, and files of other kinds in place of
    journals."""
    lines = _searched(ground)[1]
    for name in ("evil:judge", "os:system", *ground.texts[:4]):
        for change in ({"objective": name}, {"world": name}, {"optimiser": name}):
            yield _journal(ground, f"its head with {change}", [lines[0] | change, *lines[1:]])
        yield _journal(
            ground,
            f"values name {name[:30]}",
            [
                *lines[:1],
                *(e | {"values": {"species.snail.genome.mutate.operator": name}} for e in lines[1:]),
            ],
        )
        yield _journal(
            ground, f"a score that is {name[:30]}", [*lines[:1], *(e | {"score": name} for e in lines[1:])]
        )
    for label, blob in ground.blobs.items():
        yield _journal(ground, f"is {label}", blob)


def journals_by_mutation(ground: Ground, seed: int, number: int) -> Iterator[Attack]:
    """Return a journal that contains a payload."""
    for i in range(number):
        chance, lines = random.Random(seed * 1_000_000 + i), copy.deepcopy(_searched(ground)[1])
        where = mutate(
            chance.choice(lines), chance, payloads(ground), ["objective", "values", "operator", "function"]
        )
        yield _journal(ground, f"{seed}.{i}: {where}", lines)


SEARCH = (
    "--trials",
    "1",
    "--ticks",
    "2",
    "--workers",
    "1",
    "-q",
    "--range",
    "species.snail.body.radius=0.05:0.2",
    "--world-seeds",
    "1",
    "--confirm-world-seeds",
    "1",
    "--confirm-training-seeds",
    "1",
)


@cache
def _searched(ground: Ground) -> tuple[Path, list[dict[str, Any]]]:
    """Search the garden; return the folder and the journal's lines without their seals."""
    from ecs_eco.config.edit import as_toml
    from ecs_eco.lab.searching.journal import NAME, WORD, read

    folder = ground.new()
    folder.mkdir()
    (folder / "world.toml").write_text(as_toml(ground.garden), encoding="utf-8")
    if output := cli("search", folder / "world.toml", *SEARCH, "--out", folder / "out")():
        raise RuntimeError(f"the harmless search failed: {output}")
    return folder, [{k: v for k, v in line.items() if k != WORD} for line in read(folder / "out" / NAME)]


def _journal(ground: Ground, label: str, content: Any) -> Attack:
    from ecs_eco.lab.searching.journal import NAME, Journal

    whole, folder = _searched(ground)[0] / "world.toml", ground.new()
    folder.mkdir()
    shutil.copy(whole.parent / "out" / "plan.json", folder)
    if isinstance(content, bytes):
        (folder / NAME).write_bytes(content)
    else:
        journal = Journal(folder, {k: v for k, v in content[0].items() if k != "kind"})
        for entry in content[1:]:
            journal.add(**entry) if isinstance(entry.get("kind"), str) else journal._append(entry)
    again = [w if w != "1" or SEARCH[i - 1] != "--trials" else "2" for i, w in enumerate(SEARCH)]
    return Attack(
        f"a journal: {label}",
        [*WORDS, "--out"],
        [("search continues", cli("search", whole, *again, "--out", folder))],
    )
