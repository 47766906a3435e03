"""What all organisms of a species, or all objects of a type, share."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from ecs_eco.config.models.energy import Diet, Lethal
    from ecs_eco.config.models.heat import Heat
    from ecs_eco.config.models.life import Breeding, Care, Growth, Hatching
    from ecs_eco.config.models.matter import AnyExchange, Decomposition, Emission, Reaction
    from ecs_eco.config.models.objects import Build, Carry, Motion, Store
    from ecs_eco.config.models.reproduction import AnyReproduction
    from ecs_eco.config.models.species import Species as SpeciesConfig
    from ecs_eco.engine.table import Table
    from ecs_eco.genomes.heredity import Heredity
    from ecs_eco.nervous.nerves import Nerves


@dataclass(slots=True)
class Species:
    """What systems read of a species or object type: set by `worlds.apply`, when a world is built and when
    its configuration changes.

    What differs between organisms is a component. An object type has a body and nothing else; a table that
    was made by hand has the defaults.
    """

    config: SpeciesConfig | None = None
    """Its section of the world file; None for objects and for tables made by hand."""
    is_object: bool = False
    """Whether it is inanimate: it has no row in the series and no ledger."""

    # the body
    radius: float | None = None
    """Radius of the largest body [m]: genes, and the dead that become objects,
    may make it larger than the file's."""
    opaque: bool | None = None
    """Whether sight stops at its bodies; None, if unset: it does, and newborn may still be placed there."""
    solid: bool = False
    """Whether nothing else can be where its bodies are."""
    sinking: float = 0.0
    """Speed at which its bodies sink in water [m/s]."""
    color: str = "#888888"
    emits: dict[str, float] = field(default_factory=dict)
    """Field → what each body emits into it [amount/s]."""
    compressible: bool = False
    """Whether the pressure in its bodies is that of their place."""
    heat: Heat | None = None
    """How its bodies exchange heat; None: they keep their temperature."""
    reactions: list[Reaction] = field(default_factory=list)
    """What its metabolism makes of its substances."""
    exchange: list[AnyExchange] = field(default_factory=list)
    """What its bodies take up from fields and give off."""
    decomposition: Decomposition | None = None
    """How its objects decay; None: they do not."""
    emissions: dict[str, Emission] = field(default_factory=dict)
    """Field → what each body emits into it of a substance that it holds."""
    born_with: str = "declared"
    """Where the substances of newborn come from: "declared", "mother" or "soil"."""
    standard_mass: float | None = None
    """Mass to which its costs of living refer [kg], where growth or a gene makes masses differ."""

    used: bool = False
    """Whether people harvest or plant its members."""

    # of objects
    store: Store | None = None
    """The energy that they hold; None: none."""
    upkeep: tuple[int, float] = (0, 0.0)
    """The number to which they come back, and the rate at which each missing one does [1/s]."""

    motion: Motion | None = None
    """How they move by themselves; None: they do not."""
    pushed: bool = False
    """Whether solid bodies push them away."""

    # nerves and genes
    nerves: Nerves | None = None
    gaits: tuple[Any, ...] | None = None
    """The effect of its actions of locomotion: layout, speeds, costs, turns, climbs, pitches, drag."""
    own_ranges: frozenset[int | None] = frozenset()
    """Sensors whose radius is individual."""
    own_places: frozenset[int | None] = frozenset()
    """Sensors whose place on the body is individual."""
    traits: dict[str, int] = field(default_factory=dict)
    """Keys of its section whose values are each organism's own, and their places in Traits."""
    heredity: Heredity | None = None

    # living and dying
    torpor: bool = False
    """Whether those without energy are torpid; else their energy falls below 0."""
    diet: list[Diet] = field(default_factory=list)
    eaten: dict[str, float] = field(default_factory=dict)
    """Food → what all of them gained by eating it in the last tick [energy]."""
    lethal: list[Lethal] = field(default_factory=list)
    """Properties and the interval in which it can live."""
    carries: list[Carry] = field(default_factory=list)
    builds: list[Build] = field(default_factory=list)
    remains: str | None = None
    """The object type that its dead become."""
    sex: str = "none"
    max_count: int | None = None
    """Births stop at this number of living."""
    refused: int = 0
    """Births that it refused since a recorder last noted them."""
    reproduction: AnyReproduction | None = None
    care: Care | None = None
    """How its parents feed their young; None: they do not."""
    growth: Growth | None = None
    """How the young grow; None: they are born as large as adults."""
    breeding: Breeding | None = None
    """How its fertility depends on age and season; None: it stays what it was at birth."""
    eggs: Table | None = None
    """The table of its eggs; None: it lays none."""
    hatch: Hatching | None = None
    """Who hatches from them, and when; None: they are no eggs."""
    barren: bool = False
    """Whether an intervention has switched its reproduction off."""

    # caches of systems, kept from tick to tick
    life_history: tuple[Any, tuple[Any, ...]] | None = None
    sites: np.ndarray | None = None

    def switch_reproduction(self, on: bool) -> None:
        """Let its members reproduce as its section of the world file says, or not at all."""
        self.barren = not on
        self.reproduction = getattr(self.config, "reproduction", None) if on else None

    def parts(self) -> dict[str, Any]:
        """Return the parts that may have a state of their own, by name."""
        return {name: part for name in ("heredity", "nerves") if (part := getattr(self, name)) is not None}
