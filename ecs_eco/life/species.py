"""What all organisms of a species, or all objects of a type, share."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ecs_eco.config.features.feature import Feature
from ecs_eco.config.models.species import Species as SpeciesConfig
from ecs_eco.config.models.surroundings import ObjectType
from ecs_eco.inputs.section import Section

if TYPE_CHECKING:
    import numpy as np

    from ecs_eco.config.features.chemistry import Emission
    from ecs_eco.config.features.feeding import Diet
    from ecs_eco.config.models.reproduction import AnyReproduction
    from ecs_eco.engine.table import Table
    from ecs_eco.genomes.heredity import Heredity
    from ecs_eco.nervous.nerves import Nerves

DERIVED = {"emits", "diet", "reproduction"}  # keys whose value here is not that of the world file


@dataclass
class Species:
    """What systems read of a species or object type: every key of its section of the world file, by the name
    of the key, and what follows from these keys or changes while the world lives.

    `worlds.apply` adopts the section when a world is built and when its configuration changes. A key that
    the section lacks, or any key of a table without a section, has its default.
    """

    config: SpeciesConfig | None = None
    """The species' section of the world file; None for object types and for tables without a section."""
    is_object: bool = False
    """Whether it is an object type: it has no row in the series and no ledger."""

    # of the body
    radius: float | None = None
    """Radius of the largest body [m]: genes, and the dead that become objects,
    may make it larger than the section's."""
    opaque: bool | None = None
    """Whether its bodies block sight; None, if unset: they do, and newborn may still be placed there."""
    solid: bool = False
    """Whether its bodies keep other bodies out."""
    sinking: float = 0.0
    """Speed at which its bodies sink in water [m/s]."""
    compressible: bool = False
    """Whether the pressure in its bodies is that of their place."""
    emits: dict[str, float] = field(default_factory=dict)
    """Field → what each body emits into it [amount/s]."""
    emissions: dict[str, Emission] = field(default_factory=dict)
    """Field → what each body emits into it of a substance that it contains."""
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
    diet: list[Diet] = field(default_factory=list)
    """Its diet, in order of the names of what it eats."""
    eaten: dict[str, float] = field(default_factory=dict)
    """Food → the energy that all its members gained from it in the last tick."""
    reproduction: AnyReproduction | None = None
    """How it reproduces; None: it does not, or an intervention has switched it off."""
    barren: bool = False
    """Whether an intervention has switched its reproduction off."""
    refused: int = 0
    """Births that `max_count` refused since a recorder last noted them."""
    nursery: Table | None = None
    """The table that its newborn enter; None: its own."""

    # caches of systems, kept from tick to tick
    life_history: tuple[Any, tuple[Any, ...]] | None = None
    sites: np.ndarray | None = None

    def __getattr__(self, key: str) -> Any:
        """Return the default of a key that the section does not have, and keep it."""
        if not key.startswith("_"):
            for model in sections():
                known = model.model_fields.get(key)
                if known is not None and not known.is_required():
                    vars(self)[key] = known.get_default(call_default_factory=True)
                    return vars(self)[key]
        raise AttributeError(f"neither a species nor an object type has {key!r}")

    def adopt(self, section: Section) -> None:
        """Take the values of all keys of a section."""
        vars(self).update({key: value for key, value in section if key not in DERIVED})

    def switch_reproduction(self, on: bool) -> None:
        """Let its members reproduce as its section of the world file says, or not at all."""
        self.barren = not on
        self.reproduction = getattr(self.config, "reproduction", None) if on else None

    def parts(self) -> dict[str, Any]:
        """Return the parts that may have a state of their own, by name."""
        return {name: part for name in ("heredity", "nerves") if (part := getattr(self, name)) is not None}


def sections() -> tuple[type[Section], ...]:
    """Return the models of species, of object types, and of features."""
    return SpeciesConfig, ObjectType, *Feature.__subclasses__()
