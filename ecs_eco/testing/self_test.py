"""Short runs of the shipped worlds that check that results are the same with two threads, from a checkpoint
and in the release."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

from ecs_eco.config import load
from ecs_eco.config.shipped import shipped
from ecs_eco.ecosystem import World
from ecs_eco.testing.target import Target

DIGESTS = Path(__file__).parent / "digests.json"
TICKS, SAVED, HORIZON, SEED = 40, 23, 16, 1  # two updates of learners; the checkpoint falls within a rollout


class Case(NamedTuple):
    """A shipped world, with or without learning."""

    world: str
    learn: bool

    @property
    def name(self) -> str:
        """The case's name in the digests of a release."""
        return f"{self.world}, {'learning' if self.learn else 'not learning'}"


class Outcome(NamedTuple):
    """Final digests of a case: with one thread, with two threads, and from a checkpoint."""

    case: Case
    digest: str
    two_threads: str
    resumed: str

    @property
    def holds(self) -> bool:
        """Whether all three digests are the same."""
        return self.digest == self.two_threads == self.resumed


def cases() -> list[Case]:
    """Return the cases: all shipped worlds, with and without learning."""
    return [Case(world, learn) for world in shipped() for learn in (False, True)]


def examine(case: Case) -> Outcome:
    """Run one case, which takes a few seconds."""
    config = _config(case, HORIZON)
    options: dict[str, Any] = {"seed": SEED, "learn": case.learn, "record": False}
    digest = World.from_config(config, threads=1, **options).run(TICKS).digest()
    with tempfile.TemporaryDirectory() as folder:
        world = World.from_config(config, threads=2, **options).run(SAVED)
        path = world.save(Path(folder) / "checkpoint")
        two_threads = world.run(TICKS - SAVED).digest()
        resumed = World.restore(path, threads=1, record=False).run(TICKS - SAVED).digest()
    return Outcome(case, digest, two_threads, resumed)


def examine_all(
    chosen: Iterable[Case], done: Callable[[int, int], None] = lambda done, total: None
) -> list[Outcome]:
    """Run the chosen cases; `done` is called with the number of finished cases and their total."""
    waiting = list(chosen)
    results: list[Outcome] = []
    for case in waiting:
        done(len(results), len(waiting))
        results.append(examine(case))
    done(len(results), len(waiting))
    return results


def short_world(case: Case, seed: int, horizon: int) -> World:
    """Return a case's world, in which learners learn every `horizon` ticks."""
    return World.from_config(_config(case, horizon), threads=1, seed=seed, learn=case.learn, record=False)


def _config(case: Case, horizon: int) -> Any:
    """Return the configuration, with rollouts short enough for policies to be updated within the test."""
    learners = [name for name, species in load(case.world).species.items() if species.policy.thinks]
    return load(case.world, [f"species.{name}.ppo.horizon={horizon}" for name in learners])


def released() -> dict[str, dict[str, str]]:
    """Return the digests from this release, by tested target and case."""
    release = json.loads(DIGESTS.read_text(encoding="utf-8"))
    return {name: part["digests"] for name, part in release["targets"].items()}


def differing(outcomes: Iterable[Outcome], target: Target) -> list[str] | None:
    """Return the names of the cases whose digests differ from the release; None for an untested target."""
    known = released().get(target.key)
    return None if known is None else [o.case.name for o in outcomes if o.digest != known.get(o.case.name)]
