"""Checks across the sections of a world: whether all names exist and the values are consistent."""

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from ecs_eco.config.archipelago import check_archipelago
from ecs_eco.config.checks.body import check_body, check_object
from ecs_eco.config.checks.genome import check_genome
from ecs_eco.config.checks.interventions import Changed, check_interventions, check_land_use, check_line
from ecs_eco.config.checks.nerves import check_nerves
from ecs_eco.config.checks.reporters import check_code, check_record, check_reporters
from ecs_eco.config.checks.resolution import check_resolution
from ecs_eco.config.features.feature import of_each
from ecs_eco.config.measurements import check_data
from ecs_eco.config.models.interventions import Cull, Harvest
from ecs_eco.config.models.surroundings import Terrain
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import Key, at_most, inside, named, not_too_fine
from ecs_eco.engine.errors import MOST, ConfigError, Problem, unknown
from ecs_eco.inputs.section import RESERVED

MOST_CELLS = 100_000_000  # maximum number of cells in one field or in the height map
MOST_INDEX_CELLS = 4_000_000
MOST_CAUSES = 255  # causes of death, each stored as one byte
MOST_STEPS = 1000  # diffusion steps per tick
MOST_LAYERS = 100_000  # layers of water
MOST_CLASSES = 250  # classes of land
ALONE = ("band", "crs", "corner", "scale", "vertical", "missing", "cover", "classes", "layers", "drainage")


def check(config: WorldConfig, folder: Path, changed: Changed) -> list[Problem]:
    """Return at most MOST + 1 problems across the sections of a world; file names are relative to `folder`.

    For `changed`, see `check_interventions`.
    """
    return list(islice(_all(config, folder, changed), MOST + 1))


def _all(config: WorldConfig, folder: Path, changed: Changed) -> Iterator[Problem]:
    for part in (
        _check_causes,
        _check_names,
        _check_space,
        _check_fields,
        _check_terrain,
        check_land,
        check_code,
        check_water,
        _check_year,
    ):
        yield from part(config)
    for name, kind in config.objects.items():
        yield from check_object(config, name, kind)
    for name in config.species:
        yield from check_body(config, name)
        yield from check_nerves(config, name, folder)
        yield from check_genome(config, name)
    yield from check_resolution(config)
    yield from check_interventions(config, folder, changed)
    for part in (check_land_use, check_reporters, check_record, check_data, check_archipelago):
        yield from part(config)


def _check_names(config: WorldConfig) -> Iterator[Problem]:
    for section in ("species", "objects", "fields", "substances"):
        for name in getattr(config, section):
            if name in RESERVED or (section in ("species", "objects") and name in ("any", "wall")):
                yield Problem((section, name), "a reserved word", name, "any other name")
    for name in config.objects:
        if name in config.species:
            yield Problem(("objects", name), "a species has the same name", name, "a unique name")


def _check_causes(config: WorldConfig) -> Iterator[Problem]:
    """Yield a problem if there are too many causes of death, at the key of the first beyond the maximum."""
    known = {"culled"}
    for key, cause in _causes(config):
        known.add(cause)
        if len(known) > MOST_CAUSES:
            allowed = f"at most {MOST_CAUSES} in a world, including being eaten by each species"
            yield Problem(key, "too many causes of death", cause, allowed)
            return


def _causes(config: WorldConfig) -> Iterator[tuple[Key, str]]:
    for name, species in config.species.items():
        yield from of_each(species, "causes", ("species", name))
    for name, kind in config.objects.items():
        if kind.energy is not None:
            yield ("objects", name, "energy"), "decayed"
        yield from of_each(kind, "causes", ("objects", name))
    for i, use in enumerate(config.land_use):
        if isinstance(use, Harvest):
            yield ("land_use", i, "cause"), use.cause
    for i, intervention in enumerate(config.interventions):
        if isinstance(intervention, Cull):
            yield ("interventions", i, "cause"), intervention.cause


def _check_space(config: WorldConfig) -> Iterator[Problem]:
    space = config.space
    if space.cell is not None:
        key, size, automatic = ("space", "cell"), space.size, ", or remove it for an automatic size"
        yield from at_most(key, "larger than the world", space.cell, min(size))
        yield from not_too_fine(key, "neighbor index", space.cell, size, MOST_INDEX_CELLS, or_else=automatic)


def _check_fields(config: WorldConfig) -> Iterator[Problem]:
    space = config.space
    most = min(space.size[:2]) / (2 if space.edges == "torus" else 1)
    for name, field in config.fields.items():
        yield from _check_field_of_substance(config, name)
        key = ("fields", name, "cell")
        sides = [min(field.cell, s) for s in space.size]
        # side * side can underflow to 0
        steps = field.diffusion * config.dt * sum(2 / 0.9 / side / side for side in sides)
        wrong = [*at_most(key, space.too_wide, field.cell, most)]
        wrong += not_too_fine(key, "field", field.cell, space.size, MOST_CELLS)
        yield from wrong
        if not wrong and steps > MOST_STEPS:
            fault = f"too fast for these cells: {steps:.3g} steps a tick"
            allowed = f"at most {field.diffusion * MOST_STEPS / steps:.3g} m^2/s"
            yield Problem(("fields", name, "diffusion"), fault, field.diffusion, allowed)


def _check_field_of_substance(config: WorldConfig, name: str) -> Iterator[Problem]:
    """Yield all problems with a field's substance."""
    field, key = config.fields[name], ("fields", name)
    if field.substance is not None and field.substance not in config.substances:
        yield unknown((*key, "substance"), "substance", field.substance, config.substances)
    for part in ("depth", "initial", "renewal", "only"):
        if field.substance is None and getattr(field, part) is not None:
            allowed = "a substance for the field, or remove this key"
            yield Problem((*key, part), "given without a substance", getattr(field, part), allowed)
    if field.depth is not None and config.dims == 3:
        yield Problem((*key, "depth"), "a volume has its own depth", field.depth, "remove depth")
    ground = config.terrain
    if field.only == "lakes" and (ground is None or not (ground.lakes or ground.raster)):
        yield Problem((*key, "only"), "there are no lakes", field.only, "terrain.lakes, or remove `only`")


def _check_year(config: WorldConfig) -> Iterator[Problem]:
    """Yield a problem if the year is given twice."""
    if config.year is not None and config.sun is not None and config.sun.year is not None:
        fault = "given together with the section year"
        yield Problem(("sun", "year"), fault, config.sun.year, "either year.length or sun.year")


def _check_terrain(config: WorldConfig) -> Iterator[Problem]:
    terrain, size = config.terrain, config.space.size
    if terrain is None:
        return
    most = min(size[:2]) / 2
    yield from at_most(("terrain", "cell"), "larger than half the width of the world", terrain.cell, most)
    yield from not_too_fine(("terrain", "cell"), "map", terrain.cell, size[:2], MOST_CELLS)
    for i, road in enumerate(terrain.roads):
        yield from check_line(("terrain", "roads", i, "line"), road.line, config)
    for group in ("mountains", "rocks", "lakes"):
        for i, mark in enumerate(getattr(terrain, group)):
            key = ("terrain", group, i)
            yield from inside((*key, "at"), mark.at, size[:2])
            yield from at_most((*key, "radius"), "larger than half the width of the world", mark.radius, most)
            if group == "mountains" and mark.height == 0:
                yield Problem((*key, "height"), "a mountain with height 0", mark.height, "more than 0 m")


def check_water(config: WorldConfig) -> Iterator[Problem]:
    """Yield all problems with water, sinking and swimming."""
    yield from _check_volume(config)
    water, size = config.water, config.space.size
    if water is None:
        return
    if config.dims == 2:
        yield Problem(("water",), "a plane has no depth", allowed="a 3D space, or remove water")
        return
    for name in water.shading:
        yield from named(("water", "shading", name), "species", name, config.species)
    if water.layer > size[2] or size[2] / water.layer > MOST_LAYERS:
        allowed = f"at most {size[2]:g} m, and at least {size[2] / MOST_LAYERS:g}"
        yield Problem(("water", "layer"), "not possible in this water", water.layer, allowed)
    for i, current in enumerate(water.current):
        for axis, speed in enumerate(current.velocity):
            if abs(speed) * config.dt > (most := size[axis] / 2):
                fault = "moves more than half the world's width in a tick"
                yield Problem(
                    ("water", "current", i, "velocity"), fault, speed, f"at most {most / config.dt:g} m/s"
                )
    if water.current and water.current_function is not None:
        fault = "given together with a current by depth"
        yield Problem(("water", "current_function"), fault, allowed="either current or current_function")


def _check_volume(config: WorldConfig) -> Iterator[Problem]:
    bodies = [("species", n, s.body) for n, s in config.species.items()] + [
        ("objects", n, o.body) for n, o in config.objects.items()
    ]
    for section, name, body in bodies:
        if body.sinking and config.dims == 2:
            fault, allowed = "a plane has no up and down", "0, or a 3D space"
            yield Problem((section, name, "body", "sinking"), fault, body.sinking, allowed)
    for name, species in config.species.items():
        way = species.locomotion
        if way is not None and way.pitch and way.climb:
            allowed = "either climb or pitch"
            yield Problem(
                ("species", name, "locomotion", "pitch"), "given together with climb", way.pitch, allowed
            )


def check_land(config: WorldConfig) -> Iterator[Problem]:
    """Yield all problems with real land; if there are none, read the land into the world."""
    terrain = config.terrain
    if terrain is None:
        return
    if terrain.raster is None:
        for part in ALONE:
            if getattr(terrain, part):
                yield Problem(("terrain", part), "given without a raster", allowed="terrain.raster as well")
        return
    problems = [*_agreement(config, terrain)]
    yield from problems
    size = config.space.size
    if problems or config._land is not None or size[0] / terrain.cell * (size[1] / terrain.cell) > MOST_CELLS:
        return
    from ecs_eco.config.land.land import read_land  # imported only here, because few worlds have real land

    try:
        config._land = read_land(terrain, size, config.folder)
    except ConfigError as error:
        yield from (p.moved(key=("terrain", *p.key)) for p in error.problems)


def _agreement(config: WorldConfig, terrain: Terrain) -> Iterator[Problem]:
    key = ("terrain",)
    if config.space.edges == "torus":
        fault = "its opposite edges differ, but a torus joins them"
        yield Problem((*key, "raster"), fault, terrain.raster, 'space.edges = "walls"')
    if config.dims == 3:
        yield Problem((*key, "raster"), "given in a volume", terrain.raster, "a space.size with two numbers")
    if terrain.hills is not None:
        yield Problem((*key, "hills"), "given together with a raster", allowed="only one of them")
    if terrain.cover_band is not None and terrain.cover is None:
        yield Problem(
            (*key, "cover_band"), "given without cover", terrain.cover_band, "terrain.cover as well"
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
            allowed = "codes, above, below, steeper, or a layer with this class as `land`"
            yield Problem(at, "does not define where it is", allowed=allowed)
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
        yield Problem(
            (*key, "drainage"), "does not define where water collects", allowed="sea, depth or stream"
        )
