"""A family tree: record births and deaths, query ancestors, and write the tree."""

from ecs_eco import World
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.config import load
from ecs_eco.record import Recorder

FEW = {
    "space.size": [60.0, 60.0],
    "species.grass.count": 300,
    "species.deer.count": 30,
    "species.wolf.count": 1,
}

if __name__ == "__main__":
    world = World.from_config(load("predator-prey", FEW), seed=1, policies="random", record=False)
    Recorder(world, keep_events=True)  # for a recorded run, use Lineage.read(folder)
    world.run(200)

    grass = Lineage.of(world).of_species("grass")
    print(
        f"{grass.founders.sum()} without parents, {len(grass.founders_left())} of them with living descendants"
    )
    youngest = int(grass.uid[-1])
    print(f"the ancestors of {youngest}, oldest first: {grass.ancestors(youngest).tolist()}")
    print(f"mean generation of living plants: {grass.generation()[grass.alive(grass.end)].mean():.1f}")

    print("written:", grass.to_csv("grass.csv"))  # for tools that read the ALife data standard
    tree = grass.to_newick("grass.nwk", living=True)  # for tools that draw trees
    print(f"a tree with {tree.count(',') + 1} tips: {tree[:60]}…")
