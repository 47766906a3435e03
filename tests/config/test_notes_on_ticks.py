import numpy as np
import pytest

from ecs_eco.cli.summary import summary
from ecs_eco.config import load
from ecs_eco.config.notes_on_ticks import notes_on_ticks, share_met


def _pond(dt=1.0, world=None, **heron):
    species = {
        "count": 3,
        "body": {"radius": 0.1},
        "locomotion": {"speed": {"go": 1.0}},
        "actions": {"speed": ["go"]},
        "always_on": ["go"],
        "diet": [{"eats": "fish", "reach": 0.2, "gain": 0.5}],
    } | heron
    return load(
        {
            "format": 1,
            "name": "pond",
            "dt": dt,
            "space": {"size": [50.0, 50.0]},
            "objects": {"fish": {"count": 9, "body": {"radius": 0.1}}},
            "species": {"heron": species},
        }
        | (world or {})
    )


def test_contacts_that_a_tick_passes_over_are_noted_with_a_remedy_that_helps():
    (note,) = notes_on_ticks(_pond())
    assert note == (
        "species.heron.diet.0: heron and fish move up to 1 m past each other in a tick, and contacts within "
        "0.4 m are checked only at its end, so about 63% of encounters are detected; dt = 0.4 or reach = "
        "0.8 detects 96%"
    )
    assert f"  note: {note}" in summary(_pond()).splitlines()
    assert notes_on_ticks(_pond(0.4)) == []
    assert notes_on_ticks(_pond(diet=[{"eats": "fish", "reach": 0.8, "gain": 0.5}])) == []


@pytest.mark.parametrize("way", [0.3, 1.0, 1.9, 2.5, 7.0])
def test_the_share_met_is_that_of_points_thrown_at_random(way):
    rng = np.random.default_rng(3)
    x, y = rng.random(40_000) * way, rng.random(40_000) * 2 - 1  # a strip of half width 1
    met = np.min([(x - way * k) ** 2 for k in range(-8, 9)], 0) + y**2 <= 1
    assert share_met(way, 1.0) == pytest.approx(met.mean(), abs=0.01)


@pytest.mark.parametrize(
    ("heron", "note"),
    [
        (
            {"metabolism": {"handling_time": 0.3}},
            "species.heron.metabolism.handling_time = 0.3: times are whole ticks of "
            "dt = 0.4 s, so this one lasts 0.4 s",
        ),
        ({"metabolism": {"handling_time": 2.0}}, ""),
        (
            {"sensors": [{"kind": "touch", "target": "fish"}], "diet": []},
            "species.heron.sensors.0: heron and fish",
        ),
    ],
)
def test_what_else_a_tick_is_too_long_for_is_noted(heron, note):
    found = notes_on_ticks(_pond(0.4, **heron))
    assert len(found) == (1 if note else 0), found
    assert not note or found[0].startswith(note)


def test_a_sensor_of_touch_without_a_target_touches_all_kinds():
    found = notes_on_ticks(_pond(0.4, sensors=[{"kind": "touch"}], diet=[]))
    assert [note.partition(" move")[0] for note in found] == [
        "species.heron.sensors.0: heron and heron",
        "species.heron.sensors.0: heron and fish",
    ]


def test_days_years_and_seasons_shorter_than_ticks_are_noted():
    use = {"kind": "harvest", "species": "fish", "rate": 0.1, "period": 2.0, "season": [0.5, 0.6]}
    config = _pond(0.4, {"sun": {"day": 0.5}, "land_use": [use]})
    assert [note[:20] for note in notes_on_ticks(config)] == ["sun.day = 0.5: less ", "land_use.0.season la"]
