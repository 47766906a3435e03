import math

import numpy as np
import pytest

from ecs_eco.space.sun import Sun, daily_mean, sine_of_elevation


def test_at_an_equinox_on_the_equator_the_sun_rises_at_six_and_stands_in_the_zenith_at_noon():
    sun = Sun(day=240.0)
    assert [sun.light(t) for t in (0.0, 60.0, 120.0, 180.0)] == pytest.approx([0.0, 0.0, 1.0, 0.0], abs=1e-12)
    assert sun.light(80.0) == pytest.approx(0.5)  # a third of the day: an hour angle of 60 degrees


def test_latitude_and_season_lower_the_sun():
    noon = sine_of_elevation(0.5, math.radians(50.0), math.radians(20.0))
    assert noon == pytest.approx(math.cos(math.radians(30.0)))  # zenith distance: latitude less declination
    # midnight sun
    assert Sun(latitude=80.0, declination=20.0).light(0.0) == pytest.approx(math.sin(math.radians(10.0)))
    assert Sun(latitude=80.0, declination=-20.0, start=0.5).light(0.0) == 0.0  # polar night


@pytest.mark.parametrize(
    ("latitude", "declination"), [(0, 0), (45, 0), (45, 23.4), (-30, 23.4), (80, 20), (80, -20)]
)
def test_the_light_of_a_day_integrates_to_the_analytic_value(latitude, declination):
    n = 20_000
    sun = Sun(day=1000.0, latitude=latitude, declination=declination)
    mean = sum(sun.light((i + 0.5) / n * 1000.0) for i in range(n)) / n
    assert mean == pytest.approx(daily_mean(math.radians(latitude), math.radians(declination)), abs=1e-6)
    constant = Sun(kind="constant", day=1000.0, latitude=latitude, declination=declination)
    assert constant.light(123.0) == constant.light(700.0) == pytest.approx(mean, abs=1e-6)


def test_the_mean_on_the_equator_at_an_equinox_is_one_over_pi():
    assert daily_mean(0.0, 0.0) == pytest.approx(1 / np.pi)


def test_inverted_days_are_half_a_day_late():
    sun, inverted = Sun(day=100.0, latitude=20.0), Sun(kind="inverted", day=100.0, latitude=20.0)
    assert [inverted.light(t) for t in (5.0, 40.0, 90.0)] == [
        pytest.approx(sun.light(t + 50.0)) for t in (5.0, 40.0, 90.0)
    ]


def test_a_full_moon_shines_while_the_sun_is_down():
    sun = Sun(day=100.0, moon=0.001)
    assert sun.light(0.0) == pytest.approx(0.001)
    assert sun.light(50.0) == pytest.approx(1.0)


def test_the_season_of_a_year_swings():
    sun = Sun(latitude=90.0, declination=30.0, year=400.0, day=1.0)
    assert [sun.light(t) for t in (0.0, 100.0, 300.0)] == pytest.approx([0.0, 0.5, 0.0], abs=1e-9)
    assert sun.season(300.0) == pytest.approx(-math.pi / 6)
