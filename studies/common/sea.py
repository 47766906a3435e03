"""Code shared by the sea studies: policies by training seed, and four measures of a world with copepods."""

from dataclasses import replace
from typing import Any

import numpy as np

from ecs_eco.analysis import depth as depths
from ecs_eco.analysis.escapes import AROUND, REST, escapes
from ecs_eco.analysis.tracks import Tracks, approaches, event_average, shortest
from ecs_eco.components import Position
from studies.common.follow import follow
from studies.common.seed_grid import policies_of

__all__ = ["approach", "chemotaxis", "encounters", "life", "policies_of"]
CUE = 1.5  # [m] a copepod within this distance of a krill counts as approached
FAST = 1.4  # [m/s] speed of chasing krill and of objects that approach copepods
# number of approaching objects, starting distance [m], and heights [m] at which copepods feed in the dark
KRILL, AIM, UPPER = 16, 4.0, (22.0, 29.0)
CONTACT = 0.5  # [m] between the centers of a copepod and a krill-sized object in contact
REACH, AFTER = 2.0, 6  # [m] distance of an encounter; [ticks] after which a living copepod has survived it
PLUMES, NEAR, FAR = 12, 0.3, 4.0  # plumes at a time; [m] range of distances at which copepods are counted
# [ticks] that a plume stays in place, and initial ticks in which moves are not counted
STAY, SPREAD = 12, 2


def life(world: Any, days: int) -> dict[str, Any]:
    """Measure how mean depth follows the time of day, over the given number of days after the first:
    amplitude as a share of the water's depth, phase, and correlation with light.

    `cycle` is None if the copepods died out within two full days.
    """
    from ecs_eco.analysis.runs import load_series

    day = round(world.config.sun.day / world.dt)
    for _ in range(days + 1):
        world.run(day)
        if not world.tables["copepod"].n:
            break
    series = replace(
        load_series(world.series()), manifest={"config": world.config.resolved(), "dt": world.dt}
    )
    alive = series.of("copepod") > 0
    died = {
        c: float(series.of("copepod", f"died: {c}").sum() * day / max(series.of("copepod").sum(), 1))
        for c in series.causes
    }
    out = {
        "copepods": int(series.of("copepod")[-1]),
        "mean number": float(series.of("copepod").mean()),
        "days survived": float(alive.sum() / day),
        "deaths per copepod per day": {c: v for c, v in died.items() if v},
    }
    cycle = depths.depth_cycle(series, "copepod")
    if cycle is None:
        return out | {"cycle": None}
    hours, depth = depths.hours_of(series, series.ticks), series.of("copepod", "depth_mean")
    lived = alive & (series.ticks >= series.ticks[0] + day)
    eighths = [float(depth[lived & ((hours * 8).astype(int) == k)].mean()) for k in range(8)]
    return out | {
        "cycle": {
            "amplitude": cycle.share,
            "vector": (cycle.fit.vector / cycle.height).tolist(),
            "lag [days]": cycle.lag,
            "p": cycle.p,
            "r": cycle.r,
            "mean depth": cycle.fit.mesor,
            "depth by eighths of a day from midnight": eighths,
        }
    }


def approach(build: Any, kind: str, ticks: int = 300) -> dict[str, Any]:
    """Measure how copepods in the dark respond when something the size of a krill approaches them head-on at
    chasing speed.

    `build(changes)` returns a world. `kind` is "swimming" for krill that hunt by reflex and, in this measure,
    see 4 m in the dark; "drifting" for krill that the experimenter moves, which smell like other krill but do
    not swim; or "object" for an odorless object that moves the same way. The krill and objects do not eat;
    all of them are moved to new positions every 20 ticks.
    """
    changes: dict[str, Any] = {
        "ambient.light": 0.0,
        "species.krill.count": KRILL,
        "species.krill.diet.0.chance": 0.0,
        "species.krill.sensors.1.blind": AIM,
    }
    if kind == "drifting":
        changes |= {"species.krill.locomotion.speed": {"wander": 0.0, "chase": 0.0}}
    if kind == "object":
        body = {"radius": 0.4, "mass": 1.0, "opaque": False}
        changes |= {"species.krill.count": 0, "objects.buoy": {"count": KRILL, "body": body}}
    world = build(changes)
    world.run(60)  # time for copepods to rise
    movers, random = Movers(world, "buoy" if kind == "object" else "krill"), np.random.default_rng(world.seed)

    def move(world: Any) -> None:
        if (world.tick - 60) % 20 == 0:
            movers.scatter(random)
        elif kind != "swimming":
            movers.aim()

    return escaped(follow(world, ticks, "copepod", movers.table.name, each=move), world.dt)


class Movers:
    """Objects that an experimenter moves toward copepods."""

    def __init__(self, world: Any, name: str) -> None:
        self.world, self.table = world, world.tables[name]
        self.rows, self.size = self.table.by_uid(), np.array(world.space.size, float)
        self.way = np.zeros((self.rows.size, 3))

    def scatter(self, random: np.random.Generator) -> None:
        """Put all objects at random positions where copepods feed in the dark, at least 3 m from any
        copepod."""
        low, high = np.array([0.0, 0.0, UPPER[0]]), np.array([*self.size[:2], UPPER[1]])
        tries = random.uniform(low, high, (200, 3))
        free = tries[np.linalg.norm(self._to_copepod(tries), axis=1) > 3.0]
        self._put(np.resize(free if len(free) else tries, (self.rows.size, 3)))
        angle = random.uniform(-np.pi, np.pi, self.rows.size)
        self.way = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
        self.table[Position].heading[self.rows] = angle

    def aim(self) -> None:
        """Move each object toward the nearest copepod within 4 m until they touch, otherwise straight
        ahead."""
        p = self.table[Position]
        here = np.stack([p.x[self.rows], p.y[self.rows], p.z[self.rows]], 1).astype(float)
        d = self._to_copepod(here)
        length = np.linalg.norm(d, axis=1)
        near = (length < AIM) & (length > 1e-6)
        self.way[near] = d[near] / length[near, None]
        step = np.where(near, np.clip(length - CONTACT, 0.0, FAST * self.world.dt), FAST * self.world.dt)
        self._put(here + step[:, None] * self.way)

    def _to_copepod(self, places: np.ndarray) -> np.ndarray:
        table = self.world.tables["copepod"]
        rows, q = table.by_uid(), table[Position]
        if not rows.size:
            return np.full((len(places), 3), 1e9)
        d = np.stack([q.x[rows], q.y[rows], q.z[rows]], 1)[None] - places[:, None]
        d = shortest(self.world.space, d.reshape(-1, 3)).reshape(d.shape)
        return np.asarray(d[np.arange(len(places)), (d**2).sum(2).argmin(1)])

    def _put(self, places: np.ndarray) -> None:
        p = self.table[Position]
        p.x[self.rows], p.y[self.rows] = (places[:, :2] % self.size[:2]).T
        p.z[self.rows] = np.clip(places[:, 2], 0.1, self.size[2] - 0.1)
        self.table.version += 1


def escaped(tracks: Tracks, dt: float) -> dict[str, Any]:
    """Return speed and direction around approaches.

    `way` is the mean direction over the tick of the approach and the next two: the component away from the
    approaching object, and the horizontal component to its left.
    """
    summary = escapes(tracks, CUE)
    if summary is None:
        return {"n": 0}
    k = AROUND
    before = float(np.nanmean(summary.speed[:k]))
    events = approaches(tracks.distance, CUE, REST)
    way = [float(np.nanmean(event_average(c, events, 0, 2))) for c in (tracks.away, tracks.aside)]
    return {
        "n": summary.n,
        "speed": summary.speed.tolist(),
        "away": summary.away.tolist(),
        "before": before,
        "gain": summary.gain,
        "way": way,
        "latency": summary.latency,
        "latency [s]": None if summary.latency is None else summary.latency * dt,
    }


def encounters(world: Any, days: int) -> dict[str, Any]:
    """Count the copepods that survive an encounter with a krill for a number of ticks, and the krill's kills,
    from the second day on.

    A kill without an earlier encounter (of a newborn, or of a copepod always near a krill) counts as an
    encounter that the copepod did not survive.
    """
    day = round(world.config.sun.day / world.dt)
    world.run(day)
    first, killed = world.tick, []

    def note(table: Any, rows: np.ndarray) -> None:
        if table.name == "copepod":
            eaten = [r for r in rows.tolist() if world.causes[table.cause[r] - 1] == "eaten by krill"]
            killed.extend((world.tick - first, int(table.uid[r])) for r in eaten)

    world.on_death.append(note)
    tracks = follow(world, days * day, "copepod", "krill", within=REACH + 1.0)
    events = approaches(tracks.distance, REACH, REST)
    events = events[events[:, 0] + AFTER < len(tracks.light)]
    met = {(animal, tick + k) for tick, animal in events.tolist() for k in range(AFTER + 1)}
    place = {int(uid): k for k, uid in enumerate(tracks.uids)}
    missed = sum((place.get(uid, -1), tick) not in met for tick, uid in killed)
    alive = np.array(
        [np.isfinite(tracks.depth[tick + AFTER, animal]) for tick, animal in events.tolist()], bool
    )
    n, lived = len(events) + missed, max(float(np.isfinite(tracks.depth).sum()) / day, 1e-9)
    return {
        "n": n,
        "without a previous encounter": missed,
        "survived": float(alive.sum()) / n if n else None,
        "encounters per copepod per day": n / lived,
        "kills per copepod per day": len(killed) / lived,
    }


def chemotaxis(build: Any, rounds: int) -> dict[str, Any]:
    """Measure whether copepods move away from the smell of krill in the dark, with no krill present: an index
    of moves, and the mean cosine.

    Plumes are placed for some ticks at the depths of randomly drawn copepods, at random horizontal positions;
    the plumes then move elsewhere and all earlier smell is removed, so nearby copepods have not chosen to be
    there. Because copepods gather at the plumes' depths regardless of smell, `level` uses only the horizontal
    components of their moves: without a sense of smell, as many copepods approach as leave.
    """
    body = {"radius": 0.4, "opaque": False}
    at = [[1.0 + i, 1.0, 1.0] for i in range(PLUMES)]
    world = build(
        {
            "ambient.light": 0.0,
            "species.krill.count": 0,
            "objects.plume": {"at": at, "body": body, "emits": {"krill_smell": 1.0}},
        }
    )
    world.run(60)  # time for copepods to rise from below
    random, cosines, ways = np.random.default_rng(world.seed), [np.zeros(0)], [np.zeros(0)]
    for _ in range(rounds):
        if world.tables["copepod"].n < 2:
            break
        _put_among(world, random)
        places: list[dict[int, np.ndarray]] = []
        tracks = follow(
            world,
            STAY,
            "copepod",
            "plume",
            within=FAR,
            each=lambda w, places=places: places.append(_places(w)),
        )
        places.append(_places(world))
        counted = (tracks.distance > NEAR) & (tracks.distance < FAR) & np.isfinite(tracks.away)
        counted[:SPREAD] = False
        cosines.append(tracks.away[counted])
        ways.append(_level(world, tracks.uids, places, counted))
    away, level = np.concatenate(cosines), np.concatenate(ways)
    return {
        "n": int(away.size),
        "index": _index(away),
        "cosine": float(away.mean()) if away.size else None,
        "level": {"n": int(level.size), "index": _index(level)},
    }


def _index(parts: np.ndarray) -> float | None:
    """Return the chemotaxis index (N away − N toward)/N: 1 if all leave the source, 0 if as many approach
    as leave."""
    toward = int((parts < 0).sum())
    return (parts.size - 2 * toward) / parts.size if parts.size else None


def _places(world: Any) -> dict[int, np.ndarray]:
    table = world.tables["copepod"]
    rows, p = table.by_uid(), table[Position]
    return dict(
        zip(
            table.uid[rows].tolist(),
            np.stack([p.x[rows], p.y[rows], p.z[rows]], 1).astype(float),
            strict=True,
        )
    )


def _level(
    world: Any, uids: np.ndarray, places: list[dict[int, np.ndarray]], counted: np.ndarray
) -> np.ndarray:
    """Return the horizontal components of counted moves (tick, animal) away from the nearest plume [m]."""
    table = world.tables["plume"]
    rows, p = table.by_uid(), table[Position]
    plumes, out = np.stack([p.x[rows], p.y[rows], p.z[rows]], 1).astype(float), []
    for tick, animal in np.argwhere(counted).tolist():
        before, after = (places[t][int(uids[animal])] for t in (tick, tick + 1))
        offsets = shortest(world.space, before - plumes)
        nearest = offsets[(offsets**2).sum(1).argmin(), :2]
        out.append(float(shortest(world.space, (after - before)[None])[0, :2] @ nearest))
    return np.array([x for x in out if x])


def _put_among(world: Any, random: np.random.Generator) -> None:
    """Put each plume at a random copepod's depth, at a random horizontal position, and remove all earlier
    smell."""
    plumes, copepods = world.tables["plume"], world.tables["copepod"]
    rows, p = plumes.by_uid(), plumes[Position]
    width, length, height = world.space.size
    p.x[rows], p.y[rows] = random.uniform(0, width, rows.size), random.uniform(0, length, rows.size)
    p.z[rows] = np.clip(copepods[Position].z[random.choice(copepods.by_uid(), rows.size)], 0.1, height - 0.1)
    plumes.version += 1
    world.fields["krill_smell"].value[...] = 0
