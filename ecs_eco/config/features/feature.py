"""Declaration of features, and assembly of the models of species and object types from them."""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Any, ClassVar, NamedTuple, TypeVar

from ecs_eco.config.rules import Key, WorldSections
from ecs_eco.engine.errors import Problem
from ecs_eco.inputs.section import Section

Model = TypeVar("Model", bound=Section)


class Cost(NamedTuple):
    """Energy that members burn per second."""

    key: Key  # within the species' section
    value: float  # [energy/s] or, if `most` is given, [energy] per unit
    most: float | None = None  # for costs per unit: maximum units per second
    owed: bool = False  # whether it is burned even when no energy is left


class Feature(Section):
    """A feature of species: keys in their sections of the world file, with their checks and effects.

    Derive a class and declare its keys as fields. Override the functions below that the feature needs; in them,
    `species` is the whole section and `key` its path, ("species", name). Object types can have features, too,
    with the path ("objects", name).

    Attributes
    ----------
    systems : tuple of type
        Systems of a custom feature, each added at the end of its phase; `ecs_eco.systems.ORDER`
        lists the systems of shipped features.
    acts : Mapping of str to tuple of str
        Action groups that the feature adds, with their actions; None if `acting` yields them.

    Notes
    -----
    The class keyword `after` names the species key after which the feature's keys appear in references and
    files.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.config import Feature, Section, quantity
    >>> class Glow(Section):
    ...     power: float = quantity("light of one animal", "W", 0.1)
    >>> class Glowing(Feature):
    ...     glow: Glow | None = None
    >>> squid = {"count": 3, "body": {"radius": 0.1}, "glow": {"power": 0.5}}
    >>> sea = {"format": 1, "name": "sea", "space": {"size": [9.0, 9.0]}, "species": {"squid": squid}}
    >>> World.from_config(sea, features=[Glowing]).table("squid").species.glow.power
    0.5
    """

    after: ClassVar[tuple[str, ...]] = ()
    systems: ClassVar[tuple[type[Any], ...]] = ()
    acts: ClassVar[Mapping[str, tuple[str, ...] | None]] = {}

    def __init_subclass__(cls, after: str | tuple[str, ...] = (), **other: Any) -> None:
        super().__init_subclass__(**other)
        cls.after = (after,) if isinstance(after, str) else after

    @staticmethod
    def problems(species: Any, config: WorldSections, key: Key) -> Iterator[Problem]:
        """Yield problems with the feature's keys, checked together with the other sections.

        Parameters
        ----------
        species : Species
            The section.
        config : WorldConfig
        key : tuple of str or int
            Path of the section.

        Yields
        ------
        Problem

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> from ecs_eco.engine.errors import Problem
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def problems(species, config, key):
        ...         if species.glow and not config.sun:
        ...             yield Problem((*key, "glow"), "is useless", allowed="a world with a sun")
        """
        yield from ()

    @staticmethod
    def acting(species: Any) -> Iterator[tuple[str, str, list[str]]]:
        """Yield action groups that depend on the feature's keys.

        Parameters
        ----------
        species : Species
            The section.

        Yields
        ------
        tuple
            The group, the word used for an action in messages, and the actions.

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def acting(species):
        ...         yield "glow", "color in glow.colors", species.glow.colors
        """
        yield from ()

    @staticmethod
    def causes(species: Any, key: Key) -> Iterator[tuple[Key, str]]:
        """Yield the causes of death that this feature adds.

        Parameters
        ----------
        species : Species
            The section.
        key : tuple of str or int
            Path of the section.

        Yields
        ------
        tuple
            The key that adds the cause, and the cause.

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def causes(species, key):
        ...         yield (*key, "glow", "power"), "burned out"
        """
        yield from ()

    @staticmethod
    def becomes(species: Any) -> Iterator[str]:
        """Yield the species that members turn into.

        Parameters
        ----------
        species : Species
            The section.

        Yields
        ------
        str

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def becomes(species):
        ...         yield species.glow.adult
        """
        yield from ()

    @staticmethod
    def makes(species: Any) -> Iterator[str]:
        """Yield the object types that members make.

        Parameters
        ----------
        species : Species
            The section.

        Yields
        ------
        str

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def makes(species):
        ...         yield species.glow.spark
        """
        yield from ()

    @staticmethod
    def feels(species: Any) -> Iterator[tuple[str, str]]:
        """Yield body properties that this feature adds, which members can sense and die from.

        Parameters
        ----------
        species : Species
            The section.

        Yields
        ------
        tuple
            The property, and the field that contains it: "Component.field", 0 at birth.

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def feels(species):
        ...         yield "warmth", "Glow.warmth"
        """
        yield from ()

    @staticmethod
    def costs(species: Any) -> Iterator[Cost]:
        """Yield the energy costs of members, for the notes of `ecs-eco check`.

        Parameters
        ----------
        species : Species
            The section.

        Yields
        ------
        Cost

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> from ecs_eco.config.features.feature import Cost
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def costs(species):
        ...         yield Cost(("glow", "power"), species.glow.power)
        """
        yield from ()

    @staticmethod
    def meets(species: Any) -> Iterator[tuple[str, str, float]]:
        """Yield the bodies that members look for nearby at the end of a tick.

        Parameters
        ----------
        species : Species
            The section.

        Yields
        ------
        tuple
            The key, the species or object type, and the maximum distance between the bodies' surfaces [m].

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def meets(species):
        ...         yield "glow.partner", species.glow.partner, species.glow.reach
        """
        yield from ()

    @staticmethod
    def times(species: Any) -> Iterator[tuple[str, float]]:
        """Yield durations that are rounded up to whole ticks.

        Parameters
        ----------
        species : Species
            The section.

        Yields
        ------
        tuple
            The key, and the duration [s].

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def times(species):
        ...         yield "glow.period", species.glow.period
        """
        yield from ()

    @staticmethod
    def undivided(species: Any) -> Iterator[tuple[str, str]]:
        """Yield keys that prevent a world from being divided among processes.

        Parameters
        ----------
        species : Species
            The section.

        Yields
        ------
        tuple
            The key, and the reason as text.

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def undivided(species):
        ...         if species.glow:
        ...             yield "glow", "light reaches all bands"
        """
        yield from ()

    @staticmethod
    def brings(species: Any) -> Iterator[tuple[str | None, type[Any]]]:
        """Yield the components that this feature needs.

        Parameters
        ----------
        species : Species
            The section.

        Yields
        ------
        tuple
            The object type whose objects have the component, or None if members of the species have it; and
            the component.

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def brings(species):
        ...         if species.glow:
        ...             yield None, Glow
        """
        yield from ()

    @staticmethod
    def furnish(species: Any, table: Any, tables: Mapping[str, Any]) -> None:
        """Connect the table of a species with other tables, once all tables have their components.

        Parameters
        ----------
        species : Species
            The section.
        table : Table
            The table of the species.
        tables : Mapping of str to Table
            All tables.

        Examples
        --------
        >>> from ecs_eco.config import Feature
        >>> class Glowing(Feature):
        ...     @staticmethod
        ...     def furnish(species, table, tables):
        ...         table.species.lamps = [tables[name] for name in species.glow.lamps]
        """


def of_each(species: Section, what: str, *more: object) -> Iterator[Any]:
    """Yield the results of the `Feature` function `what` for all features of a section."""
    model: type[Section] = type(species)
    for hook in _hooks_of(model, what):
        yield from hook(species, *more)


@cache
def _hooks_of(model: type[Section], what: str) -> tuple[Callable[..., Iterator[Any]], ...]:
    hooks = dict.fromkeys(getattr(feature, what) for feature in features_of(model))
    return tuple(hook for hook in hooks if hook is not getattr(Feature, what))


@cache
def features_of(model: type[Section]) -> tuple[type[Feature], ...]:
    """Return the features of a model of species or object types, in the same order as its keys."""
    return tuple(c for c in model.__mro__ if Feature in c.__bases__ and "after" in vars(c) and c is not model)


def assembled(model: type[Model]) -> type[Model]:
    """Return a model with the keys of its features in the order used by pages and files."""
    fields = dict(model.model_fields)
    for feature in features_of(model):
        own = {name: fields.pop(name) for name in feature.model_fields}
        names = list(fields)
        at = next((names.index(key) + 1 for key in feature.after if key in fields), len(names))
        fields = {n: fields[n] for n in names[:at]} | own | {n: fields[n] for n in names[at:]}
    model.__pydantic_fields__ = fields
    model.model_rebuild(force=True)
    return model
