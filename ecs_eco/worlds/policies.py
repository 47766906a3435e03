"""What policies a world begins with: fresh networks, weights in files, torch modules that were handed over;
and how they are had again."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ecs_eco.components import Policy
from ecs_eco.config import WorldConfig
from ecs_eco.config.reading import read_bytes
from ecs_eco.engine.arguments import by_species
from ecs_eco.engine.errors import ConfigError, Problem, listed, nearest
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

MOST_BYTES_OF_WEIGHTS = 100_000_000  # more than the largest network allowed needs
POLICIES = ("trained", "random", "untrained")
Policies: TypeAlias = "str | Path | Mapping[str, str | Path | torch.nn.Module]"
"""Where policies come from: one of POLICIES, a folder, or by species one of these or a module."""
Learn: TypeAlias = bool | Mapping[str, bool] | None
"""Which species learn: all, none, or by species; None: as the world file says."""
Shape = tuple[int, tuple[int, ...], tuple[int, ...]]  # channels, options of each group, hidden layers


def fresh_brain(config: WorldConfig, name: str, policy: PolicyConfig, shape: Shape, seed: int) -> Any:
    """Return a fresh network of a species, or say what is wrong with the module that it names."""
    with _refusals_of(name, policy, shape):
        return brain_of(config.function(policy.network), *shape, seed=seed, device=policy.device)


def fresh_individuals(
    config: WorldConfig, name: str, policy: PolicyConfig, shape: Shape, ppo: PPO, seed: int
) -> Any:
    """Return the networks of individuals, or say what is wrong with the module that their species names."""
    with _refusals_of(name, policy, shape):
        return individuals_of(
            config.function(policy.network), *shape, ppo=ppo, seed=seed, device=policy.device
        )


@contextmanager
def _refusals_of(name: str, policy: PolicyConfig, shape: Shape) -> Iterator[None]:
    """Within, what cannot be a species' network is refused with its place in the world file."""
    try:
        yield
    except (ValueError, AttributeError, ImportError) as error:
        key = ("species", name, "policy", "network" if policy.network else "device")
        given = function_name(policy.network) if policy.network else policy.device
        raise ConfigError(
            [
                Problem(
                    key,
                    str(error),
                    given,
                    f"a torch module for {shape[0]} observations and the groups of options "
                    f"{shape[1]} (docs/explanation/learning.md)",
                )
            ]
        ) from None


def outside_of(world: SpatialWorld, name: str, policy: PolicyConfig) -> Any:
    """Return who decides for a species that has no network: a function, or nobody yet."""
    if policy.kind == "function":
        return Function(world.config.function(policy.function), policy.function)
    expect(world)
    return Nobody()


def take_weights(brain: PolicyNetwork, module: torch.nn.Module, name: str) -> None:
    """Give a brain the weights of a module that was handed over."""
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
    """Load trained weights of a species; raises ConfigError that says what is wrong with the file.

    Of a file without names only the shapes are checked.
    """
    try:
        arrays, names = weights.read(read_bytes(path, MOST_BYTES_OF_WEIGHTS))
        if names is not None:
            _require_names(names, names_of(config, name))
        brain.load(arrays)
    except (ValueError, OSError) as error:
        raise ConfigError(
            [Problem(("species", name, "policy"), str(error), str(path), "weights of this species' network")]
        ) from None


def names_of(config: WorldConfig, name: str) -> dict[str, Any]:
    """Return the names that a file of weights has of its species, as `ecs_eco.learning.weights` keeps them."""
    species = config.species[name]
    gaits = {} if species.locomotion is None else dict(species.locomotion.speed)
    return {
        "channels": list(species.channels(config.dims)),
        "options": species.groups(),
        "gaits": gaits,
        "version": versions()["ecs-eco"],
    }


def name_weights(path: str | Path, config: WorldConfig, name: str) -> Path:
    """Write the names of a species into a file of weights, whose weights stay as they are: for a file that
    has none, or whose species was renamed since. Raises ValueError, OSError."""
    return weights.save(path, weights.load(path), names_of(config, name))


def _require_names(theirs: Mapping[str, Any], mine: Mapping[str, Any]) -> None:
    """Raise ValueError for weights of a species that senses or chooses in other names, or in another order."""
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
    """Return names in the order that matters to a policy: gaits from slow to fast, those as fast as each
    other as in `first`; options with their groups."""
    if word == "options":
        return [f"{group}.{option}" for group, options in names[word].items() for option in options]
    if word == "gaits":
        speeds = names[word]
        return sorted(dict.fromkeys([*(g for g in first if g in speeds), *speeds]), key=speeds.__getitem__)
    return list(names[word])


def require_policies(config: WorldConfig, policies: Policies) -> None:
    """Raise ConfigError unless these are sources of policies: texts, folders,
    or a dict of these and of torch modules."""
    # a module is made of it: where nobody has loaded torch, nobody hands one over
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
    """Return where the policy of each species comes from, as a checkpoint holds it; a module has no words."""
    sources = {name: source_of(policies, name) for name in config.species}
    return {
        name: str(source) if isinstance(source, str | Path) else "untrained"
        for name, source in sources.items()
    }


def source_of(policies: Policies, name: str) -> str | Path | torch.nn.Module:
    """Return where the policy of one species comes from."""
    return policies.get(name) or "trained" if isinstance(policies, Mapping) else policies


def weights_files(config: WorldConfig, policies: Policies) -> dict[str, Path]:
    """Return the files that a world's policies start from, by species; `policies` as in `build`.

    Raises ConfigError for a missing one.
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
    """Return the file that the policy of a species starts from, None for a fresh network; raises ConfigError."""
    if source == "trained":
        file = config.species[name].policy.file
        return config.file(file) if file else None
    if source in ("untrained", "random"):
        return None
    folder = Path(source)
    if not folder.is_dir():
        allowed = f"{listed(POLICIES)}, or a folder of <species>.safetensors"
        raise ConfigError(
            [
                Problem(
                    (),
                    "unknown source of policies",
                    str(source),
                    allowed,
                    nearest(source, POLICIES),
                    "policies",
                )
            ]
        )
    path = folder / f"{name}.safetensors"
    if not path.is_file():
        needed = "<species>.safetensors for every species with a policy"
        raise ConfigError([Problem((), "missing", str(path), needed, source="policies")])
    return path


def policy(world: SpatialWorld, species: str, uid: int | None = None) -> Any:
    """Return a copy of a species' policy as a torch module in evaluation mode,
    or of the organism `uid` where each has its own.

    Raises UnknownName, and ConfigError where there is no network, or several and no `uid`.
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
        what = f"each {species} has a policy of its own"
        raise ConfigError([Problem((species,), what, allowed="a uid beside the species", source="policy")])
    _, row = world.locate(uid)
    return nerves.individuals.module(table[Policy].weights[np.array([row])][0])
