"""The shared properties of all organisms of a species, or all objects of a type."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ecs_eco.config.features.feature import Feature, of_each
from ecs_eco.config.models.body import Body
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.inputs.section import Section

if TYPE_CHECKING:
    import numpy as np

    from ecs_eco.config.features.feeding import Diet
    from ecs_eco.engine.table import Table
    from ecs_eco.genomes.heredity import Heredity
    from ecs_eco.nervous.nerves import Nerves

PLAIN = Body(radius=1.0)  # body in a table without a section


@dataclass
class Kind:
    """The properties of a table's species or object type that systems read: its section of the world file,
    values derived from it, and values that change while the world runs.

    Every key of the section is an attribute, as in `table.species.metabolism`. A key that is missing from the
    section, or any key of a table without a section, has its default value.
    """

    section: Species | ObjectType | None = None
    """Its section of the world file; None for a table built by hand."""

    radius: float | None = None
    """Radius [m] of the largest body: genes, and dead organisms that become objects, may make it larger than
    the section's radius."""
    standard_mass: float | None = None
    """Mass [kg] for which metabolic costs are defined, if growth or a gene makes masses differ."""
    used: bool = False
    """Whether land use harvests or plants its members."""

    # nervous system and genes
    nerves: Nerves | None = None
    gaits: tuple[Any, ...] | None = None
    """The effects of the locomotion actions: layout, speeds, costs, turns, climbs, pitches, drag."""
    own_ranges: frozenset[int | None] = frozenset()
    """Sensors whose radius is individual."""
    own_places: frozenset[int | None] = frozenset()
    """Sensors whose position on the body is individual."""
    traits: dict[str, int] = field(default_factory=dict)
    """Keys of its section whose values are individual, and their positions in Traits."""
    heredity: Heredity | None = None

    # life and death
    eaten: dict[str, float] = field(default_factory=dict)
    """Food → the energy that all members gained from it in the last tick."""
    barren: bool = False
    """Whether an intervention has switched off its reproduction: `reproduction` is then None."""
    refused: int = 0
    """Births refused because of `max_count`, and objects because of `most`, since the last record."""
    nursery: Table | None = None
    """The table that newborns enter; None: this table."""

    # the systems' caches, which persist from tick to tick
    life_history: tuple[Any, tuple[Any, ...]] | None = None
    sites: np.ndarray | None = None

    def __getattr__(self, key: str) -> Any:
        """Return the value of a key of the section, or its default if the section lacks it; the value is then
        an attribute until the section is replaced."""
        if key.startswith("_"):
            raise AttributeError(key)
        vars(self)[key] = value = self._value(key)
        return value

    def __setattr__(self, name: str, value: object) -> None:
        """Set an attribute; drop values derived from the previous section."""
        super().__setattr__(name, value)
        if name in ("section", "barren"):
            for key in vars(self).keys() - type(self).__dataclass_fields__.keys():
                del vars(self)[key]

    def _value(self, key: str) -> Any:
        if key == "reproduction" and (self.barren or not isinstance(self.section, Species)):
            return None
        if self.section is not None and key in type(self.section).model_fields:
            return getattr(self.section, key)
        models: tuple[type[Section], ...] = (Species, ObjectType, *Feature.__subclasses__())
        for model in models:
            known = model.model_fields.get(key)
            if known is not None and not known.is_required():
                return known.get_default(call_default_factory=True)
        if key == "body":
            return PLAIN
        raise AttributeError(f"neither a species nor an object type has {key!r}")

    @property
    def is_object(self) -> bool:
        """Whether it is an object type: it has no row in the series and no ledger."""
        return isinstance(self.section, ObjectType)

    @property
    def foods(self) -> list[Diet]:
        """The diet, ordered by the names of the foods."""
        return sorted(self.diet, key=lambda food: food.eats)

    def feels(self) -> dict[str, str]:
        """Return properties that features add to its bodies, and their fields "Component.field"."""
        return {} if self.section is None else dict(of_each(self.section, "feels"))

    def parts(self) -> dict[str, Any]:
        """Return, by name, the parts that can have state of their own."""
        return {name: part for name in ("heredity", "nerves") if (part := getattr(self, name)) is not None}
