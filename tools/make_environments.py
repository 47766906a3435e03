"""Write the pages on `gymnasium.make("ecs_eco/…")` environments to docs/reference/environments.

Each world has a page with observations, actions, rewards and the end of episodes. --check only compares.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ecs_eco import World
from ecs_eco.config import WorldConfig, load
from ecs_eco.nervous.external import External
from ecs_eco.record.dictionary import means_in
from ecs_eco.rl.registration import ENVIRONMENTS, STEPS
from ecs_eco.rl.spaces import action_space, observation_space

PAGES = Path(__file__).parents[1] / "docs" / "reference" / "environments"
NOTE = "<!-- Written by tools/make_environments.py from the world files: change those, not this page. -->"
INDEX = f"""# Environments

{NOTE}

On these pages you can look up the observations, actions and rewards of the Gymnasium environments,
which are species in shipped worlds.

```python
import gymnasium
import ecs_eco.rl  # registers the environments

env = gymnasium.make("ecs_eco/Deer-v0")  # the life of one deer
envs = gymnasium.make_vec("ecs_eco/Deer-v0", num_envs=16)  # 16 deer of one world
x, info = env.reset(seed=1)
x, reward, terminated, truncated, info = env.step(env.action_space.sample())
```

To control any other species, use `ecs_eco.rl.body(world, species)`, `slots` or `parallel_env`
([bring your own learner](../../how-to/bring_your_own_learner.md)). All other organisms, including other members
of the species, follow the world's policies.

"""


def pages() -> dict[str, str]:
    """Return the pages' text by name."""
    worlds: dict[str, list[tuple[str, str]]] = {}
    for name, (world, species) in ENVIRONMENTS.items():
        worlds.setdefault(world, []).append((name, species))
    rows, out = [], {}
    for world, entries in worlds.items():
        config = load(world)
        doors = [(name, _door(config, species)) for name, species in entries]
        out[f"{world}.md"] = (
            "\n\n".join(
                [
                    f"# {config.title or config.name}",
                    NOTE,
                    "On this page you can look up the observations, actions and rewards of these environments.",
                    f"All processes and parameters of this world: [ODD description](../odd/{world}.md).",
                    *(_environment(name, door, config) for name, door in doors),
                ]
            )
            + "\n"
        )
        rows += [
            f"| [ecs_eco/{name}]({world}.md) | {config.title or config.name} | {door.species} | "
            f"{len(door.channels)} numbers | {_actions(door)} |"
            for name, door in doors
        ]
    head = "| environment | world | species | observation | action |\n|---|---|---|---|---|\n"
    table = head + "\n".join(rows)
    tree = "```{toctree}\n:hidden:\n\n" + "\n".join(name.removesuffix(".md") for name in out) + "\n```\n"
    return {"index.md": f"{INDEX}{table}\n\n{tree}", **out}


def _environment(name: str, door: External, config: WorldConfig) -> str:
    """Return one environment's section."""
    species = config.species[door.species]
    happiness = species.happiness
    assert happiness is not None
    told = (
        happiness.formula
        or " + ".join(f"{w:g} × {n}" for n, w in happiness.weights.items())
        or "a custom function"
    )
    limits = [
        end for one in species.lethal for end in ((one.cause_below, one.min), (one.cause_above, one.max))
    ]
    causes = [cause for cause, end in limits if end is not None]
    eaters = [
        f"eaten by {other}"
        for other, one in config.species.items()
        if any(diet.eats == door.species for diet in one.diet)
    ]
    deaths, space = ", ".join(dict.fromkeys([*causes, *eaters])), observation_space(species, config.dims)
    ends = zip(door.channels, space.low.tolist(), space.high.tolist(), strict=True)
    observed = "\n".join(
        f"| {i} | `{channel}` | {_number(low)} | {_number(high)} |"
        for i, (channel, low, high) in enumerate(ends)
    )
    chosen = "\n".join(
        f"| {i} | `{group}` | {_options(door, i, names)} |"
        for i, (group, names) in enumerate(door.options.items())
    )
    return f"""## ecs_eco/{name}

This environment is the life of one {door.species}: `gymnasium.make("ecs_eco/{name}")`.

**Observations**, `{type(space).__name__}({space.shape[0]},)`, float32

| | channel | minimum | maximum |
|---|---|---|---|
{observed}

**Actions**, `{_actions(door)}`

| | group | options |
|---|---|---|
{chosen}

**Reward.** The reward is the change in happiness since the last tick.
Happiness is `{told}`{means_in(told, species)}; it is at least {happiness.minimum:g}.
At death, happiness falls to {happiness.minimum:g}.

**An episode ends** with death (terminated): {deaths or "no cause of death"}.
It is truncated after {STEPS:,} steps, and at tick {config.ticks:,} of its world.
A tick is {config.dt:g} s."""


def _door(config: WorldConfig, species: str) -> External:
    return External(World.from_config(config, populate=False, record=False, learn=False), species)


def _actions(door: External) -> str:
    return str(action_space(door.options, door.low, door.high)).replace(" ", ", ").replace(",,", ",")


def _options(door: External, i: int, names: tuple[str, ...]) -> str:
    if not names:
        return f"{door.low[i]:g} … {door.high[i]:g}"
    return ", ".join(f"{k} `{name}`" for k, name in enumerate(names))


def _number(value: float) -> str:
    return {float("inf"): "∞", float("-inf"): "−∞"}.get(value, f"{round(value, 3):g}")


def main() -> int:
    """Write or compare the pages."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n")[0])
    parser.add_argument("--check", action="store_true", help="only compare")
    check = parser.parse_args().check
    wanted = pages()
    PAGES.mkdir(exist_ok=True)
    stale = [
        name
        for name, text in wanted.items()
        if not (PAGES / name).is_file() or (PAGES / name).read_text(encoding="utf-8") != text
    ]
    stale += [path.name for path in PAGES.glob("*.md") if path.name not in wanted]
    if check:
        for name in stale:
            print(
                f"docs/reference/environments/{name} is out of date: run python tools/make_environments.py",
                file=sys.stderr,
            )
        return bool(stale)
    for name, text in wanted.items():
        (PAGES / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
