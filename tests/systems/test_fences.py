"""Fences: nobody crosses one, and nobody else notices it."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Nervous, Position
from ecs_eco.space.terrain import FENCE
from ecs_eco.testing import arrange
from tests.systems.interventions import uids, world


def walkers(w, x, y, heading):
    """Deer that run straight on, and nobody else."""
    deer = arrange(w, "deer", x=x, y=y, heading=heading)
    nerves = deer.species.nerves
    decision = deer[Nervous].decision
    decision[:] = 0
    decision[:, nerves.column("speed.run")] = 1
    decision[:, nerves.column("turn.none")] = 1
    return deer


def go(w, ticks):
    from ecs_eco.systems import Move

    move = next(s for s in w.systems if isinstance(s, Move))
    for _ in range(ticks):
        move.process()


@pytest.mark.parametrize("speed", [0.3, 1.0, 7.0])
def test_nobody_gets_out_of_a_round_fence_in_any_direction_and_who_is_outside_does_not_get_in(speed):
    n = 60
    more = {"species.deer.count": n, "species.deer.locomotion.speed.run": speed}
    w = world({"kind": "fence", "at": 0, "region": [50.0, 30.0, 15.0]}, **more)
    angle = 2 * np.pi * (np.arange(n) + 0.37) / n
    inside = np.arange(n) % 2 == 0
    r = np.where(inside, 2.0, 20.0)
    deer = walkers(
        w,
        (50 + r * np.cos(angle)) % 60,
        30 + r * np.sin(angle),
        np.where(inside, angle, angle + np.pi).astype(np.float32),
    )
    order = deer.by_uid()
    w.systems[0].process()
    go(w, int(120 / speed))
    p = deer[Position]
    dx = p.x[order] - 50
    away = np.hypot(dx - 60 * np.round(dx / 60), p.y[order] - 30)
    assert (away[inside] < 15.5).all()
    assert (away[~inside] > 14.5).all()
    w.systems[0].fence(
        w, type(w.config.interventions[0]).model_validate({"kind": "fence", "at": 0, "remove": True})
    )
    go(w, int(120 / speed))
    assert not w.terrain.ground.any()


def test_who_stands_where_a_fence_is_put_up_walks_off_it_and_not_back():
    w = world({"kind": "fence", "at": 0, "line": [[30.0, 0.0], [30.0, 60.0]]}, **{"species.deer.count": 2})
    deer = walkers(w, [30.3, 30.3], [20, 40], np.array([0, np.pi], np.float32))
    order = deer.by_uid()
    w.systems[0].process()
    assert (w.terrain.ground[20:41, 50] == FENCE).all()  # cells of 0.6 m
    go(w, 3)
    p = deer[Position]
    assert p.x[order].tolist() == pytest.approx([33.3, 27.3], abs=1e-3)
    p.heading[order] = [np.pi, 0]
    go(w, 10)
    assert p.x[order][0] >= 30.6
    assert p.x[order][1] <= 30.0


def test_a_fence_changes_nothing_for_those_who_do_not_meet_it():
    fence = {"kind": "fence", "at": 0, "region": [29.0, 29.0, 29.6, 29.6]}
    plain, fenced = world(), world(fence)
    for w in (plain, fenced):  # nobody is near, and plants sprout on it as elsewhere
        deer, wolf = w.tables["deer"], w.tables["wolf"]
        for t in (deer, wolf):
            x = t[Position].x[t.rows()]
            t[Position].x[t.rows()] = np.where((x > 20) & (x < 40), 5, x)
            t.version += 1
        w.run(8)
    grass = [w.tables["grass"] for w in (plain, fenced)]
    assert uids(grass[0]) == uids(grass[1])
    assert plain.digest() != fenced.digest()  # for there is a fence
    fenced.terrain.unfence()
    assert plain.digest() == fenced.digest()


def test_a_fence_spares_lakes_and_crossing_fences_stand_when_one_is_taken_away(menagerie):
    across, along = [[0.0, 20.0], [40.0, 20.0]], [[30.0, 0.0], [30.0, 30.0]]
    w = World.from_config(menagerie(), policies="untrained")
    before = w.terrain.ground.copy()
    for line in (across, along):
        w.intervene({"kind": "fence", "line": line})
    w.run(1)
    both = w.terrain.ground.copy()
    assert (both[before > 0] == before[before > 0]).all()
    assert (both[19:21, 2] == FENCE).any()
    w.intervene({"kind": "fence", "line": along, "remove": True})
    w.run(1)
    left = w.terrain.ground
    assert (left[20] == both[20]).all()
    assert (left[5] == before[5]).all()
    w.intervene({"kind": "fence", "remove": True})
    w.run(1)
    assert (w.terrain.ground == before).all()
