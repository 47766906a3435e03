"""From the genome section of a world file to its layout and operators, of fixed or of variable length."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from ecs_eco.engine.code import handed_over
from ecs_eco.genomes.layout import Layout
from ecs_eco.genomes.variable_layout import VariableLayout

if TYPE_CHECKING:
    from ecs_eco.genomes.batch import Operators
    from ecs_eco.genomes.models import GenomeSection
    from ecs_eco.genomes.traits import Shapes, Trait


def layout_of(
    section: GenomeSection,
    traits: Mapping[str, Trait] | None = None,
    shapes: Mapping[str, Shapes] | Shapes | None = None,
) -> Layout:
    """Return the layout of a world file's genome; `shapes` given as a list are those of policy.weights."""
    if section.longest is None:
        return Layout.from_config(section, traits, shapes)
    if shapes is not None and not isinstance(shapes, Mapping):
        shapes = {"policy.weights": shapes}
    return VariableLayout(section, traits, shapes)


def operators_of(
    section: GenomeSection,
    layout: Layout,
    select_mate: str = "nearest",
    find: Callable[[Any], Any] = handed_over,
    mates: bool = True,
) -> Operators:
    """Return the operators of a world file's genome; arguments as `Operators.from_config`."""
    from ecs_eco.genomes.batch import Operators
    from ecs_eco.genomes.variable_births import VariableOperators

    kind = VariableOperators if isinstance(layout, VariableLayout) else Operators
    return kind.from_config(section, layout, select_mate, find, mates)
