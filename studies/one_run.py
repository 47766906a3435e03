"""If two processes claim the same folder, one gets it and the other is refused or gets a separate folder;
files from other runs are refused."""

import json
import os
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.foreign.ground import LIVES, make
from studies.common.foreign.kinds import KINDS
from studies.common.foreign.refusal import refused
from studies.common.runs import summary
from studies.common.study import Study, verdict

REFUSED = 2  # exit code
KILLED = -signal.SIGKILL
IN_USE = "is in use by"  # part of the error of `ecs_eco.record.claim.FolderInUse`
SEEDS = (1, 2)


def run_words(config: dict[str, Any], seed: int) -> list[str]:
    """Return a command that runs this study's world."""
    changes = [word for key, value in LIVES.items() for word in ("--set", f"{key}={value}")]
    every = ["--checkpoint-every", str(config["checkpoint_every"])]
    return [
        "run",
        "predator-prey",
        *changes,
        "--ticks",
        str(config["ticks"]),
        "--seed",
        str(seed),
        *every,
        "--no-report",
        "--quiet",
    ]


def resume_words(out: str, config: dict[str, Any]) -> list[str]:
    """Return a command that resumes a run and completes it."""
    return ["resume", out, "--until", str(config["ticks"]), "--no-report", "--quiet"]


def together(
    place: Path, commands: list[list[str]], kill: tuple[int, float] | None = None
) -> list[tuple[int, str]]:
    """Start commands at the same time, each in a separate process, and wait for them; return their exit codes
    and output.

    `kill` gives the command to kill, and the delay in seconds.
    """
    gate, key = os.pipe()
    children = [_start(words, gate, key, place / f"said-{i}") for i, words in enumerate(commands)]
    os.close(gate)
    os.close(key)  # opens the gate
    if kill is not None:
        time.sleep(kill[1])
        os.kill(children[kill[0]], signal.SIGKILL)
    codes = [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children]
    return [(code, (place / f"said-{i}").read_text(encoding="utf-8")) for i, code in enumerate(codes)]


def apart(work: Callable[[], Any], place: Path) -> Any:
    """Do some work in a separate process, because threads that it starts would be lost in forks; return its
    result as JSON."""
    child = os.fork()
    if not child:
        try:
            (place / "answer.json").write_text(json.dumps(work()), encoding="utf-8")
        except BaseException:
            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    if code := os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]):
        raise RuntimeError(f"the separate process ended with exit code {code}")
    return json.loads((place / "answer.json").read_text(encoding="utf-8"))


def _start(words: list[str], gate: int, key: int, log: Path) -> int:
    """Fork a process that waits at the gate and then becomes the command, in the folder that contains `said`;
    return its id."""
    child = os.fork()
    if child:
        return child
    code = 1
    try:
        os.close(key)
        os.chdir(log.parent)
        file = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, 1)
        os.dup2(file, 2)
        os.read(gate, 1)
        from ecs_eco.cli import app

        app(words, prog_name="ecs-eco")
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


# --- pairs; each returns the fault ("" if none), and whether the two processes met during a write


Pair = Callable[[Path, dict[str, Any], np.random.Generator, dict[int, Any]], tuple[str, bool]]


def same_out(
    place: Path, config: dict[str, Any], rng: np.random.Generator, whole: dict[int, Any]
) -> tuple[str, bool]:
    """Run two seeds with the same folder name."""
    ended = together(place, [[*run_words(config, seed), "--out", "out"] for seed in SEEDS])
    wrong = _refused_but_one(ended)
    winner = next((seed for seed, (code, _) in zip(SEEDS, ended, strict=True) if code == 0), None)
    return wrong or _differs(place / "out", whole, winner), _met(ended)


def default_out(
    place: Path, config: dict[str, Any], rng: np.random.Generator, whole: dict[int, Any]
) -> tuple[str, bool]:
    """Run one seed twice without naming a folder."""
    seed = int(rng.choice(SEEDS))
    ended = together(place, [run_words(config, seed)] * 2)
    if [code for code, _ in ended] != [0, 0]:
        return f"ended with {[code for code, _ in ended]}: {ended[0][1]} {ended[1][1]}", False
    folders = sorted((place / "runs").iterdir())
    if [p.name for p in folders] != [f"predator-prey-{seed}", f"predator-prey-{seed}-2"]:
        return f"left {[p.name for p in folders]}", False
    named = all(sum(f"in runs/{p.name}\n" in text for _, text in ended) == 1 for p in folders)
    return (
        ""
        if named and not any(_differs(p, whole, seed) for p in folders)
        else "the folders differ from the reported outcome",
        True,
    )


def two_resumes(
    place: Path, config: dict[str, Any], rng: np.random.Generator, whole: dict[int, Any]
) -> tuple[str, bool]:
    """Resume a killed run in two processes."""
    seed = int(rng.choice(SEEDS))
    together(
        place, [[*run_words(config, seed), "--out", "out"]], (0, float(rng.uniform(0.1, config["longest"])))
    )
    if not (place / "out" / "manifest.json").exists():
        again = together(place, [[*run_words(config, seed), "--out", "out"]])
        return (
            ""
            if again[0][0] == 0 and not _differs(place / "out", whole, seed)
            else f"stranded: {again[0][1]}",
            False,
        )
    ended = together(place, [resume_words("out", config)] * 2)
    wrong = (
        ""
        if {code for code, _ in ended} <= {0, REFUSED} and 0 in {code for code, _ in ended}
        else f"ended with {ended}"
    )
    return wrong or _differs(place / "out", whole, seed), _met(ended)


def killed(
    place: Path, config: dict[str, Any], rng: np.random.Generator, whole: dict[int, Any]
) -> tuple[str, bool]:
    """Run two seeds in one folder and kill one of them; then repeat the command or resume."""
    when = (int(rng.integers(2)), float(rng.uniform(0.0, config["longest"])))
    ended = together(place, [[*run_words(config, seed), "--out", "out"] for seed in SEEDS], when)
    if any(code not in (0, REFUSED, KILLED) for code, _ in ended):
        return f"ended with {ended}", False
    seed = SEEDS[0]
    if (place / "out" / "manifest.json").exists():
        from ecs_eco.runs.run import read_manifest

        seed = read_manifest(place / "out")["seed"]
        again = together(place, [resume_words("out", config)])
    else:
        again = together(place, [[*run_words(config, seed), "--out", "out"]])
    return f"stranded: {again[0][1]}" if again[0][0] else _differs(place / "out", whole, seed), _met(ended)


PAIRS: dict[str, Pair] = {
    "same folder": same_out,
    "no folder named": default_out,
    "two resumes": two_resumes,
    "one of them killed": killed,
}


def _refused_but_one(ended: list[tuple[int, str]]) -> str:
    codes = sorted(code for code, _ in ended)
    if codes != [0, REFUSED]:
        return f"ended with {codes}: {ended[0][1]} {ended[1][1]}"
    text = next(text for code, text in ended if code == REFUSED)
    return (
        ""
        if "out" in text and any(part in text for part in (IN_USE, "is not empty", "is not an empty folder"))
        else f"refused without naming the folder: {text}"
    )


def _met(ended: list[tuple[int, str]]) -> bool:
    return any(IN_USE in text for _, text in ended)


def _differs(out: Path, whole: dict[int, Any], seed: int | None) -> str:
    """Return how a folder differs from a seed's complete run, ignoring half-written files."""
    if seed is None or not out.is_dir():
        return "nothing is left"
    if left := [p.name for p in out.rglob("*") if p.name.endswith((".tmp", ".lock"))]:
        return f"left behind: {left[0]}"
    return (
        ""
        if apart(lambda: summary(out), out.parent) == whole[seed]
        else f"{out.name} is not the run of seed {seed}"
    )


# --- the study


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Test pairs of one kind, or every kind of foreign file, each in a temporary folder."""
    rng = np.random.default_rng(case.get("seed", 0))
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        if case["pairs"] == "foreign files":
            return dict(apart(lambda: _foreign(place / "all", config["kinds"]), place))
        _warm()
        whole = {}
        for seed in SEEDS:
            (place / f"whole-{seed}").mkdir()
            ended = together(place / f"whole-{seed}", [[*run_words(config, seed), "--out", "out"]])
            assert ended[0][0] == 0, ended
            whole[seed] = apart(lambda out=place / f"whole-{seed}" / "out": summary(out), place)
        wrong, met = {}, 0
        for i in range(config["pairs"]):
            (place / str(i)).mkdir()
            text, together_ = PAIRS[case["pairs"]](place / str(i), config, rng, whole)
            met += together_
            if text:
                wrong[str(i)] = text
            shutil.rmtree(place / str(i))
        return {"tried": config["pairs"], "met": met, "wrong": wrong}


def _warm() -> None:
    """Import and compile everything that the commands need, without starting a thread, so that forked
    processes begin right at the critical point."""

    from ecs_eco import World
    from ecs_eco.config import load

    World.from_config(load("predator-prey", LIVES), record=False).run(2)


def _foreign(place: Path, kinds: int) -> dict[str, Any]:
    make(place / "whole")
    names = list(KINDS)[:kinds]
    wrong = {
        name: text for i, name in enumerate(names) if (text := refused(name, place / "whole", place / str(i)))
    }
    return {"tried": len(names), "wrong": wrong}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Count pairs that mixed or lost data, and kinds of foreign files that were accepted."""
    pairs = [c for c in cases if c["case"]["pairs"] in PAIRS]
    foreign = [c["result"] for c in cases if c["case"]["pairs"] not in PAIRS]
    tried, wrong = sum(c["result"]["tried"] for c in pairs), sum(len(c["result"]["wrong"]) for c in pairs)
    met, kinds = sum(c["result"]["met"] for c in pairs), sum(r["tried"] for r in foreign)
    taken = sum(len(r["wrong"]) for r in foreign)
    rows = []
    for name in PAIRS:
        of = [c["result"] for c in pairs if c["case"]["pairs"] == name]
        rows.append(
            [name, sum(r["tried"] for r in of), sum(r["met"] for r in of), sum(len(r["wrong"]) for r in of)]
        )
    return {
        "verdicts": [
            verdict("pairs of processes that use one folder", tried, "200 or more", tried >= 200),
            verdict(
                "of these, pairs in which one process found the other at work", met, "100 or more", met >= 100
            ),
            verdict(
                "pairs after which a folder contained a different run, a mixture or half a run",
                wrong,
                "0",
                wrong == 0,
            ),
            verdict(
                "kinds of foreign files in runs, comparisons, trainings and searches",
                kinds,
                "30 or more",
                kinds >= 30,
            ),
            verdict(
                "of these, kinds that were accepted, or refused without their name", taken, "0", taken == 0
            ),
        ],
        "table": {"head": ["pairs", "tried", "one found the other at work", "wrong"], "rows": rows},
    }


STUDY = Study(
    name="one_run",
    claim="A folder contains one run, even if several processes claim it, and a file of another run is "
    "refused by name.",
    config={"ticks": 16, "checkpoint_every": 4, "pairs": 25, "longest": 0.8, "kinds": 1000},
    cases=[{"pairs": name, "seed": seed} for name in PAIRS for seed in (31, 32)]
    + [{"pairs": "foreign files"}],
    run=run,
    summarise=summarise,
    short_config={"ticks": 10, "pairs": 3, "kinds": 12, "longest": 0.5},
    short_cases=[{"pairs": name, "seed": 31} for name in PAIRS] + [{"pairs": "foreign files"}],
)

if __name__ == "__main__":
    STUDY.main()
