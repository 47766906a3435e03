"""A day in a sea: a light reflex makes mites sink by day and rise by night. The script fits a cosinor to
their depth."""

from ecs_eco import World
from ecs_eco.analysis.rhythm import cosinor
from ecs_eco.analysis.runs import load_series

SEA = {
    "format": 1,
    "name": "small-sea",
    "space": {"size": [20.0, 20.0, 20.0]},
    "sun": {"day": 240.0, "start": 0.25},  # [s]; the run starts at sunrise
    "water": {"attenuation": 0.2},  # [1/m]
    "species": {
        "mite": {
            "count": 100,
            "body": {"radius": 0.1, "mass": 0.001},
            "metabolism": {"energy": 1.0},
            "locomotion": {"speed": {"swim": 0.5}, "climb": 0.5},
            "sensors": [{"kind": "light", "name": "light"}],
            "actions": {"climb": ["up", "none", "down"]},
            "default_action": {"climb": "none"},
            "reflex": {"formulas": {"up": "1 if light < 0.05 else -1", "down": "1 if light > 0.15 else -1"}},
        }
    },
}

world = World.from_config(SEA, seed=1).run(3 * 240)
series = load_series(world.series())
depth = series.of("mite", "depth_mean")
for eighth in range(8):
    mean = depth[480 + 30 * eighth : 510 + 30 * eighth].mean()
    print(f"{(6 + 3 * eighth) % 24:2d} h  {mean:4.1f} m  {'·' * round(2 * mean)}")
fit = cosinor(series.ticks[240:] / 240 + 0.25 - 0.5, depth[240:], 1.0)  # time in days from noon
print(f"amplitude {fit.amplitude:.1f} m of 20")
