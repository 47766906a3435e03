"""The data about a world that a page needs before it can draw: species, senses, ground, sky, field maps."""

import base64
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ecs_eco.analysis.land import Land, land_at
from ecs_eco.analysis.nervous_diagram import diagram, nervous_species
from ecs_eco.analysis.relief import Relief
from ecs_eco.components import Position, Senses, Shape, Velocity
from ecs_eco.config import WorldConfig
from ecs_eco.config.models.body import Body
from ecs_eco.config.models.species import Species
from ecs_eco.ecosystem import World
from ecs_eco.engine.table import Table
from ecs_eco.space.bodies import extents
from ecs_eco.space.region import Region
from ecs_eco.space.sun import Sun, sine_of_elevation

SEEING = ("nearest", "rays", "approach", "alignment", "property")


def eyes_of(sensors: Iterable[Mapping[str, Any]] | None) -> list[dict[str, Any]]:
    """Return the sensors of a species that reach beyond its body: name, kind, targets, reach [m], field of
    view [rad] and, for rays, their number and direction. `sensors` are as in a manifest."""
    out = []
    for number, sensor in enumerate(sensors or ()):
        if sensor["kind"] not in SEEING:
            continue
        of = sensor.get("target") or sensor.get("targets") or sensor.get("of") or []
        eye = {
            "number": number,
            "name": sensor.get("name") or "",
            "kind": sensor["kind"],
            "targets": [of] if isinstance(of, str) else list(of),
            "reach": float(sensor.get("range") or 0.0),
            "fov": min(float(sensor.get("fov", 2 * math.pi)), 2 * math.pi),
        }
        if sensor["kind"] == "rays":
            eye |= {
                "count": int(sensor["count"]),
                "angle": float(sensor.get("angle", 0.0)),
                "each": sensor.get("report") == "per_ray",
            }
        if sensor.get("kin"):
            eye["kin"] = sensor["kin"]
        out.append(eye)
    return out


def reach_of(world: World, table: Table, row: int) -> dict[str, float]:
    """Return the current reach [m] of those sensors whose reach is individual or depends on light, by number."""
    out = {}
    for number, sensor in enumerate(table.species.sensors):
        if sensor.kind not in SEEING:
            continue
        reach = float(sensor.range)
        if number in table.species.own_ranges:
            reach = float(table[Senses].radius[row, number])
        sight = getattr(sensor, "sight", None)
        if sight is not None:
            p = table[Position]
            places = (np.array([axis[row]], np.float32) for axis in (p.x, p.y, p.z))
            light = float(world.surroundings("light", *places)[0])
            reach = min(reach, float(sensor.blind) + float(sight) * light)
        if reach != float(sensor.range):
            out[str(number)] = round(reach, 3)
    return out


SIDE = 160  # maximum number of map cells along each side
LAYERS = 64  # number of depths in a light map
GROWTH = "growth of the land"


def names_of(world: World) -> list[str]:
    """Return the names of maps over the scene: fields, light that varies in water, plant growth on real land."""
    land = getattr(world.terrain, "land", None)
    more = ["light"] if world.space.volume and "light" in world.environment else []
    return [*more, *world.fields, *([GROWTH] if getattr(land, "growth", None) is not None else [])]


def map_of(world: World, name: str) -> dict[str, Any]:
    """Return the message "field": values u8[ny, nx] from low to high, in base64, from the southwest corner of
    land seen from above, or from the bottom of water seen from the side and averaged over its width. Raises
    KeyError for a name that is not in `names_of`."""
    values, unit = _values(world, name)
    ny, nx = values.shape
    values = values[:: max(1, -(-ny // SIDE)), :: max(1, -(-nx // SIDE))]
    low, high = min(0.0, float(values.min())), float(values.max())
    graded = np.zeros(values.shape, np.uint8)
    if high > low:
        graded = np.rint(255 * (values - low) / (high - low)).astype(np.uint8)
    return {
        "kind": "field",
        "name": name,
        "tick": world.tick,
        "unit": unit,
        "nx": values.shape[1],
        "ny": values.shape[0],
        "low": float(f"{low:.4g}"),
        "high": float(f"{high:.4g}"),
        "values": base64.b64encode(graded.tobytes()).decode(),
    }


def _values(world: World, name: str) -> tuple[np.ndarray, str]:
    """Return the values f64[ny, nx] of a map and their unit."""
    terrain: Any = world.terrain
    if name in names_of(world):
        if name == "light" and name not in world.fields:
            x, y, top = (float(side) for side in world.space.size)
            z = ((np.arange(LAYERS, dtype=np.float32) + 0.5) * (top / LAYERS)).astype(np.float32)
            light = world.surroundings(
                "light", np.full(LAYERS, x / 2, np.float32), np.full(LAYERS, y / 2, np.float32), z
            )
            return light[:, None].astype(np.float64), "of full light"
        if name == GROWTH and name not in world.fields:
            return np.asarray(terrain.land.growth, np.float64), "times normal growth"
        field = world.fields[name]
        lattice = field.value.astype(np.float64)
        flat = lattice.mean(axis=1) if world.space.volume else lattice[0]
        return flat, "mol/L" if field.substance else "per cell"
    raise KeyError(name)


def wiring(config: WorldConfig | None, species: str) -> dict[str, Any]:
    """Return {"wiring": …} for a species with a nervous system, otherwise {}. `reflexes` are [rows of readings,
    row of the action, label]; `all` is whether every reading can affect the reflex, policy and happiness."""
    if config is None or species not in nervous_species(config):
        return {}
    d = diagram(config, species)
    reflexes = [[[row for row, _ in reflex.sources], reflex.action, reflex.label] for reflex in d.reflexes]
    happiness = d.happiness
    return {
        "wiring": {
            "reflexes": reflexes,
            "function": d.function,
            "policy": d.policy.label,
            "happiness": None if happiness is None else happiness.label,
            "felt": [] if happiness is None else [row for row, _ in happiness.sources],
            "all": {
                "reflex": bool(d.function),
                "policy": bool(d.policy.layers),
                "happiness": happiness is not None and not happiness.sources,
            },
        }
    }


COVERS = ("wood", "forest", "tree"), ("crop", "field", "farm"), ("rock", "steep", "bare")
CELLS = 65_536  # maximum number of ground cells sent; larger grounds are sent at a coarser resolution


def kinds_of(world: World) -> tuple[list[str], list[str]]:
    """Return the names of the species and object types that have positions, excluding landmarks."""
    placed = [name for name, table in world.tables.items() if Position in table]
    species = [name for name in world.species_names() if name in placed]
    declared = placed if world.config is None else world.config.objects
    return species, [name for name in placed if name not in species and name in declared]


def coloured_genes(table: Table) -> dict[str, Any]:
    """Return the genes of a species that each code for one number, by name, as codes of `ecs_eco.genomes`."""
    layout: Any = getattr(table.species.heredity, "layout", None)
    return (
        {}
        if layout is None
        else {code.name: code for code in layout.genes if code.trait is not None and not code.width}
    )


def shown_genes(genes: Mapping[str, Any], moves: bool) -> tuple[str | None, str | None]:
    """Return the gene that sizes bodies, and the first other gene of an animal, which draws their stripes."""
    size = next((name for name, code in genes.items() if code.trait.name == "body.radius"), None)
    return size, next((name for name in genes if moves and name != size), None)


def describe(
    world: World, species: list[str], objects: list[str], genes: dict[str, dict[str, Any]]
) -> dict[str, Any]:
    """Return the part of hello that depends on the world: names, sizes, kinds, ground, day."""
    left = {world.tables[name].species.remains for name in species if Velocity in world.tables[name]}
    return {
        "world": world.name,
        "title": getattr(world.config, "title", "") or world.name,
        "dt": world.dt,
        "about": getattr(world.config, "description", ""),
        "seed": world.seed,
        "size": list(world.space.size),
        "edges": world.space.edges,
        "day": day(world),
        "usual_speed": 10.0,
        "species": [_kind(world, name, genes.get(name, {})) for name in species],
        "objects": [
            _kind(world, name, {}) | {"inanimate": True, "remains": name in left} for name in objects
        ],
        "terrain": ground(world),
        "fields": names_of(world),
    }


def switches(world: World, species: list[str]) -> dict[str, dict[str, bool | None]]:
    """Return whether each species reproduces, and whether it learns (None if it never can)."""
    kinds = {name: world.tables[name].species for name in species}
    return {
        name: {
            "reproduction": not kind.barren,
            "learning": bool(kind.nerves.learning) if kind.nerves and kind.nerves.policy else None,
        }
        for name, kind in kinds.items()
    }


def grows(world: World, name: str) -> bool:
    """Return whether a sessile species is a plant (it grows, reproduces or is eaten), not a resting animal."""
    species = {} if world.config is None else world.config.species
    own = species.get(name)
    eaten = any(food.eats == name for other in species.values() for food in other.diet)
    return own is None or own.reproduction is not None or own.metabolism.photosynthesis > 0 or eaten


def _kind(world: World, name: str, genes: Mapping[str, Any]) -> dict[str, Any]:
    table = world.tables[name]
    nerves, moves = table.species.nerves, Velocity in table
    kind = {
        "name": name,
        "color": table.species.color,
        "radius": float(table.species.radius or 0.5),
        "moves": moves,
        "sessile": not moves and grows(world, name),
        "solid": table.species.body.solid,
        "genes": list(genes),
        "units": {gene: code.trait.unit for gene, code in genes.items()},
        "learns": bool(nerves is not None and nerves.learning),
        **({} if table.species.body.opaque else {"opaque": False}),
    }
    config = None if world.config is None else {**world.config.objects, **world.config.species}.get(name)
    if config is None:
        return kind
    sees = eyes_of([sensor.model_dump() for sensor in getattr(config, "sensors", ())])
    own = {key: value for key, value in (("sees", sees), ("look", getattr(config, "look", None))) if value}
    growth = growth_of(config) if isinstance(config, Species) and moves and not world.space.volume else None
    own |= _shows(genes, *shown_genes(genes, moves), kind["radius"], growth)
    return kind | shape_of(config.body) | sizes_of(table, config.body) | wiring(world.config, name) | own


def growth_of(species: Species) -> tuple[str, float, float] | None:
    """Return the variable that sizes the young, its value at full size, and the relative size at 0: the radius,
    or the age, with 60% of the size at birth, until they are fertile or for a tenth of the longest life."""
    ages = [
        getattr(species.reproduction, "age_min", 0.0),
        getattr(species.breeding, "maturity", 0.0),
        *(limit.max / 10 for limit in species.lethal if limit.property == "age" and limit.max),
    ]
    aging = (("age", age, 0.6) for age in ages if age)
    return next(aging, None) if species.growth is None else ("radius", species.body.radius, 0.0)


def _shows(
    genes: Mapping[str, Any],
    size: str | None,
    stripes: str | None,
    radius: float,
    growth: tuple[str, float, float] | None,
) -> dict[str, Any]:
    """Return growth and the genes that show in bodies: the size gene with the lowest and highest radius relative
    to the drawn one, and the stripes gene with its values without and with full stripes (nearer to 0 first)."""
    shown: dict[str, Any] = {"grows": growth} if growth and size is None else {}
    if size is not None:
        shown["size"] = [size, genes[size].low / radius, genes[size].high / radius]
    if stripes is not None:
        shown["stripes"] = [stripes, *sorted((genes[stripes].low, genes[stripes].high), key=abs)]
    return {"shows": shown} if shown else {}


def shape_of(body: Body) -> dict[str, Any]:
    """Return the shape and size [m] of bodies from their section in the world file, or {} for spheres."""
    return {} if body.shape == "sphere" else {"shape": body.shape, "size": list(body.extents)}


def plain_kind(name: str, section: dict[str, Any], color: str | None) -> dict[str, Any]:
    """Return data about a species or an object type from its section in a manifest."""
    body, moves = Body.model_validate(section["body"]), bool(section.get("locomotion"))
    out = {"name": name, "color": color or "#888888", "radius": body.radius} | shape_of(body)
    look = {"look": section["look"]} if section.get("look") else {}
    return out | {"moves": moves, "sessile": not moves, "genes": [], "learns": False} | look


def sized(kinds: list[dict[str, Any]], objects: Mapping[str, np.ndarray], first: int) -> list[dict[str, Any]]:
    """Return object types with the sizes [m] of individual capsules and boxes by uid, counted from `first`.
    `objects` has the position, heading and size f32[n, 7] of each type's objects."""
    out = []
    for kind in kinds:
        size = objects[kind["name"]][:, 4:].round(4).tolist()
        uids = [str(first + i) for i in range(len(size))]
        first += len(size)
        out.append(kind | ({"sizes": dict(zip(uids, size, strict=True))} if kind.get("shape") else {}))
    return out


def sizes_of(table: Table, body: Body) -> dict[str, Any]:
    """Return the sizes [m] of a type's objects by uid, if one differs from the declared size."""
    if Shape not in table or not table.species.is_object or not table.n:
        return {}
    rows = table.by_uid()
    size = np.stack(extents(table)[:3], 1)[rows] + 2 * extents(table)[3][rows, None]
    if np.abs(size - body.extents).max() <= 1e-3 * size.max():
        return {}
    return {"sizes": dict(zip(map(str, table.uid[rows].tolist()), size.round(4).tolist(), strict=True))}


def ground(world: World) -> dict[str, Any] | None:
    """Return heights, landmarks and the colors of real land, or None if the world is flat and open."""
    terrain, config = world.terrain, getattr(world.config, "terrain", None)
    if terrain is None:
        return None
    ny, nx = terrain.height.shape
    every = max(1, math.ceil(math.sqrt(ny * nx / CELLS)))
    heights = _coarser(terrain.height, every).astype("<f4")
    marks: dict[str, Any] = {
        kind: [p.model_dump() for p in getattr(config, kind, ())] for kind in ("rocks", "lakes")
    }
    if terrain.land is not None:  # heights are relative to the lowest point; colors are as on maps
        heights -= heights.min()
        painted = (255 * _coarser(Relief.of(terrain).colours(), every)).astype(np.uint8)
        marks["colours"] = base64.b64encode(painted.tobytes()).decode()
        cover = _cover(terrain.ground, terrain.land.kinds, terrain.land.wet, getattr(config, "classes", ()))
        marks["cover"] = base64.b64encode(_coarser(cover, every).tobytes()).decode()
    return {
        "cell": every * world.space.size[0] / nx,
        "nx": heights.shape[1],
        "ny": heights.shape[0],
        "heights": base64.b64encode(heights.tobytes()).decode(),
        **marks,
    }


def _cover(
    ground: np.ndarray, kinds: np.ndarray, wet: np.ndarray | None, classes: Iterable[str]
) -> np.ndarray:
    """Return the cover of each cell, u8[ny, nx]: 1 woods, 2 crops (by class names), 3 rock, 4 water, 0 other."""
    cover = np.array([0, 4, 3], np.uint8)[ground]
    for number, name in enumerate(classes, 1):
        for code, words in enumerate(COVERS, 1):
            if any(word in name.lower() for word in words):
                cover[(kinds == number) & (ground == 0)] = code
    if wet is not None:
        cover[wet] = 4
    return cover


def _coarser(cells: np.ndarray, every: int) -> np.ndarray:
    """Return every `every`-th cell along each axis."""
    return np.ascontiguousarray(cells[every // 2 :: every, every // 2 :: every])


def uses_of(world: World) -> list[dict[str, Any]]:
    """Return the land uses in effect at this tick, ignoring seasons, as in a world file."""
    uses = () if world.config is None else world.config.land_use
    return [
        use.model_dump()
        for use in uses
        if use.at <= world.tick and (use.until is None or world.tick <= use.until)
    ]


def land_of(world: World) -> Land:
    """Return the fences, roads and land-use areas of a live world."""
    terrain = world.terrain
    there = (
        {}
        if terrain is None
        else {
            "fences": [{"line": corners.tolist()} for corners in terrain.fences],
            "roads": [{"line": road.line.tolist(), "width": road.width} for road in terrain.roads],
        }
    )
    return land_at({"land_use": uses_of(world)}, (), world.tick) | there


def drawn(land: Land) -> dict[str, Any]:
    """Return the land as pages draw it: lines of fences and roads, kinds and borders of areas [m]."""

    def corners(shape: dict[str, Any]) -> list[list[float]]:
        line = shape["line"] if "line" in shape else Region(None, shape["region"]).border()
        rounded: list[list[float]] = np.round(np.array(line, float), 3).tolist()
        return rounded

    return {
        "fences": [corners(fence) for fence in land["fences"]],
        "roads": [{"line": corners(road), "width": road["width"]} for road in land["roads"]],
        "areas": [{"kind": area["kind"], "border": corners(area)} for area in land["areas"]],
    }


def day(world: World) -> dict[str, float] | None:
    """Return the length of a day [s] and the time at tick 0 (fraction since midnight), or None without days."""
    sun = _moving(world)
    return (
        None if sun is None else {"length": float(sun.day), "start": (float(sun.start) + _shift(sun)) % 1.0}
    )


def _moving(world: World) -> Sun | None:
    return None if (sun := world.environment.sun) is None or sun.kind == "constant" else sun


def _shift(sun: Sun) -> float:
    return 0.5 if sun.kind == "inverted" else 0.0


def sky(world: World) -> tuple[float, float]:
    """Return the light at the surface (0 to 1) and the sun's elevation [rad], without days that of this light."""
    sun, full = _moving(world), float(world.ambient["light"])
    if sun is None:
        top = np.array([world.space.size[2] if world.space.volume else 0.0], np.float32)
        x, y = (np.array([s / 2], np.float32) for s in world.space.size[:2])
        light = float(world.surroundings("light", x, y, top)[0]) if "light" in world.environment else full
        return min(max(light, 0.0), 1.0), math.asin(min(max(light, 0.0), 1.0))
    height = sine_of_elevation(
        world.time / sun.day + sun.start + _shift(sun), sun.latitude, sun.season(world.time)
    )
    return min(max(full * sun.light(world.time), 0.0), 1.0), math.asin(min(max(height, -1.0), 1.0))
