"""A world that runs in milliseconds, and a plan for it."""

from __future__ import annotations

from pathlib import Path

WORLD = """
format = 1
name = "moss"
ticks = 12
dt = 1.0
[space]
size = [12.0, 12.0]
edges = "torus"
[species.moss]
count = 20
body = { radius = 0.1, mass = 0.1 }
metabolism = { energy = 1.0, energy_max = 1.0, basal = 0.01 }
reproduction = { kind = "spread", rate = 0.1, seed_rain = 0.001, spacing = 1.0, place = "anywhere" }
"""
PLAN = """
world = "moss.toml"
ticks = 6
world_seeds = 2
[grid]
species.moss.count = [10, 30]
"""


def written(folder: Path, plan: str = PLAN, world: str = WORLD) -> Path:
    """Write a world and a plan; return the plan's file."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "moss.toml").write_text(world)
    (folder / "plan.toml").write_text(plan)
    return folder / "plan.toml"
