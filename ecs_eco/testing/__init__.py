"""Conformance checks for components, systems, genomes and worlds, both shipped and custom.

Each check raises an AssertionError with the reason. Helpers for tests: `arrange` sets the state of organisms,
`act` runs one system, `shuffle` permutes rows. The package's own tests are in tests/.
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
