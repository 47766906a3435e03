"""What the studies of the sea share: policies by training seed, what copepods of one run do, and how they meet a smell without a krill."""

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from _predator_prey import trained

from ecs_eco.analysis.migration import Cosinor, Tracks, approaches, chemotaxis_index, cosinor, event_average, follow

__all__ = ["cycle", "escape", "plume", "trained"]
PLUMES = [[8.0, 8.0, 25.0], [24.0, 24.0, 25.0], [8.0, 24.0, 25.0], [24.0, 8.0, 25.0]]  # [m] 5 m deep, where copepods feed by night
NEAR, FAR = 0.3, 4.0  # [m] from a plume: who is counted


def cycle(world: Any, tracks: Tracks) -> dict[str, Any]:
    """How mean depth follows the day: cosinor, its height as a share of the water, lag behind noon, correlation with light."""
    sun, lived = world.config.sun, np.isfinite(tracks.mean_depth)  # as long as there are any
    depth, light = tracks.mean_depth[lived], tracks.light[lived]
    time = ((world.tick - lived.size + np.flatnonzero(lived)) * world.dt / sun.day + sun.start - 0.5) % 1.0  # of the day, from noon on
    fit: Cosinor = cosinor(time, depth, 1.0)
    height = world.space.size[2]
    lag = (fit.acrophase + np.pi) % (2 * np.pi) - np.pi
    at = ((time + 0.5) % 1.0 * 8).astype(int)
    r = float(np.corrcoef(depth, light)[0, 1]) if light.std() > 0 and depth.std() > 0 else float("nan")
    return {"amplitude": fit.amplitude / height, "peak to peak": 2 * fit.amplitude / height, "lag [days]": float(lag / (2 * np.pi)),
            "vector": (fit.vector / height).tolist(), "r": r, "mean depth": fit.mesor,
            "depth by eighths of a day from midnight": [float(depth[at == k].mean()) for k in range(8)]}  # fmt: skip


def escape(tracks: Tracks, within: float = 1.5, rest: int = 5) -> dict[str, Any]:
    """Speed and direction around the approach of a krill: five ticks before, the tick of it, five after."""
    events = approaches(tracks.distance, within, rest)
    out = {"n": len(events)}
    return out | {name: event_average(series, events, 5, 5).tolist() for name, series in (("speed", tracks.speed), ("away", tracks.away))}


def plume(config: Any, policies: Any, seed: int, emits: float = 1.0, ticks: int = 150) -> dict[str, Any]:
    """How copepods move near four smells of krill without a krill, in the dark; with `emits` 0 the same places without smell.

    `index` compares those who leave with those who come nearer, within 4 m; `visits` is the mean number of copepods within 4 m.
    """
    from ecs_eco import World
    from ecs_eco.config import load

    body = {"radius": 0.4, "opaque": False}
    values = {"ambient.light": 0.0, "objects.plume": {"at": PLUMES, "body": body, "emits": {"krill_smell": emits}}, "species.krill.count": 1,
              "interventions": [{"kind": "cull", "at": 0, "species": "krill", "share": 1.0}]}  # fmt: skip
    world = World.from_config(load(config, values), seed=seed, policies=policies, learn=False)
    world.run(60)  # those below come up, and smells spread
    tracks = follow(world, ticks, "copepod", "plume", within=FAR)
    counted = (tracks.distance > NEAR) & (tracks.distance < FAR) & np.isfinite(tracks.away)
    away = tracks.away[counted]
    return {"index": chemotaxis_index(int((away > 0).sum()), int((away < 0).sum())), "n": int(away.size),
            "visits": float((tracks.distance < FAR).sum() / ticks)}
