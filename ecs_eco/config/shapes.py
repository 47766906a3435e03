"""The shapes of networks whose weights genes can encode, before any network exists."""

from functools import partial
from itertools import pairwise
from typing import Any

from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.genomes.traits import Shapes


def shapes_of_networks(config: WorldConfig, name: str) -> dict[str, Shapes]:
    """Return the shapes of the matrices and biases of a species' networks, by the trait of their weights.

    The shapes of a torch module are missing if its code is not allowed to run or it cannot be created.
    """
    species = config.species[name]
    shapes: dict[str, Shapes] = {}
    if species.policy.network is None and not species.ranges():
        shapes["policy.weights"] = policy_shapes(species, config.dims)
    elif any(gene.trait == "policy.weights" for gene in (species.genome.genes if species.genome else ())):
        known = _of_module(config, species)
        shapes |= {} if known is None else {"policy.weights": known}
    return shapes | {trait: network.shapes for trait, network in instincts(config, name).items()}


def instincts(config: WorldConfig, name: str) -> dict[str, Any]:
    """Return a species' reflex and happiness networks from `fit_network`, by the trait of their weights;
    networks in code that is not allowed to run are left out."""
    found = {}
    for word in ("reflex", "happiness"):
        function = getattr(getattr(config.species[name], word), "function", None)
        network = None if function is None else config.known(function)
        if hasattr(network, "shapes") and hasattr(network, "each"):
            found[f"{word}.weights"] = network
    return found


def policy_shapes(species: Species, dims: int) -> list[tuple[int, ...]]:
    """Return the shapes of an individual policy's matrices and biases, in the order of its weights."""
    widths = [len(species.channels(dims)), *species.policy.hidden, sum(_options(species)) + 1]
    return [shape for a, b in pairwise(widths) for shape in ((a, b), (b,))]


def _options(species: Species) -> list[int]:
    """Return the number of options in each discrete action group that the policy chooses from."""
    chosen = {group for group, _ in species.decisions()} - species.ranges().keys()
    return [max(len(actions), 2) for group, actions in species.groups().items() if group in chosen]


def _of_module(config: WorldConfig, species: Species) -> Shapes | None:
    """Return the shapes of a torch module's trainable parameters, or None if there is no module."""
    from ecs_eco.learning.continuous import CONTINUOUS
    from ecs_eco.learning.mlp import MLP
    from ecs_eco.learning.module_brain import made

    network: Any = partial(MLP, hidden=tuple(species.policy.hidden))
    if species.policy.network is not None:
        network = config._code.known(species.policy.network)
    groups = (*_options(species), *(CONTINUOUS for _ in species.ranges()))
    try:
        module = None if network is None else made(network, len(species.channels(config.dims)), groups, 0)
        return None if module is None else [tuple(p.shape) for p in module.parameters() if p.requires_grad]
    except (ValueError, AttributeError):  # the error is reported when the world is built
        return None
