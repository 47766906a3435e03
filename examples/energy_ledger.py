"""The energy ledger accounts for all of a species' energy in every tick."""

import numpy as np

from ecs_eco import World

if __name__ == "__main__":
    world = World.from_config("predator-prey", policies="random").run(50)
    series = world.series()
    deer = np.array(series["species"].to_pylist()) == "deer"
    page = {name: series[name].to_numpy()[deer] for name in series.column_names if name != "species"}
    after = (
        page["stock_before"]
        + page["endowed"]
        + page["taken_in"]
        - page["burnt"]
        - page["given"]
        - page["lost"]
    )
    for name in ("endowed", "taken_in", "burnt", "given", "lost"):
        print(f"{name:9} {page[name].sum():9.3f}")
    print(
        f"largest error of the ledger in {len(after)} ticks: {np.abs(after - page['stock_after']).max():.1e}"
    )
