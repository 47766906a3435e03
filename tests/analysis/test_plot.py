"""`world.plot()` draws a column of the series, which a notebook shows as a picture."""

import pytest

from ecs_eco import World
from ecs_eco.analysis.palette import safe


@pytest.fixture(scope="module")
def world():
    return World.from_config(
        {
            "format": 1,
            "name": "pond",
            "space": {"size": [9.0, 9.0]},
            "species": {
                "weed": {
                    "count": 5,
                    "color": "#123456",
                    "body": {"radius": 0.1},
                    "reproduction": {"kind": "spread", "rate": 0.0, "spacing": 1.0},
                },
                "alga": {
                    "count": 3,
                    "body": {"radius": 0.1},
                    "reproduction": {"kind": "spread", "rate": 0.0, "spacing": 1.0},
                },
            },
        }
    ).run(4)


def test_numbers_over_time_in_the_colours_of_the_world(world):
    figure = world.plot()
    lines = {line.get_label(): line for ax in figure.axes for line in ax.get_lines()}
    assert list(lines["weed"].get_ydata()) == [5, 5, 5, 5]
    colors = {name: kind.color for name, kind in sorted(world.config.species.items())}
    assert colors["weed"] == "#123456"
    assert lines["weed"].get_color() == safe(colors)["weed"]  # the color of its hue
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_another_column_and_one_species(world):
    figure = world.plot("stock_after", species=["alga"])
    assert figure.axes[0].get_ylabel() == "stock_after"
    assert [line.get_label() for line in world.plot(species=["alga"]).axes[0].get_lines()] == ["alga"]


def test_what_is_not_recorded_is_refused_with_the_nearest_name(world):
    with pytest.raises(KeyError, match=r'did you mean "births"\?'):
        world.plot("birth")
    with pytest.raises(KeyError, match="did you mean 'weed'"):
        world.plot(species=["weeds"])
