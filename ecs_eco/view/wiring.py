"""How a nervous system is wired, for the page: which readings lead to reflexes and happiness, and how."""

from __future__ import annotations

from typing import Any

from ecs_eco.analysis.nervous_diagram import diagram, nervous_species


def wiring(config: Any, species: str) -> dict[str, Any]:
    """Return {"wiring": …} of a species with nerves, else {}.

    `reflexes` are [rows of readings, row of the action, what it does]; `all` says of reflex, policy and
    happiness whether every reading may lead to it, as where it is a function or a network.
    """
    if config is None or species not in nervous_species(config):
        return {}
    d = diagram(config, species)
    reflexes = [[[row for row, _ in reflex.sources], reflex.action, reflex.label] for reflex in d.reflexes]
    happiness = d.happiness
    return {
        "wiring": {
            "reflexes": reflexes,
            "function": d.function,
            "policy": d.policy.label,
            "happiness": None if happiness is None else happiness.label,
            "felt": [] if happiness is None else [row for row, _ in happiness.sources],
            "all": {
                "reflex": bool(d.function),
                "policy": bool(d.policy.layers),
                "happiness": happiness is not None and not happiness.sources,
            },
        }
    }
