"""What all organisms of a species, or all objects of a type, share."""

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

PLAIN = Body(radius=1.0)  # of a table without a section


@dataclass
class Kind:
    """What systems read of the species or object type of a table: its section of the world file, and what
    follows from it or changes while the world lives.

    Every key of the section is an attribute: `table.species.metabolism`. A key that the section lacks, or
    any key of a table without a section, has its default.
    """

    section: Species | ObjectType | None = None
    """Its section of the world file; None for a table made by hand."""

    radius: float | None = None
    """Radius of the largest body [m]: genes, and the dead that become objects,
    may make it larger than the section's."""
    standard_mass: float | None = None
    """Mass to which its costs of living refer [kg], where growth or a gene makes masses differ."""
    used: bool = False
    """Whether land use harvests or plants its members."""

    # nervous system and genes
    nerves: Nerves | None = None
    gaits: tuple[Any, ...] | None = None
    """The effect of its actions of locomotion: layout, speeds, costs, turns, climbs, pitches, drag."""
    own_ranges: frozenset[int | None] = frozenset()
    """Sensors whose radius is individual."""
    own_places: frozenset[int | None] = frozenset()
    """Sensors whose place on the body is individual."""
    traits: dict[str, int] = field(default_factory=dict)
    """Keys of its section whose values are individual, and their places in Traits."""
    heredity: Heredity | None = None

    # life and death
    eaten: dict[str, float] = field(default_factory=dict)
    """Food → the energy that all its members gained from it in the last tick."""
    barren: bool = False
    """Whether an intervention has switched its reproduction off: `reproduction` is None then."""
    refused: int = 0
    """Births that `max_count` refused since a recorder last noted them."""
    nursery: Table | None = None
    """The table that its newborn enter; None: its own."""

    # caches of systems, kept from tick to tick
    life_history: tuple[Any, tuple[Any, ...]] | None = None
    sites: np.ndarray | None = None

    def __getattr__(self, key: str) -> Any:
        """Return the value of a key of the section, or its default where the section lacks it; it is then an
        attribute, until there is another section."""
        if key.startswith("_"):
            raise AttributeError(key)
        vars(self)[key] = value = self._value(key)
        return value

    def __setattr__(self, name: str, value: object) -> None:
        """Set an attribute; what followed from a former section is forgotten."""
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
        """Its diet, in order of the names of what it eats."""
        return sorted(self.diet, key=lambda food: food.eats)

    def feels(self) -> dict[str, str]:
        """Return properties of its bodies that features add, and the fields "Component.field" that they are."""
        return {} if self.section is None else dict(of_each(self.section, "feels"))

    def parts(self) -> dict[str, Any]:
        """Return the parts that may have a state of their own, by name."""
        return {name: part for name in ("heredity", "nerves") if (part := getattr(self, name)) is not None}
