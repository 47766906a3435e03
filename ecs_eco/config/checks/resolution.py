"""Checks that float32, the type of positions and energies, resolves the steps by which they change."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ecs_eco.config.checks.matter import Key
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import Problem

STEPS = 8  # units of float32 that a step must have: it is then rounded by at most 1/16 of itself


def resolution(value: float) -> float:
    """Return the spacing of float32 numbers just below a value."""
    return math.ldexp(1.0, max(math.frexp(value)[1] - 24 - (math.frexp(value)[0] == 0.5), -149))


def check_resolution(config: WorldConfig, name: str) -> Iterator[Problem]:
    """All problems of a species that would move, or burn or eat energy, in steps that float32 rounds away."""
    species, key = config.species[name], ("species", name)
    yield from _speeds(config, species, key)
    yield from _energies(config, species, key)


def _speeds(config: WorldConfig, species: Species, key: Key) -> Iterator[Problem]:
    ground, way = max(config.space.size[:2]), species.locomotion
    moves: list[tuple[Key, float, float]] = []
    if way is not None:
        moves += [(("locomotion", "speed", gait), speed, ground) for gait, speed in way.speed.items()]
    if config.dims == 3:
        moves += [] if way is None else [(("locomotion", "climb"), way.climb, config.space.size[2])]
        moves += [(("body", "sinking"), species.body.sinking, config.space.size[2])]
    for part, speed, extent in moves:
        if 0 < abs(speed) < (least := STEPS * resolution(extent) / config.dt):
            fault = (f"too slow for a world of {extent:g} m: positions are float32, "
                     "and such steps are rounded away")
            allowed = f"0, or at least {least:.3g} m/s; or a smaller world, or a longer tick"
            yield Problem((*key, *part), fault, speed, allowed)


def _energies(config: WorldConfig, species: Species, key: Key) -> Iterator[Problem]:
    budget, step = species.metabolism, STEPS * resolution(species.metabolism.energy_max)
    fault = (f"too little for energies up to energy_max, {budget.energy_max:g}: they are float32, "
             "and such steps are rounded away")
    if 0 < budget.basal * config.dt < step:
        allowed = f"0, or at least {step / config.dt:.3g} per second; or a smaller energy_max"
        yield Problem((*key, "metabolism", "basal"), fault, budget.basal, allowed)
    way = None if species.heat is None else species.heat.regulate
    if way is not None and 0 < (burnt := way.cost * max(way.warming, way.cooling)) * config.dt < step:
        allowed = f"0, or at least {way.cost * step / (burnt * config.dt):.3g}; or a smaller energy_max"
        yield Problem((*key, "heat", "regulate", "cost"), fault, way.cost, allowed)
    for i, food in enumerate(species.diet):
        if 0 < food.gain < step:
            allowed = f"0, or at least {step:.3g}; or a smaller energy_max"
            yield Problem((*key, "diet", i, "gain"), fault, food.gain, allowed)
