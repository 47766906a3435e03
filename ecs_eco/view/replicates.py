"""A change in many pairs of worlds: `ecs-eco compare` in the background, its progress and its outcome."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.page import number
from ecs_eco.analysis.runs import Series, load_series
from ecs_eco.engine.errors import RecordingError
from ecs_eco.engine.processes import python
from ecs_eco.record.seal import read_manifest
from ecs_eco.view.branch import Start, by_hand, check, dated, planned_and, start_of
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from ecs_eco.view.source import Message, is_whole, short

RUN = "from ecs_eco.cli import main; main()"
SUSTAINED = 50  # ticks for which an interval must exclude 0 to count as a difference


def command_of(
    start: Start, acts: Sequence[Message], tick: int, change: Message, seeds: int, ticks: int
) -> list[str]:
    """Return the arguments of `ecs-eco` that compare a world with and without a change at a tick, for seeds
    from 1. Both arms repeat the manual interventions `acts`."""
    words, options = [], iter(start.words)
    for word in options:
        if word in ("--seed", "--ticks", "--out"):
            next(options)
        elif word in ("--learn", "--no-learn"):
            raise ValueError(f"pairs: {word} applies to one run; set policy.learn in the world file instead")
        else:
            words.append("compare" if word == "run" and "compare" not in words else word)
    if acts:
        words += ["--set", planned_and(start, acts)]
    treated = planned_and(start, [*acts, dated(change, tick)])
    return [*words, "--treatment", treated, "--seeds", str(seeds), "--ticks", str(ticks)]


def begin(first: Live | Replay, start: Start | None, request: Message) -> Replicates:
    """Begin to run the pairs of a request, {"tick", "what", "seeds", "ticks"}; tick None is the displayed one.
    Raises ValueError or ConfigError for a request that cannot be run."""
    tick, change, seeds, ticks = (request.get(key) for key in ("tick", "what", "seeds", "ticks"))
    tick = first.tick + (not isinstance(first, Live)) if tick is None else tick
    if not (change and is_whole(tick) and is_whole(seeds, 2, 1001) and is_whole(ticks, tick + 1)):
        raise ValueError(
            f"pairs: what = {short(change)}, tick = {short(tick)}, seeds = {short(seeds)}, ticks = "
            f"{short(ticks)}; expected a change, 2 to 1,000 seeds, and an end after the tick"
        )
    acts: list[Message] = []
    if isinstance(first, Live):
        check(first.world, change)
        acts = by_hand(first.world, 0, tick)
    else:
        start = start_of(first.recording.manifest)
    if start is None:
        raise ValueError(
            "pairs: no command started this world, or it was changed by hand; run them with ecs-eco compare"
        )
    return Replicates(command_of(start, acts, tick, change, seeds, ticks), seeds)


class Replicates:
    """A comparison in a process with lower priority and in a temporary folder, which end with this object."""

    def __init__(self, words: Sequence[str], seeds: int) -> None:
        self.command, self.seeds = shlex.join(["ecs-eco", *words]), seeds
        self.finished = set[Path]()
        self.place = Path(tempfile.mkdtemp(prefix="ecs-eco-pairs-"))
        with (self.place / "errors").open("w") as errors:
            self.process = subprocess.Popen(
                python(RUN, *words, "--out", str(self.place / "out"), "--quiet"),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=errors,
                start_new_session=True,
            )
        with suppress(OSError, AttributeError):  # lets the displayed world run first
            os.setpriority(os.PRIO_PROCESS, self.process.pid, 10)
        self.close = weakref.finalize(self, _end, self.process, self.place)

    def state(self) -> Message:
        """Return {"done", "of"}, and once it has ended, "lines" and "html", or "problem"."""
        now = {"kind": "pairs", "command": self.command, "done": self._done(), "of": 2 * self.seeds}
        if self.process.poll() is None:
            return now
        if self.process.returncode:
            lines = (self.place / "errors").read_text(encoding="utf-8", errors="replace").strip()
            return now | {"problem": lines or f"ended with exit status {self.process.returncode}"}
        out = self.place / "out"
        result = json.loads((out / "compare.json").read_text(encoding="utf-8"))
        figure = (out / "figures" / "numbers.svg").read_text(encoding="utf-8")
        html = (out / "compare.html").read_text(encoding="utf-8")
        # the runs of the unchanged world and of the changed one, by seed
        arms = sorted((path.parent for path in out.glob("*/seed-1")), key=lambda arm: arm.name != "world")
        runs = [[arm / f"seed-{seed}" for seed in range(1, self.seeds + 1)] for arm in arms]
        return now | {"lines": lines_of(result, runs), "figure": figure, "html": html}

    def _done(self) -> int:
        for folder in {*(self.place / "out").glob("*/seed-*")} - self.finished:
            with suppress(RecordingError, OSError):
                if read_manifest(folder).get("finished"):
                    self.finished.add(folder)
        return len(self.finished)


def _end(process: subprocess.Popen[bytes], place: Path) -> None:
    if process.poll() is None:
        with suppress(ProcessLookupError, AttributeError):  # Windows has no process groups
            os.killpg(process.pid, signal.SIGKILL)
        process.kill()
        process.wait()
    shutil.rmtree(place, ignore_errors=True)


def lines_of(result: Mapping[str, Any], runs: Sequence[Sequence[Path]]) -> list[str]:
    """Return sentences on what a change did: persistence, mean numbers, and which species differed first."""
    (arm, effects), *_ = result["effects"].items()
    lines = [f"Without the change: {result['opening']['world']}", f"With it: {result['opening'][arm]}"]
    for species, of in effects["per_species"].items():
        mean, low, high = of["mean_number"]
        clear = "" if low > 0 or high < 0 else "; no clear effect"
        ends = f"95% interval {number(low)} to {number(high)}"
        lines.append(f"{species}: mean number {'+' if mean > 0 else ''}{number(mean)} ({ends}){clear}.")
    first = first_differences(*([load_series(run) for run in arm] for arm in runs))
    told = ", ".join(f"{species} (tick {tick:,})" for species, tick in first.items())
    rule = (
        f"From these ticks on, the 95% interval of the difference excludes 0 for at least {SUSTAINED} ticks."
    )
    return [
        *lines,
        f"Species that differ, with their first ticks: {told}. {rule}"
        if told
        else "No species differs clearly at any time.",
    ]


def first_differences(one: Sequence[Series], other: Sequence[Series]) -> dict[str, int]:
    """Return the tick from which each species differs clearly between series with equal seeds, earliest first."""
    from scipy.stats import t

    length = min(len(series.ticks) for series in (*one, *other))
    first = {}
    for species in one[0].species:
        gaps = np.array(
            [b.of(species)[:length] - a.of(species)[:length] for a, b in zip(one, other, strict=True)]
        )
        error = t.ppf(0.975, len(gaps) - 1) * gaps.std(0, ddof=1) / len(gaps) ** 0.5
        clear = np.abs(gaps.mean(0)) > error
        whole = np.convolve(clear, np.ones(min(SUSTAINED, length)), "valid") >= min(SUSTAINED, length)
        if whole.any():
            first[species] = int(one[0].ticks[whole.argmax()])
    return dict(sorted(first.items(), key=lambda item: item[1]))
