"""Checks of one species' sensors, actions and networks."""

import math
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from ecs_eco.config.checks.actions import check_actions
from ecs_eco.config.checks.body import Key, farthest
from ecs_eco.config.formula import FormulaError, compile_formula
from ecs_eco.config.memory import n_weights
from ecs_eco.config.models.sensors import (
    Alignment,
    Approach,
    Gradient,
    Nearest,
    Own,
    Place,
    Property,
    Rays,
    Sensor,
    Smell,
    Touch,
)
from ecs_eco.config.models.species import Species, ppo_defaults
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import at_most, named
from ecs_eco.engine.errors import Problem, listed, nearest, unknown
from ecs_eco.engine.files import read_bytes
from ecs_eco.inputs.section import LARGEST, function_name
from ecs_eco.learning.aliases import ALIASES
from ecs_eco.learning.settings import check_setting
from ecs_eco.learning.weights import MOST_BYTES

MOST_WHOLE = 10**9  # maximum value of an integer hyperparameter
MOST_WEIGHTS = 10_000_000  # per network; larger networks take seconds to initialize and 1 ms per decision


def check_nerves(config: WorldConfig, name: str, folder: Path) -> Iterator[Problem]:
    """Yield all problems with the species' nervous system; file names are relative to `folder`."""
    species, key = config.species[name], ("species", name)
    yield from (wrong := [*check_sensors(config, name), *_check_channels(config, key, species)])
    yield from (unable := [*check_actions(config, key, species)])
    # omit names that have problems, so that valid uses of them are not rejected
    sensors = species.readings(config.dims) if not wrong else None
    yield from _check_reflex(key, species, sensors, species.action_rows() if not unable else None)
    yield from _check_happiness(key, species, sensors)
    yield from _check_policy(key, species, folder, config.dims)


def check_sensors(config: WorldConfig, name: str) -> Iterator[Problem]:
    """Yield all problems with the species' sensors, except those with the names of their channels."""
    for i, sensor in enumerate(config.species[name].sensors):
        yield from _check_sensor(config, config.species[name], ("species", name, "sensors", i), sensor)


def _check_sensor(config: WorldConfig, species: Species, key: Key, sensor: Sensor) -> Iterator[Problem]:
    kinds = [*config.species, *config.objects]
    targets = {
        "nearest": ("species or object type", kinds),
        "approach": ("species", [*config.species]),
        "alignment": ("species", [*config.species]),
        "touch": ("species, object type, wall or any", [*kinds, "wall", "any"]),
    }
    if isinstance(sensor, Own) and not config.may_have(str(key[1]), sensor.property):
        yield from _unless_felt((*key, "property"), "the species", sensor.property, config.felt(str(key[1])))
    if isinstance(sensor, Property):
        yield from _check_property(config, key, sensor)
    if isinstance(sensor, Nearest | Property) and sensor.kin is not None:
        yield from _check_kin(config, config.family(str(key[1])), key, sensor)
    if isinstance(sensor, Smell | Gradient):
        yield from named((*key, "field"), "field", sensor.field, config.fields)
    if isinstance(sensor, Nearest | Approach | Alignment | Touch):
        word, known = targets[sensor.kind]
        yield from named((*key, "target"), word, sensor.target, known)
    for j, target in enumerate(sensor.targets if isinstance(sensor, Rays) else ()):
        yield from named((*key, "targets", j), "species, object type or wall", target, [*kinds, "wall"])
    if isinstance(sensor, Nearest | Rays | Approach | Alignment | Property):
        yield from at_most((*key, "range"), config.space.too_wide, sensor.range, config.space.widest)
    at, most = getattr(sensor, "at", []), farthest(config, species)
    if isinstance(sensor, Smell | Place | Rays | Property) and math.hypot(*at) > most:
        fault = "farther from the body than the width of the world, in body radii"
        yield Problem((*key, "at"), fault, at, f"at most {most:g}")
    if isinstance(sensor, Touch) and at[0] == at[1]:
        yield Problem((*key, "at"), "the sector is empty", at, "two different angles [rad]")
    elif not isinstance(sensor, Touch) and len(at) > config.dims:
        yield Problem((*key, "at"), "too many numbers for a plane", at, "forward and left")


def _check_property(config: WorldConfig, key: Key, sensor: Property) -> Iterator[Problem]:
    kinds, of = [*config.species, *config.objects], sensor.kinds()
    for i, kind in enumerate(of):
        at = (*key, "of") if isinstance(sensor.of, str) else (*key, "of", i)
        if kind not in kinds:
            yield unknown(at, "species or object type", kind, kinds)
        elif kind in of[:i]:
            yield Problem(at, "named twice", kind, "each species or object type once")
        elif not config.may_have(kind, sensor.property):
            yield from _unless_felt((*key, "property"), kind, sensor.property, config.felt(kind))
    if not of and not any(config.may_have(kind, sensor.property) for kind in kinds):
        felt = dict.fromkeys(name for kind in kinds for name in config.felt(kind))
        yield from _unless_felt((*key, "property"), "any body", sensor.property, felt)


def _unless_felt(key: Key, of: str, property: str, felt: Iterable[str]) -> Iterator[Problem]:
    yield from named(key, f"property or substance of {of}", property, felt)


def _check_kin(
    config: WorldConfig, family: Sequence[str], key: Key, sensor: Nearest | Property
) -> Iterator[Problem]:
    of = [sensor.target] if isinstance(sensor, Nearest) else sensor.kinds()
    at = (*key, "target" if isinstance(sensor, Nearest) else "of")
    for kind in of:
        if kind not in family and kind in (*config.species, *config.objects):
            yield Problem(at, "no members of it are kin", kind, " or ".join(family) + ", or remove kin")
    if not of:
        yield Problem(at, "is missing, but kin requires it", allowed=" or ".join(family))
    if isinstance(sensor, Nearest) and (sensor.occlusion or sensor.sight is not None):
        word = "occlusion" if sensor.occlusion else "sight"
        fault = "kin are recognized by voice, not by sight"
        yield Problem((*key, word), fault, getattr(sensor, word), f"either kin or {word}")


def _check_channels(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    noses = Counter(s.field for s in species.sensors if isinstance(s, Smell))
    seen: dict[str, int] = {}
    for i, sensor in enumerate(species.sensors):
        for channel in sensor.channels(config.dims):
            own = noses[channel] == 1 and isinstance(sensor, Smell) and sensor.field == channel
            if channel in seen:
                fault = f"has the channel {channel}, which sensor {seen[channel]} also has"
                yield Problem((*key, "sensors", i, "name"), fault, sensor.name, "a unique name")
                break
            if noses[channel] and not own:
                fault = "the mean over the noses has this name"
                yield Problem((*key, "sensors", i, "name"), fault, sensor.name, "another name")
            seen[channel] = i


def _check_reflex(
    key: Key, species: Species, readings: Iterable[str] | None, rows: Iterable[str] | None
) -> Iterator[Problem]:
    reflex = species.reflex
    if reflex is None:
        return
    for i, connection in enumerate(reflex.connections):
        at = (*key, "reflex", "connections", i)
        if readings is not None:
            yield from named((*at, "sensor"), "sensor of the species", connection.sensor, readings)
        if rows is not None:
            yield from named((*at, "action"), "action of the species", connection.action, rows)
    for action, formula in reflex.formulas.items():
        if rows is not None:
            yield from named((*key, "reflex", "formulas", action), "action of the species", action, rows)
        yield from _check_formula((*key, "reflex", "formulas", action), formula, readings)


def _check_happiness(key: Key, species: Species, readings: Iterable[str] | None) -> Iterator[Problem]:
    happiness = species.happiness
    if happiness is None:
        return
    if readings is not None:
        for sensor in happiness.weights:
            at = (*key, "happiness", "weights", sensor)
            yield from named(at, "sensor of the species", sensor, readings)
    if happiness.formula is not None:
        yield from _check_formula((*key, "happiness", "formula"), happiness.formula, readings)


def _check_formula(key: Key, formula: str, names: Iterable[str] | None) -> Iterator[Problem]:
    try:
        compile_formula(formula, re.findall(r"[A-Za-z_]\w*", formula) if names is None else names)
    except FormulaError as error:
        yield Problem(key, error.what, formula, error.allowed, error.nearest)


def _no_weights(path: Path) -> str:
    """Return why a path cannot be a weights file, or ""; its contents are checked when the world is built."""
    try:
        if not os.path.isfile(path):
            return "no such file"
        read_bytes(path, MOST_BYTES)  # files in /proc claim to be regular files but cannot be read
        return ""
    except OSError as error:
        return f"cannot be read: {error.strerror or error}"


def _check_policy(key: Key, species: Species, folder: Path, dims: int) -> Iterator[Problem]:
    policy, at = species.policy, (*key, "policy")
    if policy.file is not None and (wrong := _no_weights(folder / policy.file)):
        near = nearest(policy.file, (p.name for p in folder.glob("*.safetensors")))
        yield Problem((*at, "file"), wrong, policy.file, "a file next to the world file", near)
    inherited = {"inherit": policy.inherit != "none", "mutation_sd": policy.mutation_sd != 0}
    for word in (w for w, given in inherited.items() if given and policy.kind != "individual"):
        allowed = 'policy.kind = "individual", or remove this key'
        yield Problem((*at, word), "only individual networks are inherited", getattr(policy, word), allowed)
    if policy.network is not None and policy.hidden != type(policy).model_fields["hidden"].default:
        fault = "the class of the network defines its layers"
        yield Problem((*at, "hidden"), fault, policy.hidden, "either policy.network or policy.hidden")
    if policy.thinks and policy.network is None and (size := n_weights(species, dims)) > MOST_WEIGHTS:
        fault = f"too large: the network would have {size:,} weights"
        allowed = f"at most {MOST_WEIGHTS:,} weights, such as [2048, 2048]"
        yield Problem((*at, "hidden"), fault, policy.hidden, allowed)
    if policy.kind == "shared" and policy.network is None and not policy.hidden:
        fault = "a shared network has at least one hidden layer"
        yield Problem(
            (*at, "hidden"), fault, policy.hidden, 'a list such as [8], or policy.kind = "individual"'
        )
    if policy.kind == "function" and policy.function is None:
        allowed = '"module:name" of a function from sensors (n, channels) and uids (n) to choices (n, groups)'
        yield Problem((*at, "function"), "is missing", allowed=allowed)
    if policy.kind != "function" and policy.function is not None:
        fault, allowed = "no policy of this kind uses it", 'policy.kind = "function", or remove this key'
        yield Problem((*at, "function"), fault, function_name(policy.function), allowed)
    settings: dict[Key, object] = {("ppo",): species.ppo}
    settings |= {("policy", word): getattr(policy, word) for word in ("file", "network", "learn")}
    for place, value in settings.items():
        if value and not policy.thinks:
            allowed = 'policy.kind = "shared" or "individual", or remove this key'
            yield Problem((*key, *place), "no network uses it", value, allowed)
    if policy.kind != "none":
        yield from _check_needs(key, species)


def _check_needs(key: Key, species: Species) -> Iterator[Problem]:
    """Yield problems with a policy's requirements: observations, choices and, if it learns, happiness."""
    needs = {"sensors": species.sensors, "actions": species.decisions()}
    needs |= {"happiness": species.happiness} if species.policy.thinks else {}
    for word in (word for word, needed in needs.items() if not needed):
        chosen = word == "actions" and species.actions
        fault = "the policy has nothing to choose from" if chosen else "is missing, but the policy needs it"
        yield Problem((*key, word), fault, allowed='an entry, or policy.kind = "none"')
    if species.policy.thinks:
        yield from _check_ppo((*key, "ppo"), species)


def _check_ppo(key: Key, species: Species) -> Iterator[Problem]:
    known = ppo_defaults()
    for name, value in species.ppo.items():
        most, at = MOST_WHOLE if isinstance(value, int) else LARGEST, (*key, name)
        if name in ALIASES and name not in known:
            fault = f"another name for {ALIASES[name]}, which is given twice"
            yield Problem(at, fault, value, f"only {ALIASES[name]}")
        elif name not in known:
            fault = "no hyperparameter has this name"
            yield Problem(at, fault, value, listed(known, 40), nearest(name, known))
        elif isinstance(value, int | float) and abs(value) > most:
            yield Problem(at, "not possible", value, f"at most {most:g}")
        else:
            try:
                check_setting(name, value)
            except ValueError as error:
                yield Problem(at, "not possible", value, str(error).partition("expected ")[2])
