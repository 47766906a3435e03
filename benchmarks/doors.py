"""Measure agent-steps per second through each interface to a species, and compare them with MAgent2 through
PettingZoo.

    python benchmarks/doors.py [--agents 500] [--steps 200] [--rounds 5]

Agents act at random. `external` passes arrays, `slots` is a Gymnasium vector of all agents, and
`parallel_env` uses PettingZoo's dicts; `within` is the same world without an interface, with random choices.
MAgent2's battle, with about as many agents, is stepped through its parallel environment in the same run: each
round uses every interface once, and the median over rounds counts. Times are processor seconds of one thread.
Needs the `rl` extra; MAgent2 is skipped if it is not installed. The worlds differ: a deer senses 14 numbers and
an MAgent2 agent 845.
"""

import argparse
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import numpy as np

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.rl import parallel_env, slots

Steps = Iterator[int]  # number of agents in each step


def world_of(agents: int) -> Any:
    """Return a world of grass and deer without wolves, in which population sizes are held constant."""
    side = 240.0 * (agents / 700) ** 0.5
    return load(
        "predator_prey",
        {
            "space.size": [side, side],
            "species.deer.count": agents,
            "species.grass.count": int(4300 * agents / 700),
            "species.wolf.count": 1,
            "ticks": 10**6,
        },
    )


def within(config: Any) -> Steps:
    """Step the world without an interface."""
    world = World.from_config(config, policies="random", training=True, record=False)
    while True:
        world.run(1)
        yield world.tables["deer"].n


def external(config: Any) -> Steps:
    """Step the world with arrays in and out."""
    world = World.from_config(config, policies="random", training=True, record=False)
    door, draw = world.external("deer"), np.random.default_rng(1)
    while True:
        n = len(door.observe().uid)
        door.act(draw.integers(0, 3, (n, 2)))
        yield n


def vector(config: Any) -> Steps:
    """Step a Gymnasium vector of slots."""
    n = config.species["deer"].count
    envs, draw = slots(config, "deer", n, policies="random", training=True), np.random.default_rng(1)
    envs.reset(seed=1)
    while True:
        envs.step(draw.integers(0, 3, (n, 2)))
        yield n


def dicts(config: Any) -> Steps:
    """Step PettingZoo's dicts."""
    env, draw = parallel_env(config, "deer", policies="random", training=True), np.random.default_rng(1)
    env.reset(seed=1)
    while True:
        n = len(env.agents)
        env.step(dict(zip(env.agents, draw.integers(0, 3, (n, 2)), strict=True)))
        yield n


def magent(agents: int) -> Steps:
    """Step MAgent2's battle through PettingZoo, restarting it when most agents are dead."""
    from magent2.environments import battle_v4

    env, draw = battle_v4.parallel_env(map_size=_map(agents), max_cycles=10**6), np.random.default_rng(1)
    while True:
        env.reset(seed=1)
        first = len(env.agents)
        while len(env.agents) > first / 2:
            n = len(env.agents)
            env.step(dict(zip(env.agents, draw.integers(0, 21, n), strict=True)))
            yield n


def _map(agents: int) -> int:
    """Return the map's side for about this number of agents: the map size determines the size of both
    armies."""
    from magent2.environments import battle_v4

    for side in range(16, 200, 4):
        env = battle_v4.parallel_env(map_size=side)
        env.reset(seed=1)
        if len(env.agents) >= agents:
            return side
    raise ValueError(f"--agents {agents}: no map of MAgent2's battle has this number of agents")


def speed(door: Steps, steps: int) -> float:
    """Return agent-steps per second of this process's processor time, which is not affected by other work on
    the machine."""
    start, done = time.process_time(), 0
    for _ in range(steps):
        done += next(door)
    return done / (time.process_time() - start)


def doors(agents: int) -> dict[str, Steps]:
    """Return all interfaces after a warm-up."""
    config = world_of(agents)
    makers: dict[str, Callable[[], Steps]] = {
        "built in, random actions": lambda: within(config),
        "external": lambda: external(config),
        "slots": lambda: vector(config),
        "parallel_env": lambda: dicts(config),
    }
    try:
        import magent2  # noqa: F401

        makers["MAgent2, parallel_env"] = lambda: magent(agents)
    except ModuleNotFoundError:
        print("MAgent2 is not installed: skipped")
    made = {name: make() for name, make in makers.items()}
    for door in made.values():
        speed(door, 5)
    return made


def main() -> None:
    """Time all interfaces in turn."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n")[0])
    parser.add_argument("--agents", type=int, default=500)
    parser.add_argument("--steps", type=int, default=200, help="steps of each interface in a round")
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    opened = doors(asked.agents)
    rounds = [{name: speed(door, asked.steps) for name, door in opened.items()} for _ in range(asked.rounds)]
    rows = []
    for name in opened:
        ratio = [one[name] / one["parallel_env"] for one in rounds]
        rows.append(
            {
                "interface": name,
                "agent-steps/s": round(statistics.median(one[name] for one in rounds)),
                "relative to parallel_env": round(statistics.median(ratio), 2),
                "range": f"{min(ratio):.2f} to {max(ratio):.2f}",
            }
        )
    _bench.save(
        "doors",
        "The interfaces through which outside code controls a species",
        rows,
        {"agents": asked.agents, "steps": asked.steps, "rounds": asked.rounds},
    )


if __name__ == "__main__":
    main()
