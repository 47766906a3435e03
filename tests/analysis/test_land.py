"""What is on the ground: fences and roads in the order of time, areas of land use, and how they are drawn."""

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle, Polygon, Rectangle

from ecs_eco.analysis import figures
from ecs_eco.analysis.land import ROAD, USES, land_at, strip

ROADS = [{"line": [[0.0, 2.0], [9.0, 2.0]], "width": 2.0, "pace": 2.0, "cost": 1.0}]
LINE = [[1.0, 1.0], [1.0, 8.0]]
INTERVENED = [
    [2, {"kind": "fence", "at": 2, "region": [4.0, 4.0, 2.0]}],
    [3, {"kind": "road", "at": 3, "line": LINE}],
    [4, {"kind": "fence", "at": 4, "line": LINE}],
    [5, "as it was"],
    [6, {"kind": "fence", "at": 6, "region": [4.0, 4.0, 2.0], "remove": True}],
    [7, {"kind": "road", "at": 7, "remove": True}],
]
USE = [
    {"kind": "harvest", "species": "deer", "region": [2.0, 2.0, 6.0, 8.0], "at": 3, "until": 5},
    {"kind": "plant", "species": "oak", "region": [5.0, 5.0, 1.0]},
    {"kind": "harvest", "species": "cod"},
]
CONFIG = {"terrain": {"roads": ROADS}, "land_use": USE}


@pytest.mark.parametrize(
    ("tick", "fences", "roads", "areas"),
    [
        (0, 0, 1, ["oak"]),
        (2, 1, 1, ["oak"]),
        (3, 1, 2, ["deer", "oak"]),
        (5, 2, 2, ["deer", "oak"]),
        (6, 1, 2, ["oak"]),
        (7, 1, 0, ["oak"]),
    ],
)
def test_what_is_there_at_a_tick_is_what_was_put_up_before_and_not_taken_away(tick, fences, roads, areas):
    land = land_at(CONFIG, INTERVENED, tick)
    assert (len(land["fences"]), len(land["roads"])) == (fences, roads)
    assert [area["species"] for area in land["areas"]] == areas
    assert land_at({}, [], tick) == {"fences": [], "roads": [], "areas": []}


def test_a_road_has_its_width_and_no_gaps_at_corners():
    one, other = strip(np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 6.0]]), 2.0)
    assert one.tolist() == [[-1, 1], [5, 1], [5, -1], [-1, -1]]
    assert other.tolist() == [[3, -1], [3, 7], [5, 7], [5, -1]]


def test_the_map_of_a_report_shows_roads_fences_and_areas_below_the_living():
    at = {"deer": np.array([[3.0, 3.0, 0.0]])}
    ax = figures.positions(at, [10.0, 10.0], {"deer": "#123456"}, land=land_at(CONFIG, INTERVENED, 5)).axes[0]
    strips = [c for c in ax.collections if isinstance(c, PolyCollection)]
    assert len(strips) == 2
    assert np.allclose(strips[0].get_facecolor()[0, :3] * 255, [int(ROAD[i : i + 2], 16) for i in (1, 3, 5)])
    assert strips[0].get_paths()[0].get_extents().bounds == (-1.0, 1.0, 11.0, 2.0)
    patches = {type(patch) for patch in ax.patches}
    assert patches == {Rectangle, Circle, Polygon}
    edges = [patch.get_edgecolor()[:3] for patch in ax.patches]
    assert (
        sum(
            np.allclose(np.array(edge) * 255, [int(USES["harvest"][i : i + 2], 16) for i in (1, 3, 5)])
            for edge in edges
        )
        == 1
    )
    assert max(p.get_zorder() for p in [*ax.patches, *strips]) < min(
        c.get_zorder() for c in ax.collections if c not in strips
    )


def test_roads_and_fences_of_layers_are_there_from_the_start(tmp_path):
    from ecs_eco.config.land.land import Land

    lines = [
        {"make": "roads", "line": [[0.0, 5.0], [9.0, 5.0]], "width": 2.0, "pace": 1.0, "cost": 1.0},
        {"make": "fences", "line": [[1.0, 1.0], [1.0, 9.0]]},
    ]
    flat = np.zeros((2, 2), np.float32)
    np.savez(tmp_path / "terrain.npz", **Land(flat, flat.astype("u1"), flat.astype(bool), lines).arrays())
    config = {"terrain": {"raster": "dem.npz", "layers": [{"file": "osm.gpkg"}]}}
    land = land_at(config, [], 3, tmp_path)
    assert land["roads"] == [{"line": [[0.0, 5.0], [9.0, 5.0]], "width": 2.0}]
    assert land["fences"] == [{"line": [[1.0, 1.0], [1.0, 9.0]]}]
    gone = [(2, {"kind": "fence", "at": 2, "line": [[1.0, 1.0], [1.0, 9.0]], "remove": True})]
    assert land_at(config, gone, 3, tmp_path)["fences"] == []
    (tmp_path / "empty").mkdir()
    assert land_at(config, [], 3, tmp_path / "empty")["roads"] == []
