"""An archipelago of newts, who only breed and age, that runs in milliseconds; as a file."""

from pathlib import Path

WORLD = """
format = 1
name = "newts"
ticks = 12
dt = 1.0
[space]
size = [12.0, 12.0]
edges = "torus"
[species.newt]
count = 20
body = { radius = 0.1, mass = 0.1 }
metabolism = { energy = 0.8, energy_max = 1.0, basal = 0.01 }
reproduction = { kind = "asexual", rate = 0.1, energy_min = 0.5, energy_given = 0.2, dispersal = 1.0 }
lethal = [{ property = "energy", min = 0.0, cause_below = "starved" }]
[archipelago]
migration_interval = 4
graph = "ring"
migration_probability = { newt = 0.3 }
[archipelago.islands]
north = {}
east = { "species.newt.count" = 40 }
south = { "species.newt.count" = 5 }
"""


def written(folder: Path) -> Path:
    """Write the world; return its file."""
    path = folder / "islands.toml"
    path.write_text(WORLD)
    return path
