"""The common task of `peers.py` in mesa-frames: agents are rows in a polars DataFrame, and steps are
expressions.

Its spaces are grids of cells; a join on cells finds neighbors within REACH on the plane.
"""

import math
from typing import Any

import numpy as np
from peers_grazing import (
    BITE,
    CHANCE,
    COST,
    ENOUGH,
    GAIN,
    GIVEN,
    REACH,
    REGROWTH,
    SITE,
    SPEED,
    TURN,
    Model,
    side,
)


def mesa_frames(n: int, seed: int) -> Model:
    """Run the task in mesa-frames 0.1 with an AgentSetPolars."""
    import warnings

    warnings.simplefilter("ignore")
    import polars as pl
    from mesa_frames import AgentSetPolars, ModelDF

    size, sites = side(n), int(side(n) / SITE)

    class Grazers(AgentSetPolars):  # type: ignore[misc]
        """All grazers."""

        def __init__(self, model: Any) -> None:
            super().__init__(model)
            self.born, self.ripe = n, np.ones(sites * sites, bool)
            self += pl.DataFrame(
                {"unique_id": np.arange(n), "energy": np.full(n, 0.5)}
                | {
                    name: model.random.uniform(0, top, n)
                    for name, top in (("x", size), ("y", size), ("heading", 2 * math.pi))
                }
            )

        def step(self) -> None:
            """Have all grazers look, turn, walk, eat, and divide or die at once; then grow grass."""
            rng = self.model.random
            walked = turned(self.agents, size).with_columns(
                x=(pl.col("x") + SPEED * pl.col("heading").cos()) % size,
                y=(pl.col("y") + SPEED * pl.col("heading").sin()) % size,
                energy=pl.col("energy") - COST,
            )
            fed = walked.with_columns(
                energy=pl.when(pl.Series(eaters(walked, self.ripe, sites)))
                .then((pl.col("energy") + GAIN).clip(upper_bound=1.0))
                .otherwise(pl.col("energy"))
            )
            chance = pl.Series(rng.random(len(fed)))
            divides = (fed["energy"] >= ENOUGH) & (chance < CHANCE)
            k = int(divides.sum())
            young = fed.filter(divides).with_columns(
                unique_id=pl.Series(np.arange(self.born, self.born + k)),
                energy=pl.lit(GIVEN),
                heading=pl.Series(rng.uniform(0, 2 * math.pi, k)),
            )
            self.born += k
            self.agents = fed.with_columns(energy=pl.col("energy") - GIVEN * divides.cast(pl.Float64))
            self += young.select(self.agents.columns)
            self.discard(self.agents.filter(pl.col("energy") <= 0)["unique_id"])
            self.ripe |= rng.random(self.ripe.size) < REGROWTH

    class Grazing(ModelDF):  # type: ignore[misc]
        """The model."""

        def __init__(self) -> None:
            super().__init__(seed)
            self.agents += Grazers(self)

    model = Grazing()
    return model.step, lambda: len(model.agents.get(["unique_id"]).popitem()[1])


def turned(agents: Any, size: float) -> Any:
    """Return the grazers turned away from their nearest neighbor within REACH."""
    import polars as pl

    cells = int(size / REACH)
    near = pl.DataFrame([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)], schema=["di", "dj"], orient="row")

    def shorter(column: str) -> Any:
        d = pl.col(f"{column}_other") - pl.col(column)
        return d - size * (d / size).round()

    here = agents.with_columns(
        i=(pl.col("x") / size * cells).cast(pl.Int64).clip(0, cells - 1),
        j=(pl.col("y") / size * cells).cast(pl.Int64).clip(0, cells - 1),
    )
    looked = here.join(near, how="cross").with_columns(
        i=(pl.col("i") + pl.col("di")) % cells, j=(pl.col("j") + pl.col("dj")) % cells
    )
    pairs = (
        looked.join(here.select("unique_id", "x", "y", "i", "j"), on=["i", "j"], suffix="_other")
        .filter(pl.col("unique_id") != pl.col("unique_id_other"))
        .with_columns(dx=shorter("x"), dy=shorter("y"))
        .with_columns(d=pl.col("dx") ** 2 + pl.col("dy") ** 2)
        .filter(pl.col("d") < REACH * REACH)
    )
    closest = pairs.group_by("unique_id").agg(pl.col("dx", "dy").sort_by("d").first())
    left = pl.col("heading").cos() * pl.col("dy") - pl.col("heading").sin() * pl.col("dx")
    turn = pl.when(left > 0).then(-TURN).when(left <= 0).then(TURN).otherwise(0.0)
    return (
        agents.join(closest, on="unique_id", how="left")
        .with_columns(heading=pl.col("heading") + turn)
        .drop("dx", "dy")
    )


def eaters(walked: Any, ripe: np.ndarray, sites: int) -> np.ndarray:
    """Return, as bool[n], which grazers get a tuft (the first at each ripe site within BITE), and remove
    these tufts."""
    x, y = walked["x"].to_numpy(), walked["y"].to_numpy()
    i, j = (np.minimum((a / SITE).astype(int), sites - 1) for a in (y, x))
    site = i * sites + j
    touches = ((x - (j + 0.5) * SITE) ** 2 + (y - (i + 0.5) * SITE) ** 2 < BITE**2) & ripe[site]
    (rows,) = touches.nonzero()
    _, first = np.unique(site[rows], return_index=True)
    eats = np.zeros(len(x), bool)
    eats[rows[first]] = True
    ripe[site[eats]] = False
    return eats
