"""A world that is interrupted within a tick, by any means, is intact or refuses to continue; an earlier copy
ends with the same bytes as an uninterrupted run."""

import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.nervous.sensors.sense import Sense
from studies.common.runs import small
from studies.common.study import Study, verdict

KINDS = (
    "Ctrl-C",
    "two Ctrl-C",
    "exception in a signal handler",
    "exception in a system",
    "exception in a sensor",
)


class Interrupted(Exception):
    """The exception that an interruption raises within a tick."""


def fail(*_: Any) -> None:
    """Raise the interruption."""
    raise Interrupted


def press() -> None:
    """Press Ctrl-C."""
    os.kill(os.getpid(), signal.SIGINT)


def trip(world: Any, rng: np.random.Generator, ticks: int) -> None:
    """Add a system that fails in a random phase of a random tick."""
    from ecs_eco.engine.phases import PHASES

    system, at = world.trips[PHASES[rng.integers(len(PHASES))]], int(rng.integers(world.tick, ticks))
    system.process = lambda *_: fail() if world.tick == at else None


def blind(world: Any, rng: np.random.Generator, ticks: int) -> None:
    """Make a sensor fail at every reading, starting at a random tick."""
    able = [
        t.species.nerves
        for t in world.tables.values()
        if t.species.nerves is not None and t.species.nerves.senses
    ]
    nerves, at = able[rng.integers(len(able))], int(rng.integers(world.tick, ticks))
    i = int(rng.integers(len(nerves.senses)))
    sense, width = nerves.senses[i]
    nerves.senses[i] = (
        Sense(lambda world, *rest: fail() if world.tick >= at else sense(world, *rest)),
        width,
    )


def interrupt(
    kind: str, world: Any, rng: np.random.Generator, ticks: int, lasting: float
) -> Callable[[], None]:
    """Schedule an interruption of a world's run, which lasts about `lasting` seconds; return a function that
    cancels it."""
    if kind == "exception in a system":
        trip(world, rng, ticks)
    elif kind == "exception in a sensor":
        blind(world, rng, ticks)
    elif kind == "exception in a signal handler":
        before = signal.signal(signal.SIGALRM, fail)
        signal.setitimer(signal.ITIMER_REAL, float(rng.uniform(1e-4, lasting)))
        return lambda: (
            signal.setitimer(signal.ITIMER_REAL, 0),  # type: ignore[func-returns-value]
            signal.signal(signal.SIGALRM, before),
        )
    else:
        timers = [threading.Timer(float(rng.uniform(0, lasting)), press)]
        if kind == "two Ctrl-C":
            timers.append(threading.Timer(timers[0].interval + float(rng.uniform(0, 0.002)), press))
        for timer in timers:
            timer.start()
        return lambda: [
            (timer.cancel(), timer.join())  # type: ignore[func-returns-value]
            for timer in timers
        ]
    return lambda: None


def build(world: dict[str, Any], seed: int) -> Any:
    """Return a world that learns, with an idle system in each phase."""
    from ecs_eco import World
    from ecs_eco.engine.phases import PHASES

    made = World.from_config(world, seed=seed, policies="untrained", learn=True)
    idle(made, PHASES)
    return made


def idle(world: Any, phases: Any) -> None:
    """Add the idle systems."""
    from ecs_eco import System

    world.trips = {
        phase: world.add_system(type(f"In{phase.title()}", (System,), {"process": lambda *_: None})(), phase)
        for phase in phases
    }


def refuses(world: Any, folder: Path) -> bool:
    """Return whether a world refuses to be run, saved, recorded, copied or hashed, and leaves no files
    behind."""
    from ecs_eco.engine.errors import UnfinishedTick
    from ecs_eco.record import Recorder

    asked = (
        lambda: world.run(1),
        lambda: world.save(folder / "w.safetensors"),
        lambda: Recorder(world),
        world.copy,
        world.digest,
    )
    for ask in asked:
        try:
            ask()
        except UnfinishedTick:
            continue
        return False
    return not list(folder.iterdir()) and all(uid > 0 for uid, *_ in world.each())


def end_of(world: Any, ticks: int) -> str:
    """Run a world until a tick; return its digest."""
    return world.run(ticks - world.tick).digest()


def once(
    kind: str,
    config: dict[str, Any],
    case: dict[str, Any],
    rng: np.random.Generator,
    peace: list[str],
    lasting: float,
) -> str:
    """Interrupt one world; return the outcome: "whole", "refusing", "early" if the run had already ended,
    or a description of the error."""
    from ecs_eco.engine.phases import PHASES

    ticks = config["ticks"]
    world = build(small(case["world"], config["share"], case["brains"]), case["seed"])
    world.run(int(rng.integers(ticks // 2)))
    before = world.copy(prepare=lambda w: idle(w, PHASES))
    off = interrupt(kind, world, rng, ticks, lasting * (ticks - world.tick) / ticks)
    try:
        world.run(ticks - world.tick)
        return "early"
    except (Interrupted, KeyboardInterrupt):
        pass
    finally:
        off()
    if end_of(before, ticks) != peace[ticks]:
        return "the earlier copy ended differently"
    with tempfile.TemporaryDirectory() as place:
        if world.underway is not None:
            return "refusing" if refuses(world, Path(place)) else "continued after stopping mid-tick"
        if world.digest() != peace[world.tick]:
            return "stopped mid-tick without reporting it"
        again = type(world).restore(
            world.save(Path(place) / "w.safetensors"), prepare=lambda w: idle(w, PHASES)
        )
        return "whole" if end_of(again, ticks) == peace[ticks] else "ended differently after saving"


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Interrupt worlds repeatedly by one method; compare the remaining state with that of an uninterrupted
    run."""
    # shells make background processes ignore Ctrl-C
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return {"became": became(config, case)}
    finally:
        signal.signal(signal.SIGINT, before)


def became(config: dict[str, Any], case: dict[str, Any]) -> dict[str, int]:
    """Count the outcomes of one case's worlds."""
    rng, ticks = np.random.default_rng(case["seed"] + 100 * KINDS.index(case["kind"])), config["ticks"]
    calm = build(small(case["world"], config["share"], case["brains"]), case["seed"])
    peace = [calm.digest(), *(calm.run(1).digest() for _ in range(ticks))]
    calm = build(small(case["world"], config["share"], case["brains"]), case["seed"])
    start = time.perf_counter()
    calm.run(ticks)
    lasting, outcomes = time.perf_counter() - start, []
    while (
        sum(what != "early" for what in outcomes) < config["interruptions"]
        and len(outcomes) < 10 * config["interruptions"]
    ):
        try:
            outcomes.append(once(case["kind"], config, case, rng, peace, lasting))
        except (Interrupted, KeyboardInterrupt):  # after the end of the run
            outcomes.append("early")
    return {what: outcomes.count(what) for what in sorted(set(outcomes))}


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Count the outcomes, by kind of interruption."""
    by_kind = [(c["case"]["kind"], c["result"]["became"]) for c in cases]
    every = sum(n for _, counts in by_kind for what, n in counts.items() if what != "early")
    good = {what: sum(counts.get(what, 0) for _, counts in by_kind) for what in ("whole", "refusing")}
    wrong = every - sum(good.values())
    rows = []
    for kind in KINDS:
        counts = [counts for k, counts in by_kind if k == kind]
        if counts:
            whole, refusing = (sum(c.get(what, 0) for c in counts) for what in ("whole", "refusing"))
            n = sum(n for c in counts for what, n in c.items() if what != "early")
            rows.append([kind, n, whole, refusing, n - whole - refusing])
    return {
        "verdicts": [
            verdict("interruptions of a running world", every, "100 or more", every >= 100),
            verdict(
                "worlds that were neither intact (the same bytes as an uninterrupted run, "
                "also after saving and resuming) nor refused to be run, saved, "
                "recorded, copied and hashed; or whose earlier copy ended differently",
                wrong,
                "0",
                wrong == 0,
            ),
        ],
        "table": {
            "head": ["interrupted by", "interruptions", "intact", "refused to continue", "neither"],
            "rows": rows,
        },
    }


STUDY = Study(
    name="interruptions",
    claim="A world that is interrupted within a tick, by any means, is intact or refuses to continue.",
    config={"ticks": 40, "share": 0.1, "interruptions": 10},
    cases=[
        {"kind": kind, "world": "predator-prey", "brains": brains, "seed": 5}
        for kind in KINDS
        for brains in ("shared", "individual")
    ],
    run=run,
    summarise=summarise,
    short_config={"ticks": 12, "interruptions": 2},
    short_cases=[{"kind": kind, "world": "predator-prey", "brains": "shared", "seed": 5} for kind in KINDS],
)

if __name__ == "__main__":
    STUDY.main()
