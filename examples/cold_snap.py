"""Cold winters kill hares with thin coats, so genes for insulation spread."""

import numpy as np

from ecs_eco import World
from ecs_eco.components import Coat
from ecs_eco.config import load

YEAR, WINTER = 60, 30  # [ticks], each one minute long
HARE = {
    "count": 150,
    "max_count": 300,
    "body": {"radius": 0.15, "mass": 2.0, "opaque": False},
    "properties": {"temperature": 312.0},
    "metabolism": {"energy": 0.5, "energy_max": 1.0, "basal": 1e-4, "photosynthesis": 1e-3},
    # 15 W at rest; shivering adds up to 40 W, which costs 2.4 times the basal rate
    "heat": {
        "metabolic_heat": 150_000.0,
        "regulate": {"set_point": 312.0, "warming": 40.0, "cooling": 40.0, "cost": 6e-6},
    },
    "genome": {
        "alphabet": "01",
        "mutate": {"operator": "mutFlipBit", "indpb": 0.01},
        "genes": [
            {
                "name": "coat",
                "trait": "heat.insulation",
                "letters": 6,
                "code": "gray",
                "low": 0.0,
                "high": 0.2,
            }
        ],
    },
    "reproduction": {
        "kind": "asexual",
        "rate": 1e-3,
        "energy_min": 0.6,
        "energy_given": 0.3,
        "dispersal": 20.0,
    },
    "lethal": [
        {
            "property": "temperature",
            "min": 300.0,
            "max": 316.0,
            "cause_below": "frozen",
            "cause_above": "overheated",
        },
        {"property": "energy", "min": 0.0, "cause_below": "starved"},
        {"property": "age", "max": 3 * YEAR * 60.0, "cause_above": "too old"},
    ],
}


def lived(winter: float, years: int = 6) -> World:
    """Return a valley after several years with 295 K summers and winters of the given temperature [K]."""
    months = [(YEAR - WINTER, winter), (YEAR, 295.0)]
    plan = [
        {"kind": "set", "at": at, "every": YEAR, "set": {"ambient.temperature": kelvin}}
        for at, kelvin in months
    ]
    valley = {
        "format": 1,
        "name": "valley",
        "dt": 60.0,
        "ticks": years * YEAR,
        "space": {"size": [200.0, 200.0]},
        "ambient": {"temperature": 295.0},
        "species": {"hare": HARE},
        "interventions": plan,
    }
    return World.from_config(load(valley), seed=1).run(valley["ticks"])


if __name__ == "__main__":
    for winter in (295.0, 265.0, 245.0):
        world = lived(winter)
        hares, died = world.table("hare"), world.series().to_pydict()
        coat = hares[Coat].insulation[hares.rows()]
        frozen, starved = (int(np.sum(died.get(f"died: {cause}", 0))) for cause in ("frozen", "starved"))
        print(
            f"winters of {winter:.0f} K: {hares.n:3} hares, coats of {coat.mean():.3f} ± {coat.std():.3f} "
            f"K m²/W; {frozen} froze, {starved} starved"
        )
