"""Read and resume folders of sweeps, searches, archipelagos and comparisons that were damaged, changed and
resealed, or assembled from several folders.

A change is a damaged file, a value of a different type or a payload in a sealed file, a changed journal line,
a link to a different folder, or a file from another folder of the same kind. No payload may run (and leave a
mark), no file outside the folder may change, no finished run may be lost, and each refusal must name a file.
"""

from __future__ import annotations

import json
import random
import shutil
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from studies.common.study import Study, verdict

HEAD = """
format = 1
name = "moss"
ticks = 8
dt = 1.0
[space]
size = [12.0, 12.0]
edges = "torus"
[species.moss]
count = 20
body = { radius = 0.1, mass = 0.1 }
metabolism = { energy = 0.8, energy_max = 1.0, basal = 0.01 }
reproduction = { kind = "asexual", rate = 0.1, energy_min = 0.5, energy_given = 0.2, dispersal = 1.0 }
lethal = [{ property = "energy", min = 0.0, cause_below = "starved" }]
"""
ISLANDS = """[archipelago]
every = 4
migration_probability = { moss = 0.3 }
islands = { north = {}, south = {} }
"""
PLAN = 'world = "world.toml"\nticks = 6\nworld_seeds = {seeds}\n[grid]\nspecies.moss.count = [10, 20]\n'
KINDS = ("sweep", "search", "archipelago", "comparison")
WORDS = [".json", ".jsonl", ".parquet", ".safetensors", "--out", "/case-", "is a link that leads out"]
KEPT = (
    "manifest.json",
    "done.json",
    "training.json",
    "journal.jsonl",
    ".parquet",
    "sweep.json",
    "plan.json",
    "archipelago.json",
)
SEALED = ("manifest.json", "sweep.json", "plan.json", "archipelago.json", "done.json", "submitted.json")
DRAWN = (".html", ".svg")
COUNT = "species.moss.count"


def words_of(kind: str, folder: Path, more: int = 0) -> list[Any]:
    """Return the command that starts a container or, with `more`, one that resumes it."""
    world, quiet = folder.parent / "world.toml", ["-q", "--workers", "1", "--out", folder]
    return {
        "sweep": ["sweep", folder.parent / "plan.toml", *quiet],
        "search": [
            "search",
            world,
            "--trials",
            1 + more,
            "--ticks",
            "3",
            "--world-seeds",
            "1",
            "--confirm-world-seeds",
            1 + more,
            "--range",
            f"{COUNT}=5:30",
            *quiet,
        ],
        "archipelago": ["run", world, "--ticks", "8", "--no-report", *quiet],
        "comparison": [
            "compare",
            world,
            "--treatment",
            f"{COUNT}=5",
            "--ticks",
            "4",
            "--seeds",
            1 + more,
            *quiet,
        ],
    }[kind]


@cache
def harmless(place: Any, kind: str, which: int) -> Path:
    """Return an unchanged container's folder; `which` selects one of two plans."""
    from studies.common.malicious.ground import cli

    home = place.new()
    home.mkdir()
    text = HEAD.replace("count = 20", f"count = {20 + which}")
    (home / "world.toml").write_text(text + (ISLANDS if kind == "archipelago" else ""), encoding="utf-8")
    (home / "plan.toml").write_text(PLAN.format(seeds=1 + which), encoding="utf-8")
    if said := cli(*words_of(kind, home / "out"))():
        raise RuntimeError(f"the harmless {kind} failed: {said}")
    return home


def attacks(place: Any, kind: str, seed: int, folders: int) -> Iterator[tuple[str, Path, list[Any]]]:
    """Yield the change, the container's folder, and the commands to run on it."""
    for i in range(folders):
        chance, home = random.Random(seed * 1_000_000 + i), place.new()
        shutil.copytree(harmless(place, kind, 0), home)
        folder = home / "out"
        lines = [_line] * 4 if kind == "search" else []
        if kind == "sweep" and i % 2:
            (folder / "jobs" / "0001" / "done.json").unlink()  # some work remains
        label = chance.choice([_damaged, _typed, _typed, _typed, _foreign, _linked, *lines])(
            place, kind, folder, chance
        )
        yield f"{kind} {seed}.{i}: {label}", folder, _commands(place, kind, folder, chance)


def _files(folder: Path, names: tuple[str, ...] = ()) -> list[Path]:
    return sorted(p for p in folder.rglob("*") if p.is_file() and (not names or p.name in names))


def _damaged(place: Any, kind: str, folder: Path, chance: random.Random) -> str:
    from studies.common.fuzz.files import damage

    file = chance.choice([p for p in _files(folder) if p.stat().st_size and p.suffix not in DRAWN])
    file.write_bytes(damage(file.read_bytes(), chance))
    return f"{file.relative_to(folder)} is damaged"


def _odd(place: Any, chance: random.Random) -> Any:
    victim = str(place.home / "victim")
    return chance.choice(
        [
            None,
            True,
            -1,
            0,
            2**70,
            1e300,
            "",
            "x",
            "../../victim",
            victim,
            [],
            {},
            [[]],
            {"a": 1},
            "nan",
            "\0",
            f"a\ntouch {place.marks}/line\n#",
            f"$(touch {place.marks}/word)",
            "evil:Wait",
            *place.texts[:3],
        ]
    )


def _typed(place: Any, kind: str, folder: Path, chance: random.Random) -> str:
    """Change a value in a sealed file and reseal it with the hash of its plan."""
    from ecs_eco.record import container, seal
    from studies.common.malicious.worlds import mutate

    near = [p for p in _files(folder, SEALED) if p.name != "manifest.json"]
    file = chance.choice(near if near and chance.random() < 0.6 else _files(folder, SEALED))
    content = json.loads(file.read_text(encoding="utf-8"))
    what = mutate(content, chance, [_odd(place, chance)], ["training", "name", "policies", "home", "hash"])
    model = _model(kind)
    if file.name == model.FILE and chance.random() < 0.8:
        with suppress(KeyError):
            content["hash"] = container._hash(content, model)
    seal.write_manifest(file.parent, content, file.name)
    return f"{file.relative_to(folder)}: {what}"


def _model(kind: str) -> Any:
    from ecs_eco.lab.comparison import Planned as Comparison
    from ecs_eco.lab.folder import Manifest as Sweep
    from ecs_eco.lab.searching.journal import Planned as Search
    from ecs_eco.record.archipelago import Manifest as Archipelago

    return dict(zip(KINDS, (Sweep, Search, Archipelago, Comparison), strict=True))[kind]


def _foreign(place: Any, kind: str, folder: Path, chance: random.Random) -> str:
    """Replace a file or run folder with one from another container."""
    other = harmless(place, kind, 1) / "out"
    both = [p for p in _files(other) if (folder / p.relative_to(other)).is_file()]
    file = chance.choice(both)
    if chance.random() < 0.3 and file.parent != other:
        shutil.rmtree(folder / file.parent.relative_to(other))
        shutil.copytree(file.parent, folder / file.parent.relative_to(other))
        return f"{file.parent.relative_to(other)} is another's"
    shutil.copy(file, folder / file.relative_to(other))
    return f"{file.relative_to(other)} is another's"


def _linked(place: Any, kind: str, folder: Path, chance: random.Random) -> str:
    """Replace a file or folder in the container, or its lock, with a link to a user's file or folder."""
    victim = place.home / "victim"
    path = chance.choice([p for p in sorted(folder.rglob("*")) if p.suffix not in DRAWN])
    if chance.random() < 0.2:
        path = (path if path.is_dir() else path.parent) / ".lock"
    folder_wanted = path.is_dir()
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
    path.symlink_to(victim if folder_wanted else victim / "thesis.txt")
    return f"{path.relative_to(folder)} is a link"


def _line(place: Any, kind: str, folder: Path, chance: random.Random) -> str:
    """Change a line of a journal, and reseal the whole journal."""
    from ecs_eco.lab.searching.journal import NAME, WORD, Journal, read
    from studies.common.malicious.worlds import mutate

    lines = [{k: v for k, v in line.items() if k != WORD} for line in read(folder / NAME)]
    what = mutate(chance.choice(lines), chance, [_odd(place, chance)], ["values", "candidate", "cell"])
    (folder / NAME).unlink()
    journal = Journal(folder, {})
    (folder / NAME).write_text("", encoding="utf-8")
    journal._seal = ""
    for line in lines:
        journal._append(line)
    return f"{NAME}: {what}"


def _commands(place: Any, kind: str, folder: Path, chance: random.Random) -> list[Any]:
    """Return the command that resumes a container, and a command that reads it or one of its runs."""
    from studies.common.malicious.ground import cli

    runs = [p.parent for p in _files(folder, ("manifest.json",))]
    run, out = chance.choice(runs) if runs else folder, place.new()
    single = [
        ["report", run, "--out", out],
        ["why", run, "--out", out],
        ["repeat", run, "-q"],
        ["resume", run, "--until", "12", "-q", "--no-report"],
        ["tracks", run, out.with_suffix(".gpkg")],
        ["picture", run, out.with_suffix(".png"), "-q", "--size", "320x320"],
        ["lineage", run],
    ]
    whole = {
        "sweep": [
            ["sweep", "status", folder],
            ["sweep", "collect", folder],
            ["sweep", "resume", folder, "--on", "slurm"],
            ["sweep", "job", folder, "0"],
        ],
        "archipelago": [["report", folder, "--out", out], ["lineage", folder]],
    }.get(kind, [])
    first = {
        "sweep": ["sweep", "resume", folder, "-q", "--workers", "1"],
        "archipelago": ["resume", folder, "--until", "10", "-q", "--no-report", "--workers", "1"],
    }
    chosen = [first.get(kind, words_of(kind, folder, 1))]
    if kind != "search":  # it does not store runs
        chosen.append(chance.choice(chance.choice([whole, single]) or single))
    return [(" ".join(map(str, words[:2])), cli(*words)) for words in chosen]


def _slurm(place: Any) -> Path:
    """Return a folder of stand-ins for SLURM commands; sbatch runs a script without its job."""
    tools = place.home / "tools"
    tools.mkdir()
    for name, text in (
        ("sbatch", 'grep -v sys.executable "$2" | grep -v "import sys" | bash >&2; echo 1'),
        ("squeue", ""),
        ("scontrol", ""),
    ):
        (tools / name).write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
        (tools / name).chmod(0o755)
    return tools


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Test one chunk of folders of one kind."""
    import os

    from studies.common.malicious.ground import KINDS as ENDS, Attack, ground, judged

    before, done = os.environ["PATH"], []
    with ground() as place:
        (place.home / "victim").mkdir()
        (place.home / "victim" / "thesis.txt").write_text("mine", encoding="utf-8")
        os.environ["PATH"] = f"{_slurm(place)}{os.pathsep}{before}"
        try:
            for label, folder, commands in attacks(place, case["what"], case["seed"], config["folders"]):
                there = _finished(folder)
                one = judged(place, Attack(label, WORDS, commands))
                lost = sorted(str(p) for p in there - _finished(folder))
                outside = [p.name for p in (place.home / "victim").rglob("*")]
                mine = (place.home / "victim" / "thesis.txt").is_file() and (
                    place.home / "victim" / "thesis.txt"
                ).read_text(encoding="utf-8") == "mine"
                done.append(one | {"lost": lost, "outside": outside != ["thesis.txt"] or not mine})
        finally:
            os.environ["PATH"] = before
    return {
        "folders": len(done),
        "attempts": sum(sum(d["counts"].values()) for d in done),
        "kinds": {kind: sum(d["counts"][kind] for d in done) for kind in ENDS},
        "marks": sum(len(d["marks"]) + len(d["imported"]) for d in done),
        "outside": sum(d["outside"] for d in done),
        "lost": sum(bool(d["lost"]) for d in done),
        "failures": [
            d for d in done if d["marks"] or d["imported"] or d["lost"] or d["outside"] or d["said"]
        ],
    }


def _finished(folder: Path) -> set[Path]:
    """Return the files that store finished work: results, records and manifests."""
    return {p for p in folder.rglob("*") if p.name.endswith(KEPT) and not p.is_symlink() and p.is_file()}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Count the outcomes of attempts by kind of container."""
    from studies.common.malicious.ground import KINDS as ENDS, REFUSED, TRACEBACK, UNNAMED

    def of(key: str, kind: str = "") -> int:
        return sum(
            c["result"].get(key, c["result"]["kinds"].get(key, 0))
            for c in cases
            if kind in ("", c["case"]["what"])
        )

    least = 300 if len(cases) > len(KINDS) else 1
    none = {
        "marks left by a payload": "marks",
        "folders whose commands changed something outside the folder": "outside",
        "folders that lost finished work": "lost",
        "attempts that ended in a traceback": TRACEBACK,
        "attempts that were refused without naming a file": UNNAMED,
    }
    rows = [[word, *(of(word, kind) for kind in KINDS), of(word)] for word in ("folders", "attempts", *ENDS)]
    return {
        "verdicts": [
            verdict("fuzzed folders", of("folders"), f"≥ {least}", of("folders") >= least),
            *(verdict(text, of(key), "0", of(key) == 0) for text, key in none.items()),
            verdict("attempts that were refused by name", of(REFUSED), "≥ 1", of(REFUSED) > 0),
        ],
        "table": {"head": ["outcome of attempts", *KINDS, "all"], "rows": rows},
    }


STUDY = Study(
    name="containers",
    claim="A folder of runs that was damaged, changed or assembled by hand runs no code, "
    "changes nothing outside it, loses no finished run, and is refused by name.",
    config={"folders": 25},
    cases=[{"what": kind, "seed": seed} for seed in (1, 2, 3) for kind in KINDS],
    run=run,
    summarise=summarise,
    short_cases=[{"what": kind, "seed": 1} for kind in KINDS],
    short_config={"folders": 3},
)

if __name__ == "__main__":
    STUDY.main()
