"""The whole world file."""

import hashlib
import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PrivateAttr

from ecs_eco.config.features.feature import of_each
from ecs_eco.config.former import by_former_names
from ecs_eco.config.models.archipelago import Archipelago
from ecs_eco.config.models.interventions import AnyIntervention, AnyUse, Tick
from ecs_eco.config.models.reporters import Reporter
from ecs_eco.config.models.search import Data, Search, Ticks, Viewer
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.surroundings import Ambient, ObjectType, ScalarField, Space, Terrain
from ecs_eco.config.models.water import Sun, Water, Year
from ecs_eco.config.names import code_of, is_component
from ecs_eco.engine.submodel import Submodel
from ecs_eco.inputs.code import NONE, Code
from ecs_eco.inputs.parameters import applied
from ecs_eco.inputs.section import (
    FENCE,
    FREE,
    CodeEntry,
    Name,
    Pair,
    Positive,
    Section,
    Share,
    Use,
    WithParameters,
    about,
    quantity,
    table,
)


class Ramp(Section):
    """A number that changes linearly during training, in steps."""

    key: str = about("dotted key of a number, such as species.krill.diet.0.chance")
    values: Pair = about("values at the start and at the end")
    duration: Share = quantity(
        "fraction of training over which it changes; then it is constant", "1", 1.0, former="until"
    )

    def at(self, share: float) -> float:
        """Return the number's value after a given fraction of the training."""
        first, last = self.values
        return last if share >= self.duration else first + (last - first) * share / self.duration


class Training(Section):
    """Pre-training: settings for policies that learn before the ecosystem runs."""

    submodel = Submodel(
        "Learning",
        where=("policy.file",),
        reads=("training",),
        rules={
            "": "Policies with a file were trained before the run, in this world with the changes under "
            "`training`.",
            "training.respawn": "In training there are no births of animals; each animal that dies is "
            "replaced at a random position.",
            "training.average": "The policy's weights are averaged over the last fraction `average` of the "
            "training.",
        },
    )

    ticks: Ticks = quantity("length", "ticks", 1000)
    average: Annotated[float, Field(ge=0, le=1)] = quantity(
        "last fraction of the training, over which weights are averaged", "1", 0.2
    )
    respawn: bool = about(
        "whether animals that die are replaced immediately and animals have no births", True
    )
    set: dict[str, Any] = table("dotted key = value during training", dict)
    worlds: Annotated[int, Field(ge=1, le=64)] = about(
        "number of worlds that train the same policies at once", 1
    )
    vary: dict[str, Annotated[list[int | float], Field(min_length=2, max_length=2)]] = table(
        "dotted key = [low, high]: each world draws its value from a different one of as many equal parts of "
        "this range, on a log scale if both ends are positive",
        dict,
    )
    renew: Tick = quantity(
        "ticks after which the worlds restart, with different values of `vary`; 0: never", "ticks", 0
    )
    pool: Annotated[float, Field(ge=0, le=1)] = quantity(
        "probability that a species in any world but the first uses an earlier, frozen policy until the next "
        "restart",
        "1",
        0.0,
    )
    ramp: list[Ramp] = table("numbers that change during training", list)


class WorldConfig(Section):
    """A world: space, species and objects, and everything that happens to them."""

    format: Literal[1] = about("version of this format")
    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$", max_length=60)] = about(
        "name, used for folders"
    )
    title: Annotated[str, Field(max_length=200)] = about("title for readers", "", change=FREE)
    description: Annotated[str, Field(max_length=20_000)] = about("a few sentences", "", change=FREE)
    code: Annotated[list[CodeEntry], Field(max_length=50)] = table(
        'custom code that this file names: files next to it ("sir.py"), '
        'installed modules ("mypackage.ecology"); runs only if you allow it',
        list,
    )
    ticks: Ticks = quantity("default length of a run", "ticks", 1000, change=FREE)
    dt: Positive = quantity("length of a tick", "s", 1.0)
    seed: Annotated[int, Field(ge=0, lt=2**63)] = about("default seed of a run", 1, change=FREE)
    space: Space = about("size and edges of the space")
    terrain: Terrain | None = about("the shape of the ground; absent: flat", None, change=FENCE)
    ambient: Ambient = table("state of the environment", Ambient)
    sun: Sun | None = about("the sun; absent: light is always ambient.light", None)
    year: Year | None = about("the year; absent: sun.year, if given", omit=True)
    water: Water | None = about("the water that fills a volume; absent: none", None)
    substances: dict[Name, Annotated[str, Field(max_length=1000)]] = table(
        "name = description, for each chemical substance", dict, entries=FREE
    )
    fields: dict[Name, ScalarField] = table("scalar fields by name", dict)
    objects: dict[Name, ObjectType] = table("types of inanimate objects by name", dict)
    species: Annotated[dict[Name, Species], Field(min_length=1, max_length=128)] = about("species by name")
    training: Training = table("pre-training", Training, change=FREE)
    systems: list[WithParameters] = table(
        "module:name of custom systems, each at the end of its phase; with parameters: "
        '{ use = "module:name", … }',
        list,
    )
    reporters: dict[str, Reporter] = about(
        "name = a measurement made in every tick and recorded next to the counts of the species: a formula "
        "such as mean(Metabolism.energy), or module:name of a function of the world",
        {},
        omit=True,
    )
    record: Annotated[list[str], Field(max_length=64)] = about(
        "Component.field, also of custom components, to record at birth, at death and in snapshots",
        [],
        omit=True,
    )
    interventions: list[AnyIntervention] = table("interventions during a run", list, change=FREE)
    land_use: list[AnyUse] = about("continuous harvests and plantings", [], omit=True)
    archipelago: Archipelago | None = about(
        "islands that exchange migrants, each a world as described in this file; absent: a single world",
        omit=True,
    )
    data: Data | None = about("measurements to compare the world with; absent: none", omit=True)
    search: Search = table("settings of `ecs-eco search`; runs ignore them", Search, exclude=True)
    viewer: Viewer = table("controls that the viewer shows first; runs ignore them", Viewer, exclude=True)
    patterns: list[str] = table(
        "patterns by which to evaluate the world, for `ecs-eco describe`; runs ignore them",
        list,
        exclude=True,
    )

    _folder: Path = PrivateAttr(default_factory=Path)  # folder for relative file names
    _source: str = PrivateAttr(default="dict")  # for messages
    _code: Code = PrivateAttr(default=NONE)  # the source files listed in `code`, as read
    _renamed: tuple[str, ...] = PrivateAttr(default=())  # notes on keys given under their former names
    _land: Any = PrivateAttr(default=None)  # the Land read from terrain.raster

    @property
    def dims(self) -> int:
        """2 in a plane, 3 in a volume."""
        return len(self.space.size)

    def felt(self, kind: str) -> tuple[str, ...]:
        """Return the properties and substances of a kind's bodies; remains also have the dead organism's."""
        if kind in self.species:
            return (*self.species[kind].felt(), *self.own_fields(kind))
        left = (
            name
            for species in self.species.values()
            if species.remains == kind
            for name in (*species.properties, *species.substances)
        )
        return tuple(dict.fromkeys((*self.objects[kind].felt(), *left)))

    def own_components(self, species: Species) -> list[Any]:
        """Return the custom components of a species; None for those invalid or not yet allowed to run."""
        brought = [part for place, part in of_each(species, "brings") if place is None]
        own = [part for part in brought if not part.__module__.startswith("ecs_eco.")]
        unknown = [None] if species.model_extra else []  # for features that might not be loaded yet
        return [*map(self.known, species.components), *own, *unknown]

    def own_fields(self, kind: str) -> dict[str, float]:
        """Return the name (Component.field) and default of every number in the loaded custom components."""
        components = filter(is_component, self.own_components(self.species[kind]))
        return {
            f"{c.__name__}.{field}": float(default)
            for c in components
            for field, (type_, default) in c.fields.items()
            if not type_.shape
        }

    def may_have(self, kind: str, name: str) -> bool:
        """Return whether a name could be a field in code that is not yet allowed to run."""
        return "." in name and kind in self.species and None in self.own_components(self.species[kind])

    def family(self, name: str) -> tuple[str, ...]:
        """Return the species whose members count as kin of a species."""
        return (name, *(one for one, s in self.species.items() if name in of_each(s, "becomes")))

    def have_parents(self) -> frozenset[str]:
        """Return the species whose members must know their parents."""
        young = {name for name, species in self.species.items() if any(of_each(species, "becomes"))}
        known = [name for name, species in self.species.items() if species.knows_kin()]
        if self.archipelago is not None:  # migrants keep their ancestry
            known += self.archipelago.migration_probability
        return frozenset(young.union(*map(self.family, known)))

    def bearers(self, property: str) -> list[str]:
        """Return the object types, then the species, by name, whose bodies have a property or substance."""
        kinds = (*sorted(self.objects), *sorted(self.species))
        return [kind for kind in kinds if property in self.felt(kind)]

    @property
    def folder(self) -> Path:
        """The world file's folder, to which file names are relative."""
        return self._folder

    def file(self, name: str) -> Path:
        """Return the path of a file named in the world file.

        Parameters
        ----------
        name : str
            Relative to the folder of the world file.

        Returns
        -------
        Path

        Examples
        --------
        >>> from ecs_eco.config import load
        >>> load("predator-prey").file("counts.csv").name
        'counts.csv'
        """
        return self._folder / name

    def function(self, name: object) -> Any:
        """Return the object that "module:name" refers to, with its parameters, or a function unchanged.

        Parameters
        ----------
        name : str, Use or callable

        Returns
        -------
        object

        Raises
        ------
        CodeError
            If it does not exist or is not allowed to run.

        Examples
        --------
        >>> from ecs_eco.config import load
        >>> load("predator-prey").function(len)([3, 4])
        2
        """
        if isinstance(name, Use):
            return applied(self._code.function(name.use), name.parameters)
        return self._code.function(name)

    def known(self, name: object) -> Any:
        """Return the object of "module:name" without parameters; None if invalid or not allowed to run."""
        return self._code.known(name.use if isinstance(name, Use) else name)

    def resolved(self, former: bool = False) -> dict[str, Any]:
        """Return every value, including defaults, with JSON types.

        Parameters
        ----------
        former : bool, default False
            Whether to use the former names of keys, so that renaming a key does not change hashes or digests.

        Returns
        -------
        dict
            Loads as a world with the same `config_hash`.

        Examples
        --------
        >>> from ecs_eco.config import load
        >>> load("predator-prey").resolved()["dt"]
        1.0
        """
        data = by_former_names(self) if former else self.model_dump(mode="json")
        if not (code := code_of(self)):
            del data["code"]
            return data
        return data | {"code": code}

    @property
    def config_hash(self) -> str:
        """SHA-256 of the resolved configuration, its code and its land, as 64 hexadecimal digits."""
        text = json.dumps(self.resolved(former=True), separators=(",", ":"), allow_nan=False)
        text += "".join(s.sha256 for s in self._code.sources)
        text += self._land.sha256 if self._land is not None else ""
        return hashlib.sha256(text.encode()).hexdigest()
