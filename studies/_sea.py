"""What the studies of the sea share: policies by training seed, and four measures of a world in which copepods live."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from _crossed import policies_of

from ecs_eco.analysis import sea
from ecs_eco.analysis.migration import Tracks, approaches, chemotaxis_index, event_average, follow
from ecs_eco.components import Position

__all__ = ["approach", "chemotaxis", "encounters", "life", "policies_of"]
CUE = 1.5  # [m] from a krill: an approach
FAST = 1.4  # [m/s] of krill that chase, and of what is moved past copepods
KRILL, UPPER = 16, (22.0, 29.0)  # how many are moved past them, and between which heights [m]: where copepods feed in the dark
PLUMES, NEAR, FAR = 12, 0.3, 4.0  # how many at a time, and who is counted, by distance [m]
STAY, SPREAD = 12, 2  # [ticks] that a plume stays at a place, and of these before moves are counted


def life(world: Any, days: int) -> dict[str, Any]:
    """How mean depth follows the day in so many days after the first: amplitude as a share of the water, phase, correlation with light.

    `cycle` is None where copepods did not live two whole days.
    """
    from ecs_eco.analysis.runs import load_series

    day = round(world.config.sun.day / world.dt)
    for _ in range(days + 1):
        world.run(day)
        if not world.tables["copepod"].n:
            break
    series = replace(load_series(world.series()), manifest={"config": world.config.resolved(), "dt": world.dt})
    alive = series.of("copepod") > 0
    died = {c: float(series.of("copepod", f"died: {c}").sum() * day / max(series.of("copepod").sum(), 1)) for c in series.causes}
    out = {"copepods": int(series.of("copepod")[-1]), "mean number": float(series.of("copepod").mean()), "days lived": float(alive.sum() / day),
           "deaths per copepod and day": {c: v for c, v in died.items() if v}}  # fmt: skip
    found = sea.depth_cycle(series, "copepod")
    if found is None:
        return out | {"cycle": None}
    hours, depth = sea.hours_of(series, series.ticks), series.of("copepod", "depth_mean")
    lived = alive & (series.ticks >= series.ticks[0] + day)
    eighths = [float(depth[lived & ((hours * 8).astype(int) == k)].mean()) for k in range(8)]
    return out | {"cycle": {"amplitude": found.share, "vector": (found.fit.vector / found.height).tolist(), "lag [days]": found.lag, "p": found.p,
                            "r": found.r, "mean depth": found.fit.mesor, "depth by eighths of a day from midnight": eighths}}  # fmt: skip


def approach(build: Any, kind: str, ticks: int = 150) -> dict[str, Any]:
    """What copepods in the dark do when something of the size of a krill is moved straight past them at the speed of a chase.

    `build(changes)` makes a world. `kind`: "swimming", krill that swim so by themselves; "drifting", krill that are moved so as if by
    water, and smell as any krill; "object", a thing without smell. Nothing is eaten.
    """
    speed = FAST if kind == "swimming" else 0.0
    changes: dict[str, Any] = {
        "ambient.light": 0.0, "species.krill.count": KRILL, "species.krill.diet.0.chance": 0.0, "species.krill.locomotion.turn": 1e-9,
        "species.krill.locomotion.pitch": 1e-9, "species.krill.locomotion.speed": {"wander": speed, "chase": speed},
    }  # fmt: skip
    if kind == "object":
        body = {"radius": 0.4, "mass": 1.0, "opaque": False}
        changes |= {"species.krill.count": 1, "species.krill.emits": {}, "objects.buoy": {"count": KRILL, "body": body}}
    world = build(changes)
    name = "buoy" if kind == "object" else "krill"
    table = world.tables[name]
    rows, random = table.by_uid(), np.random.default_rng(world.seed)
    place = np.stack([random.uniform(0, size, rows.size) for size in world.space.size[:2]])
    heading, z = random.uniform(0, 2 * np.pi, rows.size), random.uniform(*UPPER, rows.size)
    way = FAST * world.dt * np.stack([np.cos(heading), np.sin(heading)])
    size = np.array(world.space.size[:2])[:, None]

    def put(at: np.ndarray) -> None:
        p = table[Position]
        p.x[rows], p.y[rows], p.z[rows] = at[0], at[1], z
        p.heading[rows] = (heading + np.pi) % (2 * np.pi) - np.pi
        table.version += 1

    def drift(world: Any) -> None:
        nonlocal place
        place = (place + way) % size
        put(place)

    put(place)
    world.run(60)  # copepods come up
    put(place)
    tracks = follow(world, ticks, "copepod", name, each=None if kind == "swimming" else drift)
    return escaped(tracks, world.dt)


def escaped(tracks: Tracks, dt: float) -> dict[str, Any]:
    """Speed and direction around approaches, as numbers."""
    found = sea.escapes(tracks, CUE)
    if found is None:
        return {"n": 0}
    k = sea.AROUND
    before = float(np.nanmean(found.speed[:k]))
    return {"n": found.n, "speed": found.speed.tolist(), "away": found.away.tolist(), "before": before, "gain": found.gain,
            "cosine": float(np.nanmean(found.away[k : k + 3])), "latency": found.latency,
            "latency [s]": None if found.latency is None else found.latency * dt}  # fmt: skip


def encounters(world: Any, days: int, after: int = 6) -> dict[str, Any]:
    """How many of those whom a krill came near to are alive so many ticks later; from the second day on."""
    day = round(world.config.sun.day / world.dt)
    world.run(day)
    tracks = follow(world, days * day, within=CUE)
    events = approaches(tracks.distance, CUE, sea.REST)
    events = events[events[:, 0] + after < len(tracks.light)]
    alive = np.array([np.isfinite(tracks.depth[tick + after, animal]) for tick, animal in events.tolist()], bool)
    speed = event_average(tracks.speed, events, 5, 5)
    return {"n": len(events), "survived": float(alive.mean()) if len(events) else None, "speed": speed.tolist(),
            "encounters per copepod and day": len(events) / max(float(np.isfinite(tracks.depth).sum()) / day, 1e-9)}  # fmt: skip


def chemotaxis(build: Any, rounds: int, emits: float = 1.0) -> dict[str, Any]:
    """Whether copepods leave smells of krill without a krill, in the dark, at places where they are: index of moves, and mean cosine.

    Plumes come up to 2 m beside copepods drawn at random, stay for some ticks and go with all smell to others: who is counted was
    not drawn by having stayed.
    """
    body = {"radius": 0.4, "opaque": False}
    at = [[1.0 + i, 1.0, 1.0] for i in range(PLUMES)]
    world = build({"ambient.light": 0.0, "species.krill.count": 0, "objects.plume": {"at": at, "body": body, "emits": {"krill_smell": emits}}})
    world.run(60)  # those below come up
    random, cosines = np.random.default_rng(world.seed), [np.zeros(0)]
    for _ in range(rounds):
        if world.tables["copepod"].n < 2:
            break
        _put_beside(world, random)
        tracks = follow(world, STAY, "copepod", "plume", within=FAR)
        counted = (tracks.distance > NEAR) & (tracks.distance < FAR) & np.isfinite(tracks.away)
        counted[:SPREAD] = False
        cosines.append(tracks.away[counted])
    away = np.concatenate(cosines)
    toward = int((away < 0).sum())
    index = chemotaxis_index(away.size - toward, toward) if away.size else None
    return {"n": int(away.size), "index": index, "cosine": float(away.mean()) if away.size else None}


def _put_beside(world: Any, random: np.random.Generator) -> None:
    """Put each plume beside a copepod, and let what was smelt before be gone."""
    plumes, copepods = world.tables["plume"], world.tables["copepod"]
    rows, p, q = plumes.by_uid(), plumes[Position], copepods[Position]
    beside = random.choice(copepods.by_uid(), rows.size)
    offset = random.normal(size=(3, rows.size))
    offset *= random.uniform(0.5, 2.0, rows.size) / np.linalg.norm(offset, axis=0)
    width, length, height = world.space.size
    p.x[rows], p.y[rows] = (q.x[beside] + offset[0]) % width, (q.y[beside] + offset[1]) % length
    p.z[rows] = np.clip(q.z[beside] + offset[2], 0.1, height - 0.1)
    plumes.version += 1
    world.fields["krill_smell"].value[...] = 0
