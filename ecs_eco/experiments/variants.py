"""Variants: controls that are changes of a world's values, which any world with a sun, smells or such a happiness may use.

Unlike `ecs_eco.worlds.treatments`, which act on a living world, these can be trained in: a variant is a world of its own.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from ecs_eco.config import WorldConfig
from ecs_eco.config.models.sensors import Gradient, Light, Smell

LIGHT_WEIGHT = 0.3  # of light in the happiness of `energy-and-light`
DULL = 1e30  # scale of a nose that smells nothing
ABSENT = "no-"  # and the name of a species: none of it
MATTERS_TO_LEARNING = ("energy-only", "energy-and-light")  # policies that do not learn live the same


class NotApplicable(ValueError):
    """A variant that this world has nothing for: `what` it lacks, and what is `allowed`."""

    def __init__(self, what: str, allowed: str) -> None:
        self.what, self.allowed = what, allowed
        super().__init__(f"{what}; {allowed}")


def constant_light(config: WorldConfig) -> dict[str, Any]:
    """Light is the mean of the day at all times."""
    return _sun(config, "constant")


def inverted_light(config: WorldConfig) -> dict[str, Any]:
    """It is dark by day: the sun comes half a day later."""
    return _sun(config, "inverted")


def no_smell(config: WorldConfig) -> dict[str, Any]:
    """Nobody's nose smells anything; smells are there all the same, and networks keep their inputs."""
    found = {f"species.{name}.sensors.{i}.scale": DULL for name, species in config.species.items()
             for i, sensor in enumerate(species.sensors) if isinstance(sensor, Smell | Gradient)}  # fmt: skip
    if not found:
        raise NotApplicable("no species has a nose", 'a world with a sensor of kind "smell" or "gradient"')
    return found


def energy_only(config: WorldConfig) -> dict[str, Any]:
    """Those whose happiness knows light are happy by energy alone."""
    wanted = [n for n in config.species if _lit(config, n) and _energy(config, n)]
    if not wanted:
        raise NotApplicable("nobody's happiness depends on light", "energy-and-light, or a happiness.formula that names energy and light")
    return {f"species.{name}.happiness.formula": _energy(config, name) for name in wanted}


def energy_and_light(config: WorldConfig) -> dict[str, Any]:
    """Those who see light and whose happiness does not know it yet dislike it: the formula, less 0.3 times light."""
    wanted = {
        n: _light(config, n) for n, s in config.species.items() if s.happiness is not None and s.happiness.formula and not _lit(config, n)
    }
    found = {f"species.{n}.happiness.formula": f"{_formula(config, n)} - {LIGHT_WEIGHT} * {light}" for n, light in wanted.items() if light}
    if not found:
        raise NotApplicable("nobody senses light and has a happiness.formula without it", "energy-only")
    return found


def without(config: WorldConfig, species: str) -> dict[str, Any]:
    """There is none of a species, neither in life nor in training."""
    if species not in config.species:
        raise NotApplicable(f"no species named {species}", ", ".join(config.species))
    key = f"species.{species}.count"
    out: dict[str, Any] = {key: 0}
    if getattr(config.species[species].reproduction, "immigration", 0.0):
        out[f"species.{species}.reproduction.immigration"] = 0.0
    if key in config.training.vary:
        raise NotApplicable(f"training.vary varies {key}", "a world that does not vary it")
    return out | ({f'training.set."{key}"': 0} if key in config.training.set else {})


VARIANTS: dict[str, Callable[[WorldConfig], dict[str, Any]]] = {
    "constant-light": constant_light, "inverted-light": inverted_light, "no-smell": no_smell,
    "energy-only": energy_only, "energy-and-light": energy_and_light,
}  # fmt: skip


def names(config: WorldConfig) -> list[str]:
    """Return the names of all variants, whether or not this world has something for them."""
    return [*VARIANTS, *(ABSENT + name for name in config.species)]


def variant(config: WorldConfig, name: str) -> dict[str, Any]:
    """Return the values that a variant changes, by dotted key. KeyError for a name that is none, NotApplicable."""
    if name in VARIANTS:
        return VARIANTS[name](config)
    if name not in names(config):
        raise KeyError(name)
    return without(config, name.removeprefix(ABSENT))


def _sun(config: WorldConfig, kind: str) -> dict[str, Any]:
    if config.sun is None:
        raise NotApplicable("there is no sun", "a world with [sun]")
    if config.sun.kind == kind:
        raise NotApplicable(f"the sun is {kind} already", "a world with another sun.kind")
    return {"sun.kind": kind}


def _light(config: WorldConfig, name: str) -> str | None:
    """The channel by which a species senses light."""
    return next((s.base() if s.name is None else s.name for s in config.species[name].sensors if isinstance(s, Light)), None)


def _energy(config: WorldConfig, name: str) -> str | None:
    """The channel by which a species senses its energy."""
    return next((s.name for s in config.species[name].sensors if s.kind == "own" and s.property == "energy"), None)


def _formula(config: WorldConfig, name: str) -> str:
    """The formula of a species' happiness, in brackets where it is more than a name."""
    happiness = config.species[name].happiness
    text = "" if happiness is None else str(happiness.formula)
    return text if text.isidentifier() else f"({text})"


def _lit(config: WorldConfig, name: str) -> bool:
    """Whether the formula of a species' happiness names light."""
    happiness, light = config.species[name].happiness, _light(config, name)
    return bool(light and happiness and happiness.formula and re.search(rf"\b{re.escape(light)}\b", happiness.formula))
