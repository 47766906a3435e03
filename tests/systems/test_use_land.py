import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Body, Position
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import UseLand
from ecs_eco.testing import act, arrange, check_world


def _coast(*uses, count=1000, dt=1.0, **fish):
    return {
        "format": 1,
        "name": "coast",
        "dt": dt,
        "space": {"size": [40.0, 20.0]},
        "species": {"fish": {"count": count, "body": {"radius": 0.1, "opaque": False}} | fish},
        "land_use": list(uses),
    }


def _run(world, ticks):
    """Return what is taken in each tick, and the numbers after it."""
    world.run(ticks)
    series = world.series().to_pydict()
    return series.get("died: fished", series["deaths"]), series["n"]


FISHING = {"kind": "harvest", "species": "fish", "rate": 0.6931472, "cause": "fished"}


@pytest.mark.definition("4 objects")
def test_a_rate_takes_a_share_of_those_there_in_each_second():
    world = World.from_config(_coast(FISHING | {"region": [0.0, 0.0, 20.0, 20.0]}))
    x = world.tables["fish"][Position].x[:1000]
    there = int((x <= 20).sum())
    taken, n = _run(world, 3)
    for catch in taken:
        assert abs(catch - there / 2) < 3.5 * (there / 4) ** 0.5  # of a binomial distribution
        there -= catch
    assert n[-1] == 1000 - sum(taken)
    fish = world.tables["fish"]
    assert (fish[Position].x[fish.rows()] > 20).sum() == (x > 20).sum()


def test_a_quota_is_never_passed_and_begins_again_with_the_year():
    world = World.from_config(_coast(FISHING | {"quota": 30, "period": 4.0}))
    taken, _ = _run(world, 10)
    assert taken == [30, 0, 0, 0, 30, 0, 0, 0, 30, 0]


def test_without_years_a_quota_is_for_ever():
    world = World.from_config(_coast(FISHING | {"quota": 30, "rate": 0.02}))
    taken, _ = _run(world, 20)
    assert sum(taken) == 30
    assert max(taken) < 30


@pytest.mark.parametrize(("season", "when"), [([0.25, 0.75], [1, 2, 5, 6]), ([0.75, 0.25], [0, 3, 4, 7])])
def test_a_season_is_part_of_each_year(season, when):
    world = World.from_config(_coast(FISHING | {"rate": 0.1, "period": 4.0, "season": season}))
    taken, _ = _run(world, 8)
    assert np.flatnonzero(taken).tolist() == when


def test_only_those_of_the_right_size_are_caught():
    world = World.from_config(_coast(FISHING | {"rate": 50.0, "least": 0.2, "most": 0.3}, count=4))
    fish = arrange(world, "fish", radius=[0.1, 0.2, 0.25, 0.4])
    act(world, UseLand)
    assert (fish.cause[fish.by_uid()] > 0).tolist() == [False, True, True, False]
    assert fish[Body].radius[fish.by_uid()].tolist() == pytest.approx([0.1, 0.2, 0.25, 0.4])


def test_it_is_done_from_a_tick_to_a_tick():
    world = World.from_config(_coast(FISHING | {"rate": 0.1, "at": 2, "until": 3}))
    taken, _ = _run(world, 6)
    assert np.flatnonzero(taken).tolist() == [2, 3]


def test_planting_brings_a_rate_and_stops_where_there_are_enough():
    sow = {"kind": "plant", "species": "fish", "rate": 2.5, "region": [30.0, 10.0, 5.0], "up_to": 12}
    world = World.from_config(_coast(sow, count=0))
    _, n = _run(world, 9)
    assert n[0] in (2, 3)
    assert n[3] == pytest.approx(10, abs=2)
    assert n[-3:] == [12, 12, 12]
    p, rows = world.tables["fish"][Position], world.tables["fish"].rows()
    assert (np.hypot(p.x[rows] - 30, p.y[rows] - 10) <= 5).all()


def test_a_field_is_sown_in_spring_and_reaped_in_autumn():
    year = {"species": "fish", "region": [0.0, 0.0, 10.0, 10.0], "period": 10.0}
    world = World.from_config(
        _coast(
            year | {"kind": "plant", "rate": 20.0, "season": [0.1, 0.3]},
            year | {"kind": "harvest", "rate": 100.0, "season": [0.8, 0.9]},
            count=0,
        )
    )
    _, n = _run(world, 20)
    assert n == [0, 20, 40, 40, 40, 40, 40, 40, 0, 0] * 2


def test_quotas_may_change_while_a_world_lives_and_nothing_else_of_the_list():
    world = World.from_config(_coast(FISHING | {"rate": 100.0, "quota": 5, "period": 2.0}))
    world.intervene({"kind": "set", "set": {"land_use.0.quota": 50}})
    assert _run(world, 2)[0] == [50, 0]
    with pytest.raises(ConfigError, match="cannot change during a run"):
        world.intervene({"kind": "set", "set": {"land_use": []}})


def test_worlds_with_land_use_keep_their_promises_and_resume(tmp_path):
    config = _coast(
        FISHING | {"rate": 0.05, "quota": 7, "period": 5.0},
        {"kind": "plant", "species": "fish", "rate": 1.5},
        count=60,
    )
    check_world(lambda threads: World.from_config(config, threads=threads), ticks=20)
    whole, part = World.from_config(config).run(20), World.from_config(config).run(8)
    again = World.restore(part.save(tmp_path / "part.safetensors")).run(12)
    assert again.digest() == whole.digest()


def test_worlds_without_it_have_no_such_system():
    assert not [s for s in World.from_config(_coast()).systems if isinstance(s, UseLand)]


@pytest.mark.parametrize(
    ("use", "fault"),
    [
        ({"species": "fisch"}, "fish"),
        ({"region": [0.0, 0.0, 50.0, 10.0]}, "outside the world"),
        ({"season": [0.1, 0.2]}, "period"),
        ({"season": [0.1, 0.1], "period": 5.0}, "start and end are equal"),
        ({"at": 5, "until": 2}, "earlier than `at`"),
        ({"least": 2.0, "most": 1.0}, "less than `least`"),
    ],
)
def test_what_cannot_be_is_refused(use, fault):
    with pytest.raises(ConfigError, match=fault):
        load(_coast(FISHING | use))


@pytest.mark.parametrize(
    ("dt", "period", "ticks"),
    [(1.0, 10.0, [2, 3, 4, 5]), (0.1, 1.0, [2, 3, 4, 5]), (1 / 3, 10 / 3, [2, 3, 4, 5]), (0.7, 3.5, [1, 2])],
)
def test_a_season_has_the_same_ticks_in_every_year(dt, period, ticks):
    use = load(_coast(FISHING | {"period": period, "season": [0.2, 0.6]}, dt=dt)).land_use[0]
    year = round(period / dt)
    for n in range(3000):
        assert use.year(n, dt) == n // year
        assert use.active(n, dt) == (n % year in ticks)


def test_a_year_of_no_whole_number_of_ticks_has_leap_ticks():
    use = load(_coast(FISHING | {"period": 365.25, "season": [0.0, 0.5]})).land_use[0]
    years = [use.year(n, 1.0) for n in range(3000)]
    first = [years.index(year) for year in range(9)]
    assert first == [0, 366, 731, 1096, 1461, 1827, 2192, 2557, 2922]


def test_a_year_shorter_than_a_tick_is_refused():
    with pytest.raises(ConfigError, match="shorter than a tick; expected: at least dt, 1 s"):
        load(_coast(FISHING | {"period": 0.5, "season": [0.2, 0.6]}))
