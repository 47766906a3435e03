# A newcomer's notebook, a cell after each "# %%"; from start/first_world.md, how-to/use_a_notebook.md and
# how-to/intervene.md.
# %%
from ecs_eco import World

grass = {
    "count": 300,
    "body": {"radius": 0.4, "opaque": False},
    "reproduction": {"kind": "spread", "rate": 0.05, "seed_rain": 0.002, "spacing": 2.0},
}
rabbit = {
    "count": 60,
    "body": {"radius": 0.3},
    "metabolism": {"energy": 0.5, "basal": 0.005},
    "locomotion": {"speed": {"sit": 0.0, "hop": 1.0}, "cost": {"hop": 0.005}, "turn": 0.8},
    "diet": [{"eats": "grass", "reach": 0.3, "gain": 0.2}],
    "actions": {"speed": ["sit", "hop"], "turn": ["left", "none", "right"], "eat": ["eat"]},
    "reproduction": {"kind": "asexual", "rate": 0.01, "energy_min": 0.7, "energy_given": 0.3},
    "lethal": [{"property": "energy", "min": 0.0, "cause_below": "starved"}],
}
meadow = {
    "format": 1,
    "name": "meadow",
    "space": {"size": [50.0, 50.0]},
    "species": {"grass": grass, "rabbit": rabbit},
}
world = World.from_config(meadow, seed=1, policies="random").run(60)
world
# %%
world.table("rabbit")
# %%
world.series()
# %%
world.plot("energy_mean", species=["rabbit"])
# %%
world.view(height=500)
# %%
world.intervene({"kind": "cull", "species": "rabbit", "share": 0.5, "cause": "shot"})
world.run(10)
frame = world.series().wide("n", "died: shot").to_pandas()
print(frame["died: shot rabbit"].sum() > 10, world.series().to_polars().height)
