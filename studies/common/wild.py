"""Wild states: extreme values replace numbers in a small world, either through the validation gate or by
bypassing it."""

from __future__ import annotations

import copy
import random
import re
import tempfile
import traceback
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.fuzz.guard import guarded
from studies.common.fuzz.sources import parsed, sources
from studies.common.kernels import kernels, reached
from studies.common.wild_kernels import call_others

TICKS = 2  # [ticks] to run after the numbers change
FEW, HORIZON, HIDDEN = 9, 3, 8  # organisms per species, ticks per rollout, units per layer
FLOCKS = {
    "flock": ("ripe",),
    "choosy-flock": ("ripe", "young", "span"),
}  # each with the genes removed from it
WAYS = ("columns", "spawn", "within a tick", "checkpoint")
PHASES = (
    "environment",
    "sense",
    "feel",
    "learn",
    "decide",
    "move",
    "interact",
    "metabolise",
    "die",
    "reproduce",
    "record",
)
FAILURES = ("out of bounds", "crash", "hang", "traceback", "refused without a location")
PLACES = ("uid ", "spawn", "field '", "terrain: ", "ambient[")  # a refusal must contain one of these
OWN = ("cause", "born", "killer", "uid")
FLOATS = [
    np.nan,
    np.inf,
    -np.inf,
    0.0,
    -0.0,
    1e-45,
    -1e-45,
    1e-38,
    1e38,
    -1e38,
    3.4028235e38,
    -3.4028235e38,
    1e30,
    1e9,
    -1e9,
    1.0,
    -1.0,
    -500.0,
    0.5,
    16_777_217.0,
    2147483648.0,
    9.3e18,
    1.9e19,
    -2147483649.0,
]


def tried(case: dict[str, Any], states: int) -> dict[str, Any]:
    """Return outcome counts by path and kind for some states of one world, and details of the failures."""
    warm(case["source"])
    items = [(case["source"], case["seed"] * 1_000_000 + i) for i in range(states)]
    run = set(reached())
    counts: dict[str, dict[str, int]] = {way: {} for way in WAYS}
    failures = []
    for item, outcome in zip(items, guarded(judge, items, seconds=60.0), strict=True):
        way = way_of(item[1])
        counts[way][outcome["kind"]] = counts[way].get(outcome["kind"], 0) + 1
        run |= set(outcome.pop("kernels", ()))
        if outcome["kind"] in FAILURES:
            failures.append({"item": list(item), "way": way, **outcome})
    return {"states": states, "kinds": counts, "failures": failures, "kernels": sorted(run)}


@cache
def config_of(source: str) -> Any:
    """Return a small version of a world's configuration: few organisms, short rollouts, small networks, all
    policies learning."""
    from ecs_eco.config import load

    data = _flock(source) if source in FLOCKS else parsed(sources()[source][0])
    data.pop("interventions", None)
    for kind in [*data["species"].values(), *data.get("objects", {}).values()]:
        if kind.get("count", 0) > FEW:
            kind["count"] = FEW
        policy = kind.get("policy", {})
        if policy.get("kind", "none") != "none":
            policy.pop("file", None)
            learns = "happiness" in kind
            policy |= {"hidden": [HIDDEN], "learn": learns}
            if learns:
                kind["ppo"] = kind.get("ppo", {}) | {"horizon": HORIZON, "minibatch_size": 16, "epochs": 1}
    return load(data)


def _flock(source: str) -> dict[str, Any]:
    """Return the herd in a small pen, where all animals meet and breed, with various operators; animals with
    hand-written rules have no genes for decisions."""
    data = parsed(sources()["herd"][0])
    data["space"]["size"] = [12.0, 12.0]
    goat = data["species"]["goat"]
    goat["reproduction"] |= {
        "age_min": 0.0,
        "energy_min": 0.2,
        "energy_given": 0.05,
        "reach": 6.0,
        "consent": "none",
        "gestation": 1.0,
        "rest": 0.0,
    }
    goat["actions"]["mate"], goat["automatic"] = ["mate"], ["eat"]
    goat["genome"]["mate"], goat["genome"]["mutate"] = (
        {"operator": "cxUniform", "indpb": 0.3},
        {"operator": "mutShuffleIndexes", "indpb": 0.02},
    )
    goat["genome"]["genes"] = [gene for gene in goat["genome"]["genes"] if gene["name"] not in FLOCKS[source]]
    return data


def warm(source: str) -> None:
    """In this process, compile all kernels that a world calls, so that child processes inherit them."""
    world, chance = fresh(source).run(HORIZON + TICKS), random.Random(0)
    with np.errstate(all="ignore"):
        call_others(world, chance, _odd(world, chance))


def fresh(source: str) -> Any:
    """Return a new small world that has run for some ticks."""
    from ecs_eco import World

    world = World.from_config(config_of(source), policies="untrained")
    if source == "choosy-flock":
        world.tables["goat"].species.heredity.operators.toolbox.register("select_mate", _last)
    return world.run(HORIZON - 1)


def _last(me: int, suitors: list[int], *_: Any) -> int:
    return suitors[-1]


@cache
def _kept(source: str) -> list[Any]:
    from ecs_eco.record import freeze as frozen

    world = fresh(source)
    meta, arrays = frozen.freeze(world)
    # not stored in checkpoints
    ground = None if world.terrain is None else (world.terrain.height.copy(), world.terrain.ground.copy())
    return [world, copy.deepcopy(meta), copy.deepcopy(arrays), ground]


def _world(source: str) -> Any:
    """Return the world in its initial state, reloaded because that is faster than rebuilding it."""
    from ecs_eco.record import freeze as frozen

    kept = _kept(source)
    if kept[0] is None:
        kept[0] = fresh(source)
    frozen.load(kept[0], copy.deepcopy(kept[1]), copy.deepcopy(kept[2]), "memory")
    if kept[3] is not None:
        kept[0].terrain.height[...], kept[0].terrain.ground[...] = kept[3]
    return kept[0]


def way_of(seed: int) -> str:
    """Return the path by which a state's numbers enter the world."""
    return WAYS[(0, 1, 2, 2, 2, 3)[seed % 6]]


def judge(item: tuple[str, int]) -> dict[str, Any]:
    """Return one state's outcome, and the kernels that ran for the first time."""
    before = _called()
    outcome = _judge(item)
    return outcome if _called() == before else outcome | {"kernels": sorted(reached())}


def _called() -> int:
    return sum(bool(kernel.signatures) for kernel in kernels().values())


def _judge(item: tuple[str, int]) -> dict[str, Any]:
    source, seed = item
    chance, way = random.Random(seed), way_of(seed)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            world = _world(source)
            _empty(world, chance)
            {"columns": columns, "spawn": spawn, "within a tick": within, "checkpoint": checkpoint}[way](
                world, chance
            )
            world.run(TICKS)
            call_others(world, chance, _odd(world, chance))
            return {"kind": "ran"}
        except Exception as error:
            outcome = _kind(error, way)
            if outcome["kind"] != "refused" or way == "within a tick":
                _kept(source)[0] = None  # part of a tick may have run
            return outcome


def _kind(error: Exception, way: str) -> dict[str, Any]:
    from ecs_eco.engine.errors import CheckpointError

    message = f"{type(error).__name__}: {error}"[:300]
    if isinstance(error, MemoryError):
        return {"kind": "too little memory"}
    if isinstance(error, IndexError):
        return {"kind": "out of bounds", "said": traceback.format_exc()[-1500:]}
    if isinstance(error, CheckpointError):
        return {
            "kind": "refused" if ".safetensors" in message else "refused without a location",
            "said": message,
        }
    if (
        isinstance(error, ValueError)
        and ("allowed" in message or "expected" in message)
        and any(place in message for place in PLACES)
    ):
        return {
            "kind": "refused"
            if re.search(r"\w\.\w+ is|cause of death|(value|height|ground|source|\]) is", message)
            else "refused without a location",
            "said": message,
        }
    if isinstance(error, FloatingPointError):
        return {"kind": "non-finite number, reported", "said": message}
    if way == "within a tick" and isinstance(
        error, ValueError | OverflowError | ZeroDivisionError | ArithmeticError
    ):
        return {"kind": "stopped with an error", "said": message}
    return {"kind": "traceback", "said": traceback.format_exc()[-1500:]}


# --- changes to a world -------------------------------------------------------------------------------------


def _empty(world: Any, chance: random.Random) -> None:
    """Sometimes remove all organisms of a species."""
    if chance.random() < 0.15:
        table = chance.choice(list(world.tables.values()))
        table.cause[table.rows()] = 1
        world.flush()


def wild(dtype: np.dtype, shape: tuple[int, ...], chance: random.Random, size: float) -> np.ndarray:
    """Return extreme numbers of a type: the same number for all elements, or a different one for each."""

    def one() -> Any:
        if dtype.kind == "b":
            return chance.random() < 0.5
        if dtype.kind in "iu":
            info = np.iinfo(dtype)
            return chance.choice(
                (
                    info.min,
                    info.max,
                    0,
                    1,
                    min(200, info.max),
                    info.max // 2,
                    chance.randint(info.min, info.max),
                )
            )
        return chance.choice(
            [*FLOATS, size, -size, size * 2, size * (1 - 1e-7), chance.uniform(-size, 2 * size)]
        )

    if chance.random() < 0.5:
        return np.full(shape, one()).astype(dtype)
    return np.array([one() for _ in range(int(np.prod(shape)))]).astype(dtype).reshape(shape)


def _odd(world: Any, chance: random.Random) -> Any:
    return lambda dtype, shape: wild(np.dtype(dtype), shape, chance, float(max(world.space.size)))


def columns(world: Any, chance: random.Random) -> None:
    """Write to living organisms' columns between ticks."""
    poke(world, chance, own=False)


def poke(world: Any, chance: random.Random, own: bool) -> None:
    """Write to one to four columns of living organisms, in one, some or all rows; sometimes also to fields,
    ground and surroundings."""
    size = float(max(world.space.size))
    tables = [t for t in world.tables.values() if t.n]
    for _ in range(chance.choice((1, 1, 2, 4)) if tables else 0):
        table = chance.choice(tables)
        rows = np.array(chance.choice((table.rows()[:1], table.rows()[::2], table.rows())))
        places = [(vars(c), f) for c in table.columns.values() for f in vars(c)]
        if chance.random() < 0.3:  # usually in counts
            places = [
                (vars(c), f)
                for k, c in table.columns.items()
                for f in vars(c)
                if k.__name__ in ("Position", "Body", "Velocity")
            ]
        if own and chance.random() < 0.1:
            array = getattr(table, chance.choice(OWN))
        else:
            held, field = chance.choice(places)
            array = held[field]
        array[rows] = wild(np.dtype(array.dtype), (rows.size, *array.shape[1:]), chance, size)
        table.version += 1
    if world.fields and chance.random() < 0.2:
        field = chance.choice(list(world.fields.values()))
        value = chance.choice((field.value, field.source))
        value[...] = wild(value.dtype, value.shape, chance, size)
    if world.terrain is not None and chance.random() < 0.2:
        ground = chance.choice((world.terrain.height, world.terrain.ground))
        ground[...] = wild(ground.dtype, ground.shape, chance, size)
    if chance.random() < 0.1:
        world.ambient[chance.choice(list(world.ambient))] = chance.choice(FLOATS)


def spawn(world: Any, chance: random.Random) -> None:
    """Request newborns with extreme values."""
    table = chance.choice(list(world.tables.values()))
    handles = []
    for component in chance.sample(list(table.columns), min(len(table.columns), chance.choice((1, 1, 2, 3)))):
        values = {}
        for field, default in table.defaults[component].items():
            if chance.random() < 0.5:
                value = wild(default.dtype, default.shape, chance, float(max(world.space.size)))
                values[field] = value if default.shape else value[()]
        handles.append(component(**values))
    world.spawn(table.name, *handles, n=chance.choice((1, 2, 9)))


def within(world: Any, chance: random.Random) -> None:
    """Have a test system write during the next tick, in any phase."""
    import esper

    from ecs_eco.engine.phases import priority_of

    class Poke(esper.Processor):
        def process(self, *_: Any) -> None:
            poke(world, chance, own=True)
            call_others(world, chance, _odd(world, chance))

    poking = Poke()
    # not as a plain processor, because the gate checks those afterwards
    world.schedule.put(poking, priority_of(chance.choice(PHASES), chance.choice((0, 999_998))))
    try:
        world.run(TICKS)
    finally:
        world.schedule.remove(poking)


def checkpoint(world: Any, chance: random.Random) -> None:
    """Load a sealed checkpoint with extreme numbers, types, shapes and rows."""
    from ecs_eco.record import freeze as frozen
    from ecs_eco.record.checkpoint import write

    meta, arrays = frozen.freeze(world)
    meta, arrays = copy.deepcopy(meta), {name: array.copy() for name, array in arrays.items()}
    for _ in range(chance.choice((1, 1, 2))):
        name = chance.choice(
            [n for n in arrays if n.startswith("table/") or chance.random() < 0.2] or list(arrays)
        )
        array = arrays[name]
        way = chance.choice(("wild", "wild", "wild", "rows", "type", "shape", "clock"))
        if way == "wild" and array.size:
            flat = array.reshape(-1)
            at = np.array(chance.choice(([0], list(range(0, flat.size, 2)), list(range(flat.size)))))
            flat[at] = wild(array.dtype, at.shape, chance, float(max(world.space.size)))
        elif way == "rows":
            rows = arrays[f"table/{chance.choice(list(world.tables))}/{chance.choice(('row', 'uid'))}"]
            rows[:] = chance.choice(
                (
                    rows[::-1].copy(),
                    np.full_like(rows, rows[0] if rows.size else 0),
                    rows + rows.dtype.type(2**40),
                )
            )
        elif way == "type":
            arrays[name] = array.astype(
                chance.choice((np.float64, np.float32, np.int64, np.uint8, np.uint64))
            )
        elif way == "shape" and array.size:
            arrays[name] = (
                chance.choice((array[:-1], array.reshape(-1), np.concatenate([array, array]), array[None]))
                if array.ndim
                else array[None]
            )
        elif way == "clock":
            part = chance.choice(("tick", "next_uid", "capacity"))
            value = chance.choice((0, -1, 1, 2**40, 2**63, 2**70, 0.5, "x", None))
            (meta["tables"][chance.choice(list(world.tables))] if part == "capacity" else meta["clock"])[
                part
            ] = value
    with tempfile.TemporaryDirectory(prefix="ecs-eco-wild-") as folder:
        path = Path(folder) / "odd.safetensors"
        write(path, meta, arrays)
        world.load(path)
