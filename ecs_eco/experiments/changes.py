"""Treatments that change values of a world, by dotted key, in any world that has these keys.

Policies can be trained in a world with other values, unlike in one that is treated as it is built
(`ecs_eco.life.treatments`).
"""

import re
from typing import Any

from ecs_eco.config import WorldConfig
from ecs_eco.config.models.sensors import Gradient, Light, Smell

LIGHT_WEIGHT = 0.3  # of light in the happiness of `energy-and-light`
ANOSMIC = 1e30  # scale at which a nose reads 0


class NotApplicable(ValueError):
    """A treatment that does not apply to this world: `what` is missing, and what is `allowed`."""

    def __init__(self, fault: str, allowed: str) -> None:
        self.what, self.allowed = fault, allowed
        super().__init__(f"{fault}; {allowed}")


def constant_light(config: WorldConfig) -> dict[str, Any]:
    """Light is the mean of the day at all times."""
    return _sun(config, "constant")


def inverted_light(config: WorldConfig) -> dict[str, Any]:
    """The day is dark: the sun rises half a day later."""
    return _sun(config, "inverted")


def no_smell(config: WorldConfig) -> dict[str, Any]:
    """Noses do not respond to smells, which stay in the world; networks keep their inputs."""
    values = {
        f"species.{name}.sensors.{i}.scale": ANOSMIC
        for name, species in config.species.items()
        for i, sensor in enumerate(species.sensors)
        if isinstance(sensor, Smell | Gradient)
    }
    if not values:
        raise NotApplicable("no species has a nose", 'a world with a sensor of kind "smell" or "gradient"')
    return values


def energy_only(config: WorldConfig) -> dict[str, Any]:
    """Happiness that depends on light becomes that of energy alone."""
    formulas = {name: _energy(config, name) for name in config.species if _depends_on_light(config, name)}
    if not any(formulas.values()):
        allowed = "energy-and-light, or a happiness.formula that names energy and light"
        raise NotApplicable("nobody's happiness depends on light", allowed)
    return {f"species.{name}.happiness.formula": energy for name, energy in formulas.items() if energy}


def energy_and_light(config: WorldConfig) -> dict[str, Any]:
    """Species that sense light dislike it: 0.3 times light is subtracted from a formula without light."""
    values: dict[str, Any] = {}
    for name, species in config.species.items():
        light = _light(config, name)
        has_formula = species.happiness is not None and bool(species.happiness.formula)
        if light and has_formula and not _depends_on_light(config, name):
            values[f"species.{name}.happiness.formula"] = (
                f"{_formula(config, name)} - {LIGHT_WEIGHT} * {light}"
            )
    if not values:
        raise NotApplicable("nobody senses light and has a happiness.formula without it", "energy-only")
    return values


def without(config: WorldConfig, species: str) -> dict[str, Any]:
    """A species is absent, in life and in training."""
    if species not in config.species:
        raise NotApplicable(f"no species named {species}", ", ".join(config.species))
    key = f"species.{species}.count"
    out: dict[str, Any] = {key: 0}
    if getattr(config.species[species].reproduction, "immigration", 0.0):
        out[f"species.{species}.reproduction.immigration"] = 0.0
    if key in config.training.vary:
        raise NotApplicable(f"training.vary varies {key}", "a world that does not vary it")
    return out | ({f'training.set."{key}"': 0} if key in config.training.set else {})


def _sun(config: WorldConfig, kind: str) -> dict[str, Any]:
    if config.sun is None:
        raise NotApplicable("there is no sun", "a world with [sun]")
    if config.sun.kind == kind:
        raise NotApplicable(f"the sun is {kind} already", "a world with another sun.kind")
    return {"sun.kind": kind}


def _light(config: WorldConfig, name: str) -> str | None:
    """The channel by which a species senses light."""
    lights = (s for s in config.species[name].sensors if isinstance(s, Light))
    return next((s.base() if s.name is None else s.name for s in lights), None)


def _energy(config: WorldConfig, name: str) -> str | None:
    """The channel by which a species senses its energy."""
    own = (s for s in config.species[name].sensors if s.kind == "own")
    return next((s.name for s in own if s.property == "energy"), None)


def _formula(config: WorldConfig, name: str) -> str:
    """The formula of a species' happiness, in brackets where it is more than a name."""
    happiness = config.species[name].happiness
    text = "" if happiness is None else str(happiness.formula)
    return text if text.isidentifier() else f"({text})"


def _depends_on_light(config: WorldConfig, name: str) -> bool:
    """Whether the formula of a species' happiness names the channel by which it senses light."""
    happiness, light = config.species[name].happiness, _light(config, name)
    if not (light and happiness and happiness.formula):
        return False
    return bool(re.search(rf"\b{re.escape(light)}\b", happiness.formula))
