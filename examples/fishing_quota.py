"""Compare five rules for fishing a sea, including a quota, a wide mesh and a closed season."""

import copy
from typing import Any

from ecs_eco import World
from ecs_eco.components import Body

YEAR, YEARS = 50.0, 12  # [s]; a tick lasts one second
SEA = {
    "format": 1,
    "name": "north-sea",
    "ticks": 1000,
    "space": {"size": [80.0, 80.0]},
    "species": {
        "cod": {
            "count": 300,
            "max_count": 1200,
            "color": "#4477aa",
            "body": {"radius": 0.2, "opaque": False},
            "metabolism": {"energy": 0.5, "energy_max": 1.0, "photosynthesis": 0.03},
            "reproduction": {
                "kind": "asexual",
                "place": "anywhere",
                "rate": 0.04,
                "energy_min": 0.9,
                "energy_given": 0.4,
                "spacing": 2.5,
            },
            "genome": {
                "genes": [{"name": "girth", "trait": "body.radius", "letters": 4, "low": 0.1, "high": 0.4}]
            },
            "lethal": [{"property": "age", "max": 150.0, "cause_above": "too old"}],
        }
    },
}
NETS: dict[str, dict[str, Any] | None] = {
    "no fishing": None,
    "no limit": {"rate": 0.06},
    "a quota": {"rate": 0.06, "quota": 40},
    "a wide mesh": {"rate": 0.06, "least": 0.25},
    "a closed season": {"rate": 0.06, "season": [0.0, 0.3]},
}


def fished(net: dict[str, Any] | None) -> World:
    """Return the sea after twelve years of fishing with these nets."""
    config: dict[str, Any] = copy.deepcopy(SEA)
    if net is not None:
        config["land_use"] = [{"kind": "harvest", "species": "cod", "period": YEAR, "cause": "fished"} | net]
    return World.from_config(config, seed=1).run(int(YEAR * YEARS))


if __name__ == "__main__":
    for name, net in NETS.items():
        world = fished(net)
        cod = world.tables["cod"]
        series = world.series().to_pydict()
        catch = sum(series.get("died: fished", [0]))
        last = sum(series.get("died: fished", [0])[-int(3 * YEAR) :])
        size = cod[Body].radius[cod.rows()].mean() if cod.n else 0.0
        print(
            f"{name:16} {cod.n:5} cod left, {catch:6,} caught, {last / 3:5.0f} a year in the last three; "
            f"mean radius {size:.2f} m"
        )
