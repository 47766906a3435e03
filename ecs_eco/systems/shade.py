"""Floating bodies dim the light below."""

from ecs_eco.components import Position
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.space.world import SpatialWorld


class Shade(System):
    """Bodies that cast shade are counted layer by layer, from the surface down, before light is used."""

    phase = "environment"
    divisible = True
    submodel = Submodel("Water", where=("water",))
    world: SpatialWorld

    def process(self, *_: object) -> None:
        """Compute the light profile of this tick."""
        world = self.world
        if world.environment.water is None:
            return
        shades = {} if world.config is None or world.config.water is None else world.config.water.shading
        tables = [(world.tables[name], area) for name, area in shades.items()]
        world.environment.water.shade((t.alive[: t.high], t[Position].z, area) for t, area in tables)
