"""An outside series and a run are described by one rule, which finds what was put into them."""

import numpy as np
import pytest

from ecs_eco.analysis.against import compare, summary
from ecs_eco.analysis.runs import Series
from ecs_eco.config.measurements import outside_of, read_outside
from ecs_eco.engine.errors import ConfigError

HARE_LYNX = """year,lynx,hare
1900,4.0,30.0
1901,6.1,47.2
1902,9.8,70.2
1903,35.2,77.4
1904,59.4,36.3
1905,41.7,20.6
1906,19.0,18.1
1907,13.0,21.4
1908,8.3,22.0
1909,9.1,25.4
1910,7.4,27.1
1911,8.0,40.3
1912,12.3,57.0
1913,19.5,76.6
1914,45.7,52.3
1915,51.1,19.5
1916,29.7,11.2
1917,15.8,7.6
1918,9.7,14.6
1919,10.1,16.2
1920,8.6,24.7
"""  # Hudson's Bay Company, pelts in thousands


def waves(n, period, behind=0.0, size=0.5, trend=0.0, noise=0.05, seed=1):
    t = np.arange(n)
    noisy = np.random.default_rng(seed).normal(0, noise, n)
    return 10 ** (2 + size * np.sin(2 * np.pi * (t / period - behind)) + trend * t / n + noisy)


@pytest.mark.parametrize("period", [6.0, 11.3, 40.0])
def test_period_and_amplitude_are_those_that_were_put_in(period):
    found = summary(waves(200, period, trend=0.4), 0.5)
    assert found.period == pytest.approx(0.5 * period, rel=0.03)
    assert found.amplitude == pytest.approx(0.5 / np.sqrt(2), rel=0.1)
    assert found.cycles == pytest.approx(200 / period, rel=0.03)
    assert found.share > 0.9


def test_without_a_cycle_no_wave_explains_much():
    noise = waves(200, 10.0, size=0.0, noise=0.3)
    assert summary(noise, 1.0).share < 0.2


def test_lynx_follow_hares_in_cycles_of_ten_years(tmp_path):
    (tmp_path / "pelts.csv").write_text(HARE_LYNX)
    outside = read_outside(tmp_path / "pelts.csv", ["grass", "deer", "lynx"], {"hare": "deer"})
    assert outside.named == {"lynx": "lynx", "deer": "hare"}
    assert outside.unit == "year"
    n = np.stack([waves(400, 90.0), waves(400, 90.0), waves(400, 90.0, 0.25, seed=3)], 1)
    run = Series(np.arange(400), ("grass", "deer", "lynx"), {"n": n})
    both = compare(run, outside)
    assert both.outside["lynx"].period == pytest.approx(10, abs=1)
    assert both.outside["deer"].period == pytest.approx(10, abs=1.5)
    assert both.run["lynx"].period == pytest.approx(90, rel=0.05)
    ours, theirs = both.lags["lynx", "deer"]  # of hares behind lynx
    assert 1 - ours == pytest.approx(0.25, abs=0.02)
    assert 0.05 < 1 - theirs < 0.25


@pytest.mark.parametrize(
    ("text", "words", "fault"),
    [
        (HARE_LYNX, {}, "no column has the name of a species"),
        (HARE_LYNX, {"match": {"hares": "deer"}}, 'did you mean "hare"?'),
        (HARE_LYNX, {"match": {"hare": "dear"}}, 'did you mean "deer"?'),
        (HARE_LYNX.replace("1905,", "1905.5,"), {"match": {"hare": "deer"}}, "not evenly spaced"),
        (HARE_LYNX.replace("36.3", ""), {"match": {"hare": "deer"}}, "or gaps between them"),
        (HARE_LYNX.replace("36.3", "-1"), {"match": {"hare": "deer"}}, "numbers below 0"),
        (HARE_LYNX[:57], {"match": {"hare": "deer"}}, "expected: 12 to "),
        (HARE_LYNX + "1921,3\n", {"match": {"hare": "deer"}}, "row 23 does not have as many columns"),
        (HARE_LYNX, {"match": {"hare": "deer"}, "time": "yaer"}, 'did you mean "year"?'),
        ("year,deer\n" + "".join(f"{i},0\n" for i in range(20)), {}, "only zeros"),
        ("", {}, "has no head"),
    ],
)
def test_series_that_cannot_be_used_are_refused(tmp_path, text, words, fault):
    (tmp_path / "pelts.csv").write_text(text)
    with pytest.raises(ConfigError) as error:
        read_outside(tmp_path / "pelts.csv", ["grass", "deer"], **words)
    assert fault in str(error.value)


def test_a_reporter_stands_beside_a_column_and_time_has_a_unit(tmp_path):
    (tmp_path / "pelts.csv").write_text(HARE_LYNX)
    data = {"file": "pelts.csv", "columns": {"hare": "prevalence"}, "unit": "a", "ticks": 30.0}
    outside = outside_of(data, tmp_path, ["deer", "prevalence"])
    assert (outside.unit, outside.ticks) == ("a", 30.0)
    n = np.stack([waves(400, 90.0), waves(400, 90.0)], 1)
    prevalence = np.stack([waves(400, 60.0), np.full(400, np.nan)], 1)
    both = compare(Series(np.arange(400), ("deer", "wolf"), {"n": n, "prevalence": prevalence}), outside)
    assert both.run["prevalence"].period == pytest.approx(60, rel=0.05)


def test_a_run_that_ends_early_or_falls_below_zero_is_refused(tmp_path):
    (tmp_path / "pelts.csv").write_text(HARE_LYNX)
    outside = read_outside(tmp_path / "pelts.csv", ["deer", "lynx"], {"hare": "deer"})
    n = np.stack([waves(100, 30.0), waves(100, 30.0)], 1)
    n[15:, 1] = 0
    with pytest.raises(ConfigError, match="5 ticks remain before the first extinction"):
        compare(Series(np.arange(100), ("deer", "lynx"), {"n": n}), outside)
    below = Series(np.arange(100), ("wolf",), {"n": n[:, :1], "lynx": n[:, :1] - 1000})
    with pytest.raises(ConfigError, match="is negative or not a number"):
        compare(below, read_outside(tmp_path / "pelts.csv", ["lynx"]))
