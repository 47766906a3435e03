"""Checks of one species' sensors, actions and networks."""

from __future__ import annotations

import math
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

from ecs_eco.config.checks.body import farthest, too_wide, widest
from ecs_eco.config.checks.matter import Key, unknown
from ecs_eco.config.formula import FormulaError, compile_formula
from ecs_eco.config.memory import n_weights
from ecs_eco.config.models.sensors import Approach, Gradient, Nearest, Own, Place, Rays, Sensor, Smell, Touch
from ecs_eco.config.models.species import GROUPS, MOTIONS, Species, ppo_defaults
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.code import SHIPPED
from ecs_eco.engine.errors import Problem, listed, nearest
from ecs_eco.engine.section import LARGEST

MOST_WHOLE = 10**9  # of a whole number among the hyperparameters
MOST_WEIGHTS = 10_000_000  # of a policy network: initialising so many takes seconds, a decision a millisecond


def check_nerves(config: WorldConfig, name: str, folder: Path) -> Iterator[Problem]:
    """All problems of the species' nervous system; files are named from `folder`."""
    species, key = config.species[name], ("species", name)
    for i, sensor in enumerate(species.sensors):
        yield from _check_sensor(config, species, (*key, "sensors", i), sensor)
    yield from _check_channels(config, key, species)
    yield from _check_actions(config, key, species)
    yield from _check_reflex(config, key, species)
    yield from _check_happiness(config, key, species)
    yield from _check_policy(key, species, folder, config.dims)


def _check_sensor(config: WorldConfig, species: Species, key: Key, sensor: Sensor) -> Iterator[Problem]:
    kinds = [*config.species, *config.objects]
    if isinstance(sensor, Own) and sensor.property not in species.own():
        yield unknown((*key, "property"), "property or substance of the species", sensor.property,
                      species.own())
    if isinstance(sensor, Smell | Gradient) and sensor.field not in config.fields:
        yield unknown((*key, "field"), "field", sensor.field, config.fields)
    if isinstance(sensor, Nearest) and sensor.target not in kinds:
        yield unknown((*key, "target"), "species or object type", sensor.target, kinds)
    if isinstance(sensor, Approach) and sensor.target not in config.species:
        yield unknown((*key, "target"), "species", sensor.target, config.species)
    if isinstance(sensor, Touch) and sensor.target not in (*kinds, "wall", "any"):
        yield unknown((*key, "target"), "species, object type, wall or any", sensor.target,
                      [*kinds, "wall", "any"])
    if isinstance(sensor, Rays):
        for j, target in enumerate(sensor.targets):
            if target not in (*kinds, "wall"):
                yield unknown((*key, "targets", j), "species, object type or wall", target, [*kinds, "wall"])
    if isinstance(sensor, Nearest | Rays | Approach) and sensor.radius > widest(config):
        yield Problem((*key, "radius"), too_wide(config), sensor.radius, f"at most {widest(config):g} m")
    at = getattr(sensor, "at", [])
    if isinstance(sensor, Smell | Place) and math.hypot(*at) > (most := farthest(config, species)):
        yield Problem((*key, "at"), "further off the body than the world is wide, in its radii", at,
                      f"at most {most:g}")
    if isinstance(sensor, Touch) and at[0] == at[1]:
        yield Problem((*key, "at"), "the sector is empty", at, "two angles that differ [rad]")
    elif not isinstance(sensor, Touch) and len(at) > config.dims:
        yield Problem((*key, "at"), "too many numbers for a plane", at, "forward and left")


def _check_channels(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    noses = Counter(s.field for s in species.sensors if isinstance(s, Smell))
    seen: dict[str, int] = {}
    for i, sensor in enumerate(species.sensors):
        for channel in sensor.channels(config.dims):
            own = noses[channel] == 1 and isinstance(sensor, Smell) and sensor.field == channel
            if channel in seen:
                fault = f"gives the channel {channel}, which sensor {seen[channel]} gives too"
                yield Problem((*key, "sensors", i, "name"), fault, sensor.name, "a name of its own")
                break
            if noses[channel] and not own:
                fault = "the mean over the noses has this name"
                yield Problem((*key, "sensors", i, "name"), fault, sensor.name, "another name")
            seen[channel] = i


def _check_actions(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    gaits = species.locomotion.speed if species.locomotion else {}
    others = _groups_of_systems(config)
    ranges = species.ranges()
    for group, actions in species.groups().items():
        at = (*key, "actions", group)
        if group not in (*GROUPS, *others):
            if _may_act(config):
                continue
            yield unknown(at, "group of actions", group, [*GROUPS, *others])
            continue
        if group in ranges:
            yield from _check_range(config, (*at, "continuous"), species, group, group in others)
            continue
        if group in others:
            yield from _check_free_group(at, actions)
            continue
        if group == "pitch":
            yield Problem(at, "has no single actions", actions,
                          "{ continuous = [least, most] }; or up, none and down in the group climb")
            continue
        known = list(gaits) if group == "speed" else list(GROUPS[group] or ())
        if not actions:
            yield Problem(at, "is empty", actions, listed(known))
        for i, action in enumerate(actions):
            if action not in known:
                fault = "gait in locomotion.speed" if group == "speed" else "action"
                yield unknown((*at, i), fault, action, known)
            elif action in actions[:i]:
                yield Problem((*at, i), "named twice", action, listed(known))
        ways = {"turn": ("turn",), "climb": ("climb", "pitch")}.get(group, ())
        if ways and not any(getattr(species.locomotion, way, 0) for way in ways):
            fault = f"it cannot {group}: locomotion.{group} is missing or 0"
            yield Problem(at, fault, actions, f"locomotion.{group} > 0, or no such group")
        if group == "climb" and config.dims == 2:
            yield Problem(at, "no up and down in a plane", actions,
                          "a space of three sizes, or no such group")
        if group == "eat" and not species.diet:
            yield Problem(at, "it has no diet", actions, "a diet, or no such group")
    for group, action in species.neutral.items():
        if group not in species.actions:
            yield unknown((*key, "neutral", group), "group among the species' actions", group,
                          species.actions)
        elif group in ranges:
            low, high = ranges[group]
            if isinstance(action, str) or not low <= action <= high:
                yield Problem((*key, "neutral", group), "not a number of this continuous action", action,
                              f"{low:g} to {high:g}")
        elif action not in species.groups()[group]:
            yield unknown((*key, "neutral", group), f"action in the group {group}", action,
                          species.groups()[group])
    yield from _check_automatic(key, species)


def _check_range(config: WorldConfig, key: Key, species: Species, group: str,
                 free: bool) -> Iterator[Problem]:
    """Check a continuous action; one that is `free` is carried out by a system of the world's own."""
    low, high = species.ranges()[group]
    if not low < high:
        yield Problem(key, "the second is the most", [low, high], "two numbers, the first below the second")
        return
    if free:
        return
    if group not in MOTIONS:
        yield Problem(key[:-1], "cannot be continuous", {"continuous": [low, high]},
                      f"a list of actions; continuous may be {listed(MOTIONS)}")
        return
    if species.locomotion is None:
        yield Problem(key[:-1], "it cannot move: locomotion is missing", {"continuous": [low, high]},
                      "locomotion, or no such group")
        return
    if group in ("climb", "pitch") and config.dims == 2:
        yield Problem(key[:-1], "no up and down in a plane", {"continuous": [low, high]},
                      "a space of three sizes, or no such group")
    if group == "pitch" and "climb" in species.actions:
        yield Problem(key[:-1], "it goes up and down by climb", {"continuous": [low, high]},
                      "one of climb and pitch")
    gaits = species.locomotion.speed.values()
    least, most = {"speed": (0.0, max(gaits)), "pitch": (-math.pi / 2, math.pi / 2)}.get(
        group, (-LARGEST, LARGEST))
    if low < least or high > most:
        words = "speeds up to that of the fastest gait" if group == "speed" else "angles"
        yield Problem(key, "out of range", [low, high], f"{words}, {least:g} to {most:g}")


def _groups_of_systems(config: WorldConfig) -> list[str]:
    """The groups of actions that the world's own systems carry out."""
    groups: list[str] = []
    for system in config.systems:
        groups += getattr(config._code.known(system), "acts", ())
    return groups


def _may_act(config: WorldConfig) -> bool:
    """Whether the world names systems that are not loaded, which may carry out any group of actions."""
    return not config._code.allowed and any(isinstance(s, str) and s not in SHIPPED for s in config.systems)


def _check_free_group(key: Key, actions: list[str]) -> Iterator[Problem]:
    if not actions:
        yield Problem(key, "is empty", actions, "names of actions")
    for i, action in enumerate(actions):
        if not re.fullmatch(r"[A-Za-z]\w{0,39}", action):
            yield Problem((*key, i), "not a name", action, "a letter, then letters, digits or _ (at most 40)")
        elif action in actions[:i]:
            yield Problem((*key, i), "named twice", action, "each name once")


def _check_automatic(key: Key, species: Species) -> Iterator[Problem]:
    rows, pairs = species.action_rows(), species.action_list()
    for i, action in enumerate(species.automatic):
        at = (*key, "automatic", i)
        if action not in rows:
            yield unknown(at, "action of the species", action, rows)
        elif (group := pairs[rows[action]][0]) in species.ranges():
            yield Problem(at, "is continuous: it is done always", action, "an action alone in its group")
        elif len(species.groups()[group]) > 1:
            alone = [names[0] for names in species.groups().values() if len(names) == 1]
            fault = f"the policy chooses among the group {group}"
            yield Problem(at, fault, action, f"an action alone in its group: {listed(alone)}")


def _check_reflex(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    reflex, readings, rows = species.reflex, species.readings(config.dims), species.action_rows()
    if reflex is None:
        return
    for i, connection in enumerate(reflex.connections):
        at = (*key, "reflex", "connections", i)
        if connection.sensor not in readings:
            yield unknown((*at, "sensor"), "sensor of the species", connection.sensor, readings)
        if connection.action not in rows:
            yield unknown((*at, "action"), "action of the species", connection.action, rows)
    for action, formula in reflex.formulas.items():
        if action not in rows:
            yield unknown((*key, "reflex", "formulas", action), "action of the species", action, rows)
        yield from _check_formula((*key, "reflex", "formulas", action), formula, readings)


def _check_happiness(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    happiness, readings = species.happiness, species.readings(config.dims)
    if happiness is None:
        return
    for sensor in happiness.weights:
        if sensor not in readings:
            yield unknown((*key, "happiness", "weights", sensor), "sensor of the species", sensor, readings)
    if happiness.formula is not None:
        yield from _check_formula((*key, "happiness", "formula"), happiness.formula, readings)


def _check_formula(key: Key, formula: str, names: Iterable[str]) -> Iterator[Problem]:
    try:
        compile_formula(formula, names)
    except FormulaError as error:
        yield Problem(key, error.what, formula, error.allowed, error.nearest)


def _no_weights(path: Path) -> str:
    """Why a path cannot be that of weights, or ""; the content of the file is checked when a world is built.
    """
    try:
        if not os.path.isfile(path):
            return "no such file"
        with open(path, "rb") as file:
            file.read(8)  # parts of /proc cannot be read, though they claim to be regular files
        return ""
    except OSError as error:
        return f"cannot be read: {error.strerror or error}"


def _check_policy(key: Key, species: Species, folder: Path, dims: int) -> Iterator[Problem]:
    policy = species.policy
    if policy.file is not None and (wrong := _no_weights(folder / policy.file)):
        near = nearest(policy.file, (p.name for p in folder.glob("*.safetensors")))
        yield Problem((*key, "policy", "file"), wrong, policy.file, "a file beside the world file", near)
    if policy.kind != "individual":
        for word, given, absent in (("inherit", policy.inherit, "none"), ("mutation", policy.mutation, 0.0)):
            if given != absent:
                allowed = 'policy.kind = "individual", or nothing here'
                yield Problem((*key, "policy", word), "only individual networks are inherited",
                              given, allowed)
    if policy.network is not None and policy.hidden != type(policy).model_fields["hidden"].default:
        fault = "the network's own class says its layers"
        yield Problem((*key, "policy", "hidden"), fault, policy.hidden, "policy.network or policy.hidden")
    if policy.network is not None and species.genome is not None:
        for i, gene in enumerate(species.genome.genes):
            if gene.trait == "policy.weights":
                fault = "only weights of the built-in network are written by genes"
                yield Problem((*key, "genome", "genes", i, "trait"), fault, gene.trait,
                              "another trait, or no policy.network")
    if policy.kind != "none" and policy.network is None and (size := n_weights(species, dims)) > MOST_WEIGHTS:
        fault = f"too large: the network would have {size:,} weights"
        yield Problem((*key, "policy", "hidden"), fault, policy.hidden,
                      f"at most {MOST_WEIGHTS:,} weights, as of [2048, 2048]")
    if policy.kind == "none":
        settings: dict[str, object] = {"ppo": species.ppo, "policy.file": policy.file,
                                       "policy.network": policy.network, "policy.learn": policy.learn}
        for word, value in settings.items():
            if value:
                allowed = 'policy.kind = "shared" or "individual", or nothing here'
                yield Problem((*key, *word.split(".")), "there is no policy to use it", value, allowed)
        return
    free = [a for a in species.action_list() if not {a[1], ".".join(a)} & set(species.automatic)]
    for word, needed in {"sensors": species.sensors, "actions": free, "happiness": species.happiness}.items():
        if not needed:
            chosen = word == "actions" and species.actions
            fault = "the policy has nothing to choose" if chosen else "is missing: the policy needs it"
            yield Problem((*key, word), fault, allowed='an entry, or policy.kind = "none"')
    yield from _check_ppo((*key, "ppo"), species)


def _check_ppo(key: Key, species: Species) -> Iterator[Problem]:
    from ecs_eco.learning import PPO

    known = ppo_defaults()
    for name, value in species.ppo.items():
        if name not in known:
            fault = "no hyperparameter of this name"
            yield Problem((*key, name), fault, value, listed(known, 40), nearest(name, known))
            continue
        if (isinstance(value, int | float)
            and abs(value) > (most := MOST_WHOLE if isinstance(value, int) else LARGEST)):
            yield Problem((*key, name), "not possible", value, f"at most {most:g}")
            continue
        try:
            PPO(**{name: value})
        except ValueError as error:
            yield Problem((*key, name), "not possible", value, str(error).partition("allowed is ")[2])
