"""Checks of real land: what belongs together, and whether the files hold what the world needs."""

from collections.abc import Iterator

from ecs_eco.config.models.surroundings import Terrain
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.errors import ConfigError, Problem, unknown

ALONE = ("band", "crs", "corner", "scale", "vertical", "missing", "cover", "classes", "layers", "drainage")
MOST_CLASSES = 250
MOST_CELLS = 100_000_000  # of the height map, which another check refuses


def check_land(config: WorldConfig) -> Iterator[Problem]:
    """All problems of real land; where there are none, the world has read it."""
    terrain = config.terrain
    if terrain is None:
        return
    if terrain.raster is None:
        for part in ALONE:
            if getattr(terrain, part):
                yield Problem(("terrain", part), "given without a raster", allowed="terrain.raster beside it")
        return
    problems = [*_agreement(config, terrain)]
    yield from problems
    size = config.space.size
    if problems or config._land is not None or size[0] / terrain.cell * (size[1] / terrain.cell) > MOST_CELLS:
        return
    from ecs_eco.config.land.land import read_land  # not at the top: other worlds need no numpy to be checked

    try:
        config._land = read_land(terrain, size, config.folder)
    except ConfigError as error:
        yield from (p.moved(key=("terrain", *p.key)) for p in error.problems)


def _agreement(config: WorldConfig, terrain: Terrain) -> Iterator[Problem]:
    key = ("terrain",)
    if config.space.edges == "torus":
        yield Problem(
            (*key, "raster"),
            "its edges do not meet as those of a torus do",
            terrain.raster,
            'space.edges = "walls"',
        )
    if config.dims == 3:
        yield Problem((*key, "raster"), "given in a volume", terrain.raster, "space.size of two numbers")
    if terrain.hills is not None:
        yield Problem((*key, "hills"), "given together with a raster", allowed="one of the two")
    if terrain.cover_band is not None and terrain.cover is None:
        yield Problem(
            (*key, "cover_band"), "given without cover", terrain.cover_band, "terrain.cover beside it"
        )
    if len(terrain.classes) > MOST_CLASSES:
        yield Problem(
            (*key, "classes"), f"there are {len(terrain.classes)}", allowed=f"at most {MOST_CLASSES}"
        )
    named = {layer.land for layer in terrain.layers}
    for name, land in terrain.classes.items():
        at = (*key, "classes", name)
        if land.codes and terrain.cover is None:
            yield Problem((*at, "codes"), "there is no raster of classes", land.codes, "terrain.cover")
        if land.above is not None and land.below is not None and land.above >= land.below:
            yield Problem(
                (*at, "below"), f"not above `above`, {land.above:g}", land.below, "a higher elevation"
            )
        if (
            not land.codes
            and name not in named
            and all(v is None for v in (land.above, land.below, land.steeper))
        ):
            yield Problem(
                at,
                "nowhere: it says not where it is",
                allowed="codes, above, below, steeper, or a layer with this class as `land`",
            )
    for i, layer in enumerate(terrain.layers):
        place = (*key, "layers", i, "land")
        if layer.make != "class" and layer.land is not None:
            yield Problem(place, f"given for {layer.make}", layer.land, 'make = "class"')
        elif layer.make == "class" and layer.land is None:
            yield Problem(place, "is missing", allowed="the name of a class")
        elif layer.land is not None and layer.land not in terrain.classes:
            yield unknown(place, "class", layer.land, terrain.classes)
    drainage = terrain.drainage
    if drainage is not None and drainage.sea is drainage.depth is drainage.stream is None:
        yield Problem((*key, "drainage"), "says not where water collects", allowed="sea, depth or stream")
