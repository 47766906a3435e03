"""KL divergence of an earlier shared policy from the current one, which measures how far learning moved
it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

WINDOW = 1000  # [ticks] over which a policy's change is measured


def log_chances(logits: np.ndarray, groups: Sequence[int]) -> np.ndarray:
    """Return the options' log probabilities from logits f[n, sum of groups]: f64 of the same shape."""
    parts = np.split(np.asarray(logits, float), np.cumsum(groups)[:-1], axis=1)
    parts = [part - part.max(1, keepdims=True) for part in parts]
    return np.concatenate([part - np.log(np.exp(part).sum(1, keepdims=True)) for part in parts], axis=1)


def divergence(before: np.ndarray, after: np.ndarray, groups: Sequence[int]) -> float:
    """Return the mean over observations of KL(before ‖ after) [nats], summed over the independently drawn
    groups of actions; NaN if there are no observations."""
    if not len(before):
        return float("nan")
    p, q = log_chances(before, groups), log_chances(after, groups)
    return float((np.exp(p) * (p - q)).sum(1).mean())


class Policies:
    """A snapshot of a world's shared policies, to compare with later ones."""

    def __init__(self, world: Any) -> None:
        nerves = {name: getattr(table.species, "nerves", None) for name, table in world.tables.items()}
        self.world = world
        self.modules = {name: world.policy(name) for name, own in nerves.items() if own and own.brain}

    def moved(self) -> dict[str, float | None]:
        """Return, for each species, KL(then ‖ now) [nats] on the current observations of living animals; None
        if no animals are alive."""
        return {name: self._moved(name, module) for name, module in self.modules.items()}

    def _moved(self, name: str, module: Any) -> float | None:
        import torch

        from ecs_eco.components import Sensor

        table = self.world.tables[name]
        if not table.n:
            return None
        seen = table[Sensor].readings[table.by_uid()]
        seen = torch.from_numpy(seen[np.isfinite(seen).all(1)])  # newborns have not sensed yet
        with torch.no_grad():
            before, after = (net(seen)[0].numpy() for net in (module, self.world.policy(name)))
        return divergence(before, after, table.species.nerves.brain.groups)


class Crowd:
    """A snapshot of up to `most` individual policies per species, to compare their mean option probabilities
    with those of as many later policies. Because the later sample contains different animals, the mean moves
    a little even without learning."""

    def __init__(self, world: Any, species: Sequence[str], most: int = 40) -> None:
        self.world, self.species, self.most = world, tuple(species), most
        self.modules = {name: self._some(name) for name in self.species}

    def _some(self, name: str) -> list[Any]:
        """Return up to `most` networks, evenly spaced by uid."""
        table = self.world.tables[name]
        rows = table.by_uid()
        picked = rows[np.linspace(0, len(rows) - 1, min(self.most, len(rows))).astype(int)]
        return [self.world.policy(name, int(uid)) for uid in table.uid[picked]]

    def moved(self) -> dict[str, float | None]:
        """Return, for each species, KL(then ‖ now) [nats] of mean probabilities on the current observations
        of living animals."""
        return {name: self._moved(name) for name in self.species}

    def _moved(self, name: str) -> float | None:
        import torch

        from ecs_eco.components import Sensor

        table = self.world.tables[name]
        if not table.n:
            return None
        seen, groups = table[Sensor].readings[table.by_uid()], table.species.nerves.individuals.groups
        seen = torch.from_numpy(seen[np.isfinite(seen).all(1)])
        means = []
        with torch.no_grad():
            for networks in (self.modules[name], self._some(name)):
                chances = [np.exp(log_chances(net(seen)[0].numpy(), groups)) for net in networks]
                means.append(np.log(np.mean(chances, axis=0)))
        return divergence(means[0], means[1], groups)


def rates(moved: Mapping[str, float | None], ticks: int) -> dict[str, float | None]:
    """Return the KL divergences per 1,000 ticks."""
    return {name: None if nats is None else 1000 * nats / max(1, ticks) for name, nats in moved.items()}


def life(
    living: Any, folder: Path, seed: int, ticks: int, mortal: Sequence[str]
) -> tuple[Any, dict[str, list[float]]]:
    """Run a world for `ticks` ticks, or until one of the `mortal` species is extinct (checked every 50
    ticks). Return it and how far the policy of each learning `mortal` species moved in each complete window
    [nats of KL, then ‖ now]."""
    from ecs_eco import World

    world = World.from_config(living, seed=seed, policies=str(folder))
    learners = [s for s in mortal if living.species[s].policy.learn]
    alone = any(living.species[s].policy.kind == "individual" for s in mortal)
    moved: dict[str, list[float]] = {s: [] for s in learners}
    before = Crowd(world, learners) if alone else Policies(world)
    while world.tick < ticks and all(world.tables[s].n for s in mortal):
        world.run(min(50, ticks - world.tick))
        if world.tick % WINDOW == 0:
            now = before.moved()
            for s in learners:
                if now[s] is not None:
                    moved[s].append(float(now[s] or 0.0))
            before = Crowd(world, learners) if alone else Policies(world)
    return world, moved
