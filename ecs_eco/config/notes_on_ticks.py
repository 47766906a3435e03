"""Notes on the length of a tick: processes of a world for which `dt` is too long."""

import math
from collections.abc import Iterator

from ecs_eco.config.features.feature import of_each
from ecs_eco.config.models.sensors import Touch
from ecs_eco.config.models.world import WorldConfig

ROUNDED = 0.1  # a note is given if rounding to whole ticks changes a time by more than this fraction


def notes_on_ticks(config: WorldConfig) -> list[str]:
    """Return the notes on processes for which the ticks of a world are too long, one per line."""
    return [*_on_contacts(config), *_on_times(config), *_on_cycles(config)]


def _on_contacts(config: WorldConfig) -> Iterator[str]:
    """Yield notes on fast bodies, which can pass each other undetected within a tick."""
    for key, name, other, reach, fix in _contacts(config):
        way = (_fastest(config, name) + _fastest(config, other)) * config.dt
        meet = reach + _radius(config, name) + _radius(config, other)
        if way > meet > 0:
            fixes = [f"dt = {_rounded(config.dt * meet / way, 2, up=False)}"]
            if fix:
                fixes.append(f"{fix} = {_rounded(reach + way - meet, 3, up=True)}")
            yield (
                f"species.{name}.{key}: {name} and {other} move up to {way:.3g} m past each other in a tick, "
                f"and contacts within {meet:.3g} m are checked only at its end, so about "
                f"{share_met(way, meet):.0%} of encounters are detected; {' or '.join(fixes)} detects 96%"
            )


def _contacts(config: WorldConfig) -> Iterator[tuple[str, str, str, float, str]]:
    """Yield the key, the species, the kind that it contacts, the reach [m], and the reach's key."""
    for name, species in config.species.items():
        for key, other, reach in of_each(species, "meets"):
            yield key, name, other, reach, "reach"
        if (way := species.reproduction) is not None and way.kind == "sexual":
            yield "reproduction", name, name, way.reach, "reach"
        for i, sensor in enumerate(species.sensors):
            target = sensor.target if isinstance(sensor, Touch) else None
            for kind in (*config.species, *config.objects):
                if target in (kind, "any"):
                    yield f"sensors.{i}", name, kind, 0.0, ""


def share_met(way: float, meet: float) -> float:
    """Return the proportion of encounters detected: of the strip within `meet` [m] of a straight course, the
    part that is also within `meet` of points `way` [m] apart on the course."""
    disc = math.pi * meet * meet
    if way < 2 * meet:  # subtract the overlap of two neighboring discs
        disc -= 2 * meet * meet * math.acos(way / 2 / meet) - way / 2 * math.sqrt(4 * meet * meet - way * way)
    return disc / (2 * meet * way)


def _fastest(config: WorldConfig, name: str) -> float:
    """Return the maximum speed of a species, or of objects with `motion` [m/s]."""
    if (species := config.species.get(name)) is not None:
        gaits = [] if species.locomotion is None else species.locomotion.speed.values()
        return max((*gaits, species.ranges().get("speed", (0.0, 0.0))[1]))
    motion = config.objects[name].motion
    return 0.0 if motion is None else motion.speed or math.hypot(*(motion.velocity or [0.0]))


def _radius(config: WorldConfig, name: str) -> float:
    return (config.species.get(name) or config.objects[name]).body.radius


def _on_times(config: WorldConfig) -> Iterator[str]:
    """Yield notes on times that rounding up to whole ticks changes noticeably."""
    for name, species in config.species.items():
        times = {"metabolism.handling_time": species.metabolism.handling_time}
        times |= {
            f"reproduction.{key}": getattr(species.reproduction, key, 0.0)
            for key in ("gestation", "rest", "father_rest")
        }
        times |= dict(of_each(species, "times"))
        for key, time in times.items():
            lasts = math.ceil(time / config.dt * (1 - 1e-6)) * config.dt
            if lasts > time * (1 + ROUNDED):
                yield (
                    f"species.{name}.{key} = {time:g}: times are whole ticks of dt = {config.dt:g} s, so "
                    f"this one lasts {lasts:g} s; a smaller dt is more accurate"
                )


def _on_cycles(config: WorldConfig) -> Iterator[str]:
    """Yield notes on days, years and seasons that are short compared with a tick."""
    cycles = {
        "sun.day": config.sun and config.sun.day,
        "sun.year": config.sun and config.sun.year,
        "year.length": config.year and config.year.length,
    }
    for key, time in cycles.items():
        if time and time < 2 * config.dt:
            yield (
                f"{key} = {time:g}: less than two ticks of dt = {config.dt:g} s; each tick samples the "
                "cycle once, so most of it is missed"
            )
    for i, use in enumerate(config.land_use):
        if use.season is not None and use.period is not None:
            first, last = use.season
            if (open_for := (last - first) % 1.0 * use.period) < config.dt:
                yield (
                    f"land_use.{i}.season lasts {open_for:g} s, less than a tick of "
                    f"dt = {config.dt:g} s: some years have no tick in the season"
                )


def _rounded(value: float, digits: int, up: bool) -> str:
    """Return a number rounded up or down to this many digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) + 1 - digits)
    whole = math.ceil(value / digit - 1e-9) if up else math.floor(value / digit + 1e-9)
    return f"{whole * digit:.{digits}g}"
