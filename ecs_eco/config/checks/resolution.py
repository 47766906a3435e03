"""Checks that float32 resolves the steps by which positions, headings, energies and smells change.

Other sums need no check: ages and times are in ticks, incubation is float64, and masses, temperatures and
substances also store the rounding error of float32.
"""

import math
from collections.abc import Iterator

from ecs_eco.config.features.feature import Cost, of_each
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import Key
from ecs_eco.engine.errors import Problem

STEPS = 8  # minimum size of a step in units of float32 spacing, so that rounding changes it by at most 1/16


def resolution(value: float) -> float:
    """Return the spacing of float32 numbers just below a value."""
    return math.ldexp(1.0, max(math.frexp(value)[1] - 24 - (math.frexp(value)[0] == 0.5), -149))


def check_resolution(config: WorldConfig) -> Iterator[Problem]:
    """Yield problems with steps of motion, decay and energy that float32 rounds to 0."""
    size, dt = config.space.size, config.dt
    for name, species in config.species.items():
        yield from _motions(config, species, ("species", name))
        yield from _energies(species, ("species", name), dt)
    for name, kind in config.objects.items():
        if kind.motion is not None:
            ways = {"velocity": kind.motion.velocity or [], "speed": [kind.motion.speed or 0.0]}
            for part, speeds in ways.items():
                key = ("objects", name, "motion", part)
                yield from _slow([(key, speed, max(size[:2])) for speed in speeds], dt)
        if kind.energy is not None:
            yield from _fades(("objects", name, "energy", "decay"), kind.energy.decay, dt)
    for i, layer in enumerate(config.water.current if config.water is not None else ()):
        at = ("water", "current", i, "velocity")
        yield from _slow([(at, speed, max(size[:2])) for speed in layer.velocity], dt)
    for name, field in config.fields.items():
        if field.substance is None:
            yield from _fades(("fields", name, "decay"), field.decay, dt)


def _motions(config: WorldConfig, species: Species, key: Key) -> Iterator[Problem]:
    ground, way = max(config.space.size[:2]), species.locomotion
    moves: list[tuple[Key, float, float]] = []
    if way is not None:
        moves += [(("locomotion", "speed", gait), speed, ground) for gait, speed in way.speed.items()]
        if 0 < way.turn * config.dt < (step := STEPS * resolution(2 * math.pi)):
            fault = "too slow: headings are float32, so such small steps round to 0"
            allowed = f"0, or at least {step / config.dt:.3g} rad/s"
            yield Problem((*key, "locomotion", "turn"), fault, way.turn, allowed)
    if config.dims == 3:
        moves += [] if way is None else [(("locomotion", "climb"), way.climb, config.space.size[2])]
        moves += [(("body", "sinking"), species.body.sinking, config.space.size[2])]
    yield from _slow([((*key, *part), speed, extent) for part, speed, extent in moves], config.dt)


def _slow(moves: list[tuple[Key, float, float]], dt: float) -> Iterator[Problem]:
    for key, speed, extent in moves:
        if 0 < abs(speed) < (least := STEPS * resolution(extent) / dt):
            fault = (
                f"too slow for a {extent:g} m world: positions are float32, so such small steps round to 0"
            )
            allowed = f"0, or at least {least:.3g} m/s; or a smaller world, or a longer tick"
            yield Problem(key, fault, speed, allowed)


def _fades(key: Key, decay: float, dt: float) -> Iterator[Problem]:
    if 0 < decay * dt < (step := STEPS * resolution(1.0)):
        fault = "too slow: amounts are float32, so such small steps round to 0"
        yield Problem(key, fault, decay, f"0, or at least {step / dt:.3g} per second; or a longer tick")


def _energies(species: Species, key: Key, dt: float) -> Iterator[Problem]:
    budget, step = species.metabolism, STEPS * resolution(species.metabolism.energy_max)
    fault = (
        f"too little for energies up to energy_max, {budget.energy_max:g}: energies are float32, so "
        "such small steps round to 0"
    )
    costs = [Cost(("metabolism", part), getattr(budget, part)) for part in ("basal", "photosynthesis")]
    if (way := species.locomotion) is not None:
        costs += [Cost(("locomotion", "cost", gait), cost) for gait, cost in way.cost.items()]
    for part, value, most, _ in (*costs, *of_each(species, "costs")):
        times = dt if most is None else most * dt
        if 0 < value * times < step:
            least = f"{step / times:.3g}" + (" per second" if most is None else "")
            yield Problem((*key, *part), fault, value, f"0, or at least {least}; or a smaller energy_max")
    for i, food in enumerate(species.diet):
        if 0 < food.gain < step:
            allowed = f"0, or at least {step:.3g}; or a smaller energy_max"
            yield Problem((*key, "diet", i, "gain"), fault, food.gain, allowed)
