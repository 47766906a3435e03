"""The initial policies of a world: fresh networks, weights in files, torch modules passed by the user; and
how to obtain them again."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ecs_eco.components import Policy
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.shipped import WORLDS
from ecs_eco.engine.arguments import by_species
from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest
from ecs_eco.engine.files import read_bytes
from ecs_eco.engine.versions import versions
from ecs_eco.inputs.section import function_name
from ecs_eco.learning import weights
from ecs_eco.learning.brains import brain_of, individuals_of
from ecs_eco.nervous.external import expect
from ecs_eco.nervous.outside import Function, Nobody

if TYPE_CHECKING:
    import torch

    from ecs_eco.config.models.nerves import Policy as PolicyConfig
    from ecs_eco.learning.policy_network import PolicyNetwork
    from ecs_eco.learning.settings import PPO
    from ecs_eco.space.world import SpatialWorld

POLICIES = ("trained", "random", "untrained")
Policies: TypeAlias = "str | Path | Mapping[str, str | Path | torch.nn.Module]"
"""The source of policies: one of POLICIES, a folder, or by species one of these or a module."""
Learn: TypeAlias = bool | Mapping[str, bool] | None
"""Whether species learn: all, none, or by species; None: as in the world file."""
Shape = tuple[int, tuple[int, ...], tuple[int, ...]]  # channels, options of each group, hidden layers


def fresh_brain(
    config: WorldConfig, name: str, policy: PolicyConfig, shape: Shape, seed: int, ppo: PPO | None = None
) -> Any:
    """Return a fresh network of a species, or, with `ppo`, the networks of its individuals; raise ConfigError
    at the module that it names."""
    try:
        network, device = config.function(policy.network), policy.device
        if ppo is None:
            return brain_of(network, *shape, seed=seed, device=device)
        return individuals_of(network, *shape, ppo=ppo, seed=seed, device=device)
    except (ValueError, AttributeError, ImportError) as error:
        key = ("species", name, "policy", "network" if policy.network else "device")
        given = function_name(policy.network) if policy.network else policy.device
        allowed = (
            f"a torch module for {shape[0]} observations and the groups of options "
            f"{shape[1]} (docs/explanation/learning.md)"
        )
        raise ConfigError([Problem(key, str(error), given, allowed)]) from None


def outside_of(world: SpatialWorld, name: str, policy: PolicyConfig) -> Any:
    """Return the decision-maker of a species without a network: a function, or an empty placeholder."""
    if policy.kind == "function":
        return Function(world.config.function(policy.function), policy.function)
    expect(world)
    return Nobody()


def take_weights(brain: PolicyNetwork, module: torch.nn.Module, name: str) -> None:
    """Load the weights of a torch module passed by the user into a brain."""
    from ecs_eco.learning.module_brain import as_brain

    try:
        brain.load(as_brain(module, brain.n_observations, brain.groups).state())
    except ValueError as error:
        allowed = (
            "a module of the class that policy.network names, "
            "or a Sequential of Linear and Tanh for the built-in network"
        )
        raise ConfigError(
            [Problem((name,), str(error), type(module).__name__, allowed, source="policies")]
        ) from None


def load_weights(brain: PolicyNetwork, path: Path, config: WorldConfig, name: str) -> None:
    """Load trained weights of a species; raise ConfigError with the problem of the file.

    For a file without names, only the shapes are checked, unless it belongs to a shipped world.
    """
    try:
        arrays, names = weights.read(read_bytes(path, weights.MOST_BYTES))
        if names is None and WORLDS in path.parents:
            names = _names_of_shipped(path)
        if names is not None:
            _require_names(names, names_of(config, name))
        brain.load(arrays)
    except (ValueError, OSError) as error:
        fault = getattr(error, "strerror", None) or str(error)
        raise ConfigError(
            [Problem(("species", name, "policy"), fault, str(path), "weights of this species' network")]
        ) from None


def names_of(config: WorldConfig, name: str) -> dict[str, Any]:
    """Return the names in a file of weights, as `ecs_eco.learning.weights` stores them."""
    species = config.species[name]
    gaits = {} if species.locomotion is None else dict(species.locomotion.speed)
    return {
        "channels": list(species.channels(config.dims)),
        "options": species.groups(),
        "gaits": gaits,
        "version": versions()["ecs-eco"],
    }


@cache
def _names_of_shipped(path: Path) -> dict[str, Any]:
    return names_of(load(path.parent.name), path.stem)


def name_weights(path: str | Path, config: WorldConfig, name: str) -> Path:
    """Write the names of a species into a file of weights without changing the weights: for a file without
    names, or if the species was renamed. Raises ValueError, OSError."""
    return weights.save(path, weights.load(path), names_of(config, name))


def _require_names(theirs: Mapping[str, Any], mine: Mapping[str, Any]) -> None:
    """Raise ValueError for weights of a species with other sensors or options, or another order."""
    for word in ("channels", "options", "gaits"):
        file = _in_order(theirs, word)
        here = _in_order(mine, word, file)
        if file == here:
            continue
        lacking, new = ([x for x in some if x not in others] for some, others in ((file, here), (here, file)))
        what = f"in the file {listed(file)}, here the same in another order, {listed(here)}"
        if lacking or new:
            what = "; ".join(
                f"{listed(some)} only {where}"
                for some, where in ((lacking, "in the file"), (new, "here"))
                if some
            )
        raise ValueError(f"was trained with other {word}: {what}")


def _in_order(names: Mapping[str, Any], word: str, first: Sequence[str] = ()) -> list[str]:
    """Return names in the order that matters to a policy; equally fast gaits as in `first`."""
    if word == "options":
        return [f"{group}.{option}" for group, options in names[word].items() for option in options]
    if word == "gaits":
        speeds = names[word]
        return sorted(dict.fromkeys([*(g for g in first if g in speeds), *speeds]), key=speeds.__getitem__)
    return list(names[word])


def require_policies(config: WorldConfig, policies: Policies) -> None:
    """Raise ConfigError unless these are sources of policies, or a dict of them and torch modules."""
    # if torch is not imported, no value can be a torch module
    torch = sys.modules.get("torch")
    kinds = (str, Path, *((torch.nn.Module,) if torch is not None and isinstance(policies, Mapping) else ()))
    by_species(
        "policies",
        policies,
        config.species,
        kinds,
        f"{listed(POLICIES)}, a folder, or in a dict a torch module",
    )


def sources_in_words(config: WorldConfig, policies: Policies) -> dict[str, str]:
    """Return the source of each species' policy as text for a checkpoint; a module has none."""
    sources = {name: source_of(policies, name) for name in config.species}
    return {
        name: (
            "untrained"
            if not isinstance(source, str | Path)
            else source
            if source in POLICIES
            else str(Path(source).absolute())
        )
        for name, source in sources.items()
    }


def source_of(policies: Policies, name: str) -> str | Path | torch.nn.Module:
    """Return the source of one species' policy."""
    return policies.get(name) or "trained" if isinstance(policies, Mapping) else policies


def weights_files(config: WorldConfig, policies: Policies) -> dict[str, Path]:
    """Return the files of a world's initial policies, by species; `policies` as in `build`.

    Raises ConfigError for a missing file.
    """
    files = {}
    for name, species in config.species.items():
        source = source_of(policies, name)
        if species.policy.thinks and isinstance(source, str | Path):
            path = weights_file(config, name, source)
            if path is not None:
                files[name] = path
    return files


def weights_file(config: WorldConfig, name: str, source: str | Path) -> Path | None:
    """Return the file of a species' initial policy, None for a fresh network; raise ConfigError."""
    if source == "trained":
        file = config.species[name].policy.file
        return config.file(file) if file else None
    if source in ("untrained", "random"):
        return None
    folder = Path(source)
    if not folder.is_dir():
        allowed = f"{listed(POLICIES)}, or a folder of <species>.safetensors"
        fault = "unknown source of policies"
        raise ConfigError([Problem((), fault, str(source), allowed, nearest(source, POLICIES), "policies")])
    path = folder / f"{name}.safetensors"
    if not path.is_file():
        needed = "<species>.safetensors for every species with a policy"
        raise ConfigError([Problem((), "missing", str(path), needed, source="policies")])
    return path


def policy(world: SpatialWorld, species: str, uid: int | None = None) -> Any:
    """Return a copy of a species' policy as a torch module in evaluation mode, or of the organism `uid` if
    each organism has its own.

    Raises UnknownName, and ConfigError if there is no network, or several and no `uid`.
    """
    from ecs_eco.learning.module_brain import as_module

    table = world.table(species)
    nerves = table.species.nerves
    if nerves is None or (nerves.brain is None and nerves.individuals is None):
        raise ConfigError(
            [Problem((species,), "has no policy network", allowed="a species with one", source="policy")]
        )
    if nerves.individuals is None:
        return as_module(nerves.brain)
    if uid is None:
        what = f"each {species} has its own policy"
        raise ConfigError(
            [Problem((species,), what, allowed="a uid in addition to the species", source="policy")]
        )
    _, row = world.locate(uid)
    return nerves.individuals.module(table[Policy].weights[np.array([row])][0])
