"""The common task of `peers.py` in other frameworks, each in the style of its own documentation, and
different tasks for frameworks that cannot express it."""

import math
from typing import Any

import numpy as np
from peers_grazing import (
    BITE,
    CHANCE,
    COST,
    ENOUGH,
    GAIN,
    GIVEN,
    REACH,
    REGROWTH,
    SITE,
    SPEED,
    TURN,
    Model,
    side,
)


class Meadow:
    """Tufts on their sites, stored as an array, like the grass in these frameworks' own examples."""

    def __init__(self, size: float, rng: np.random.Generator) -> None:
        self.ripe, self.rng = np.ones((int(size / SITE),) * 2, bool), rng

    def bite(self, x: float, y: float) -> bool:
        """Return whether there is a tuft within BITE of a position, and remove it."""
        i, j = int(y / SITE) % len(self.ripe), int(x / SITE) % len(self.ripe)
        near = (x - (j + 0.5) * SITE) ** 2 + (y - (i + 0.5) * SITE) ** 2 < BITE * BITE
        if near and self.ripe[i, j]:
            self.ripe[i, j] = False
            return True
        return False

    def grow(self) -> None:
        """Grow tufts on empty sites."""
        self.ripe |= self.rng.random(self.ripe.shape) < REGROWTH


def away(heading: float, offset: Any) -> float:
    """Return the turn that leads away from a neighbor at a given offset."""
    left = math.cos(heading) * offset[1] - math.sin(heading) * offset[0]
    return -TURN if left > 0 else TURN


def live(one: Any, place: Any, meadow: Meadow, rng: np.random.Generator) -> bool:
    """Subtract the cost of the tick and eat at the agent's position; return whether the agent divides (the
    cost of dividing is then already subtracted)."""
    one.energy -= COST
    if meadow.bite(*place):
        one.energy = min(1.0, one.energy + GAIN)
    divides = one.energy >= ENOUGH and rng.random() < CHANCE
    one.energy -= GIVEN * divides
    return bool(divides)


def mesa(n: int, seed: int) -> Model:
    """Run the task in Mesa 3.5: agents in its continuous space, stepped by `shuffle_do`."""
    import warnings

    from mesa import Model as MesaModel
    from mesa.experimental.continuous_space import ContinuousSpace, ContinuousSpaceAgent

    warnings.simplefilter("ignore")

    class Grazer(ContinuousSpaceAgent):  # type: ignore[misc]
        """One grazer."""

        def __init__(self, model: Any, position: np.ndarray, energy: float) -> None:
            super().__init__(model.space, model)
            self.position, self.energy = position, energy
            self.heading = model.rng.uniform(0, 2 * math.pi)

        def step(self) -> None:
            """Look, turn, walk, eat, and divide or die."""
            others, distances = self.get_nearest_neighbors(k=1)
            if others and distances[0] < REACH:
                offset = self.space.calculate_difference_vector(self.position, [others[0]])[0]
                self.heading += away(self.heading, offset)
            self.position = self.position + SPEED * np.array([math.cos(self.heading), math.sin(self.heading)])
            if live(self, self.position, self.model.meadow, self.model.rng):
                Grazer(self.model, self.position.copy(), GIVEN)
            if self.energy <= 0:
                self.remove()

    class Grazing(MesaModel):  # type: ignore[misc]
        """The model."""

        def __init__(self) -> None:
            super().__init__(rng=seed)
            size = side(n)
            self.space = ContinuousSpace([[0, size], [0, size]], torus=True, random=self.random, n_agents=n)
            self.meadow = Meadow(size, self.rng)
            for _ in range(n):
                Grazer(self, self.rng.uniform(0, size, 2), 0.5)

        def step(self) -> None:
            """Step all grazers in random order, then grow grass."""
            self.agents.shuffle_do("step")
            self.meadow.grow()

    model = Grazing()
    return model.step, lambda: len(model.agents)


def nearest(space: Any, one: Any, size: float) -> Any:
    """Return the offset to the nearest other agent within range in AgentPy's space, or None."""
    here = space.positions[one]
    offsets = [
        (space.positions[other] - here + size / 2) % size - size / 2 for other in space.neighbors(one, REACH)
    ]
    return min(offsets, key=lambda d: d @ d) if offsets else None


def agentpy(n: int, seed: int) -> Model:
    """Run the task in AgentPy 0.1: agents in its continuous space, with neighbors from a k-d tree."""
    import agentpy as ap

    rng = np.random.default_rng(seed)
    size = side(n)
    meadow = Meadow(size, rng)

    class Grazer(ap.Agent):  # type: ignore[misc]
        """One grazer."""

        def setup(self, energy: float = 0.5) -> None:
            """Set the energy."""
            self.energy, self.heading = energy, rng.uniform(0, 2 * math.pi)

        def step(self) -> None:
            """Look, turn, walk, eat, and divide or die."""
            space = self.model.space
            if (offset := nearest(space, self, size)) is not None:
                self.heading += away(self.heading, offset)
            space.move_by(self, SPEED * np.array([math.cos(self.heading), math.sin(self.heading)]))
            if live(self, space.positions[self], meadow, rng):
                self.model.born.append((space.positions[self].copy(), GIVEN))
            elif self.energy <= 0:
                self.model.dead.append(self)

    class Grazing(ap.Model):  # type: ignore[misc]
        """The model."""

        def setup(self) -> None:
            """Create the agents and the grass."""
            self.space, self.born, self.dead = ap.Space(self, (size, size), torus=True), [], []
            self.grazers = ap.AgentList(self, n, Grazer)
            self.space.add_agents(self.grazers, positions=[rng.uniform(0, size, 2) for _ in range(n)])

        def step(self) -> None:
            """Step all grazers, then handle births, deaths and grass."""
            self.grazers.step()
            for one in self.dead:
                self.space.remove_agents(one)
                self.grazers.remove(one)
            young = [Grazer(self, energy=energy) for _, energy in self.born]
            self.space.add_agents(young, positions=[place for place, _ in self.born])
            self.grazers.extend(young)
            self.born, self.dead = [], []
            meadow.grow()

    model = Grazing({"seed": seed})
    model.sim_setup()
    return model.sim_step, lambda: len(model.grazers)


def magent2(n: int, seed: int, arrays: bool = False) -> Model:
    """Run MAgent2's battle, which has neither births nor energy, with random actions through PettingZoo's
    dicts or its own arrays."""
    from magent2.environments import battle_v4

    width = max(12, round(math.sqrt(n / 0.04)))  # agents fill about this share of battle's map
    env = battle_v4.parallel_env(map_size=min(width, 1000), max_cycles=10**9)
    env.reset(seed=seed)
    rng = np.random.default_rng(seed)
    raw = env.unwrapped.env
    handles = raw.get_handles()

    def by_dicts() -> None:
        actions = {agent: int(rng.integers(env.action_space(agent).n)) for agent in env.agents}
        env.step(actions)

    def by_arrays() -> None:
        for handle in handles:
            raw.get_observation(handle)
            raw.set_action(handle, rng.integers(21, size=raw.get_num(handle)).astype(np.int32))
        raw.step()
        raw.clear_dead()

    return by_arrays if arrays else by_dicts, lambda: sum(raw.get_num(handle) for handle in handles)


def magent2_arrays(n: int, seed: int) -> Model:
    """Run MAgent2's battle through its arrays."""
    return magent2(n, seed, arrays=True)


def pursuit(n: int, seed: int) -> Model:
    """Run PettingZoo's pursuit with random actions: a fixed number of pursuers on a grid whose area is
    proportional to that number."""
    from pettingzoo.sisl import pursuit_v5

    width = max(16, round(math.sqrt(n / 0.03)))
    env = pursuit_v5.parallel_env(n_pursuers=n, n_evaders=n, x_size=width, y_size=width, max_cycles=10**9)
    env.reset(seed=seed)
    rng = np.random.default_rng(seed)
    return lambda: env.step({a: int(rng.integers(5)) for a in env.agents}), lambda: len(env.agents)
