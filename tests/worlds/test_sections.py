"""The order of the sections of a world file has no effect."""

from pathlib import Path

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.config.shipped import shipped

EXAMPLES = [path for path in sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))
            if "[space]" in path.read_text()]


def permuted(config, rng):
    """Return a configuration with its sections, and the entries of its diets, in another order."""
    species = {name: kind.model_copy(update={"diet": [kind.diet[i] for i in rng.permutation(len(kind.diet))]})
               for name, kind in config.species.items()}
    sections = {name: dict(getattr(config, name)) for name in ("objects", "fields", "substances")}
    for name, section in (sections | {"species": species}).items():
        kinds = list(section.items())
        other = [kinds[i] for i in rng.permutation(len(kinds))]
        sections[name] = dict(other[::-1] if other == kinds else other)
    return config.model_copy(update=sections)


def digest(config, ticks):
    world = World.from_config(config, seed=1, policies="untrained", record=False)
    world.run(ticks)
    return world.digest(), world.next_uid


@pytest.mark.parametrize("name", [*shipped(), *map(str, EXAMPLES)], ids=lambda name: Path(name).stem)
def test_a_world_is_the_same_whatever_comes_first_in_its_file(name):
    config = load(name, trust=True)
    if config.archipelago is not None:
        pytest.skip("several worlds")
    rng = np.random.default_rng(0)
    assert digest(permuted(config, rng), 3) == digest(config, 3)
