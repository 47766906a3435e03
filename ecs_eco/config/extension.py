"""Models of worlds whose species have custom features."""

from collections.abc import Iterator
from difflib import get_close_matches
from functools import lru_cache
from typing import Annotated, Any

from pydantic import ConfigDict, Field, create_model

from ecs_eco.config.features.feature import Feature, assembled
from ecs_eco.config.models.species import Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.names import own_features
from ecs_eco.engine.errors import Problem
from ecs_eco.inputs.code import Code
from ecs_eco.inputs.section import Name

Features = tuple[type[Feature], ...]


def model_for(code: Code, handed: Features = ()) -> type[WorldConfig]:
    """Return the model of a world. Its species have the features passed in Python and those defined in its
    code; they can have any key if that code is not yet allowed to run."""
    features = (*handed, *(f for f in code.subclasses(Feature) if f not in handed))
    return world_with(features, bool(code.sources) and not code.allowed)


@lru_cache(100)
def world_with(features: Features, any_key: bool = False) -> type[WorldConfig]:
    """Return the model of worlds whose species also have these features or, with `any_key`, any keys."""
    if not features and not any_key:
        return WorldConfig
    config = {"model_config": ConfigDict(extra="allow")} if any_key else {}
    members = {"__module__": __name__, "__doc__": Species.__doc__, **config}
    species: Any = assembled(type("Species", (*features, Species), members))
    known = WorldConfig.model_fields["species"]
    table = Annotated[dict[Name, species], Field(min_length=1, max_length=128)]
    model = create_model(
        "WorldConfig",
        __base__=WorldConfig,
        __module__=__name__,
        __doc__=WorldConfig.__doc__,
        species=(table, Field(description=known.description)),
    )
    setattr(model, "__reduce__", _reduced)  # noqa: B010 (mypy rejects assignments to methods)
    return model


def unknown_keys(config: WorldConfig) -> Iterator[Problem]:
    """Yield keys that are most likely misspelled, in species that can have any key."""
    for name, species in config.species.items():
        for key, value in (species.model_extra or {}).items():
            if near := get_close_matches(key, Species.model_fields, n=1, cutoff=0.85):
                yield Problem(("species", name, key), "unknown key", value, "a key of species", near[0])


def _reduced(config: Any) -> tuple[Any, ...]:
    """Return how to pickle a world whose model is created here and cannot be imported in other processes."""
    handed = tuple(f for f in own_features(config) if not config._code.subclasses(Feature, f))
    data = config.model_dump() | {"search": config.search, "viewer": config.viewer}
    return _restored, (config._code, handed, data, dict(config.__pydantic_private__ or {}))


def _restored(code: Code, handed: Features, data: dict[str, Any], private: dict[str, Any]) -> WorldConfig:
    config = model_for(code, handed).model_validate(data)
    object.__setattr__(config, "__pydantic_private__", private)
    return config
