"""The series that a world returns: as an Arrow table, as pandas and polars take it, wide, and as HTML."""

import builtins
import copy

import pyarrow as pa
import pytest

from ecs_eco import World
from ecs_eco.analysis.runs import load_series
from ecs_eco.record.frame import SeriesTable

ROWS = {
    "tick": [0, 0, 1, 1],
    "species": ["<hare>", "fox", "<hare>", "fox"],
    "n": [5, 2, 6, 1],
    "energy": [0.5, 0.25, None, 0.75],
}


@pytest.fixture
def series():
    return SeriesTable(pa.table(ROWS))


def test_it_does_what_the_arrow_table_does_and_what_it_returns_can_do_so_too(series):
    assert series.column_names == [*ROWS]
    assert len(series) == series.num_rows == 4
    assert series["n"].to_pylist() == [5, 2, 6, 1]
    fewer = series.select(["tick", "n"]).slice(0, 2)
    assert isinstance(fewer, SeriesTable)
    assert fewer.to_pydict() == {"tick": [0, 0], "n": [5, 2]}
    assert series.equals(SeriesTable(pa.table(ROWS)))
    assert series == pa.table(ROWS)
    assert pa.table(series).equals(series.arrow)
    assert copy.deepcopy(series) == series
    assert load_series(series).of("fox").tolist() == [2, 1]


def test_wide_has_a_row_per_tick_and_a_column_per_species(series):
    assert series.wide().to_pydict() == {"tick": [0, 1], "<hare>": [5, 6], "fox": [2, 1]}
    both = series.wide("n", "energy").to_pydict()
    assert list(both) == ["tick", "n <hare>", "n fox", "energy <hare>", "energy fox"]
    assert both["energy fox"] == [0.25, 0.75]
    assert both["energy <hare>"][0] == 0.5
    assert both["energy <hare>"][1] != both["energy <hare>"][1], "what is missing is NaN"
    with pytest.raises(KeyError, match="no numeric column 'm': it has n, energy"):
        series.wide("m")


def test_pandas_and_polars_take_it(series):
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    frame = series.wide().to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert frame.set_index("tick")["fox"].to_list() == [2, 1]
    assert series.to_polars()["n"].to_list() == [5, 2, 6, 1]
    assert polars.DataFrame(series).height == 4


@pytest.mark.parametrize(("missing", "method"), [("pandas", "to_pandas"), ("polars", "to_polars")])
def test_without_them_it_says_which_extra_to_install(missing, method, series, monkeypatch):
    real = builtins.__import__

    def without(name, *rest):
        if name.partition(".")[0] == missing:
            raise ModuleNotFoundError(f"No module named {name!r}", name=missing)
        return real(name, *rest)

    monkeypatch.setattr("importlib.import_module", lambda name: without(name))
    with pytest.raises(ModuleNotFoundError, match=rf"{missing} is not installed: .*\.\[notebook\]"):
        getattr(series, method)()


def test_its_html_shows_both_ends_and_escapes_names(series):
    html = series._repr_html_()
    assert html.count("<tr>") == 5
    assert "&lt;hare&gt;" in html
    assert "<hare>" not in html
    long = SeriesTable(pa.table({"tick": list(range(100)), "n": [7] * 100}))._repr_html_()
    assert long.count("<tr>") == 10
    assert "Series: 100 rows" in long
    assert "<td>99</td>" in long


def test_a_world_returns_it():
    world = World.from_config(
        {
            "format": 1,
            "name": "pond",
            "space": {"size": [9.0, 9.0]},
            "species": {
                "weed": {
                    "count": 5,
                    "body": {"radius": 0.1},
                    "reproduction": {"kind": "spread", "rate": 0.0, "spacing": 1.0},
                }
            },
        }
    )
    assert world.run(3).series().wide().to_pydict() == {"tick": [0, 1, 2], "weed": [5, 5, 5]}
