"""Conformance checks for components, systems, genomes and worlds: those that ship, and your own.

Each raises AssertionError that says why. Also helpers for tests: `arrange` puts organisms where a test wants
them, `act` lets one system act, `shuffle` permutes rows. The tests of the package itself belong to tests/.
"""

from ecs_eco.testing.component import check_component
from ecs_eco.testing.genome import check_genome
from ecs_eco.testing.states import act, all_threads, arrange, difference, shuffle, state
from ecs_eco.testing.system import check_system
from ecs_eco.testing.world import check_world, watch

__all__ = [
    "act",
    "all_threads",
    "arrange",
    "check_component",
    "check_genome",
    "check_system",
    "check_world",
    "difference",
    "shuffle",
    "state",
    "watch",
]
