"""Code shared by the goat studies: the world with one change, records of births, deaths and carriers, and
gene statistics."""

from collections.abc import Callable
from typing import Any

import numpy as np

GENES = ("red", "yellow", "green", "blue")
ARMS: dict[str, dict[str, Any]] = {  # each arm's change to the shipped world
    "goats": {},
    "frozen learning": {"learn": False},
    "no mutation": {"controls": ("no-mutation",)},
    "neutral drift": {"controls": ("neutral-drift",)},
    "no red gene": {"set": {"species.goat.genome.genes.0.values": [0, 0, 0, 0]}},
    "shuffled genome": {"controls": ("shuffled-genome",)},
}


class Family:
    """Births and deaths of one species, recorded as they happen."""

    def __init__(self, world: Any, species: str) -> None:
        from ecs_eco.record.genomes import letters_of

        self.world, self.table, self.letters = world, world.tables[species], letters_of(world.tables[species])
        self.births: list[tuple[np.ndarray, ...]] = []
        self.deaths: list[tuple[np.ndarray, ...]] = []
        rows = self.table.by_uid()
        self.born(self.table, rows, np.zeros(rows.size, np.uint64), np.zeros(rows.size, np.uint64))
        world.on_birth.append(self.born)
        world.on_death.append(self.died)

    def born(self, table: Any, rows: np.ndarray, first: np.ndarray, second: np.ndarray) -> None:
        """Record newborns: rows i64[k], uids of their parents u64[k]."""
        if table is self.table:
            from ecs_eco.components import Genome

            text = self.letters[table[Genome].loci[rows]]
            genome = text.view(f"{text.dtype.kind}{text.shape[1]}")[:, 0]
            self.births.append((table.uid[rows], first, second, np.full(rows.size, self.world.tick), genome))

    def died(self, table: Any, rows: np.ndarray) -> None:
        """Record deaths: rows i64[k]."""
        if table is self.table:
            self.deaths.append((table.uid[rows], np.full(rows.size, self.world.tick), table.cause[rows]))

    def lineage(self, since: int = 0) -> Any:
        """Return the Lineage of animals born at this tick or later."""
        from ecs_eco.analysis.lineage import Lineage
        from ecs_eco.record.genomes import genes_of

        uid, first, second, born, genome = (np.concatenate(c) for c in zip(*self.births, strict=True))
        of = born >= since
        uid, first, second, born, genome = (a[of] for a in (uid, first, second, born, genome))
        first, second = (np.where(np.isin(p, uid), p, np.uint64(0)) for p in (first, second))
        died, cause = np.full(len(uid), -1, np.int64), np.zeros(len(uid), np.int64)
        for dead, tick, why in self.deaths:
            known = np.isin(dead, uid)
            at = np.searchsorted(uid, dead[known])
            died[at], cause[at] = tick[known], why[known]
        return Lineage(
            uid,
            first,
            second,
            np.full(len(uid), self.table.name),
            born,
            died,
            np.array(["", *self.world.causes])[cause],
            genome.astype(str).astype(object),
            end=self.world.tick - 1,
            dt=self.world.dt,
            genomes={self.table.name: genes_of(self.table)},
        )


def identity() -> str:
    """Return the hash of the shipped world, so that changing the world invalidates the results."""
    import hashlib

    from ecs_eco.config import load

    return hashlib.sha256(str(load("reflexes").resolved(former=True)).encode()).hexdigest()[:16]


def live(
    seed: int,
    ticks: int,
    arm: str = "goats",
    also: dict[str, Any] | None = None,
    look: Callable[[Any], object] = lambda world: None,
) -> Family:
    """Run an arm's world; the run ends early if the goats die out.

    `also` contains further changes to the world file; `look` is called with the world every 100 ticks.
    """
    from ecs_eco import World
    from ecs_eco.config import load

    change = dict(ARMS[arm])
    world = World.from_config(
        load("reflexes", change.pop("set", {}) | (also or {})), seed=seed, record=False, **change
    )
    family = Family(world, "goat")
    while world.tick < ticks and family.table.n:
        world.run(min(100, ticks - world.tick))
        look(world)
    return family


def carriers(lineage: Any, every: int) -> dict[str, Any]:
    """Return ticks, numbers of living goats, their mean generation, and numbers of carriers of each gene:
    arrays [samples]."""
    by_gene = {gene: lineage.frequencies("goat", gene, every) for gene in GENES}
    out = {
        "tick": by_gene["blue"].ticks,
        "n": by_gene["blue"].n,
        "generation": mean_generation(lineage, "goat", every),
    }
    return out | {gene: carry(f) for gene, f in by_gene.items()}


def mean_generation(lineage: Any, species: str, every: int) -> np.ndarray:
    """Return the mean generation of a species' living animals at each sample: f64, NaN if no animals are
    alive."""
    mask, ticks = lineage.species == species, lineage.samples(every)
    n = lineage.living_sums(ticks, mask=mask)
    return lineage.living_sums(ticks, lineage.generation(), mask) / np.where(n, n, np.nan)


def carry(frequencies: Any) -> np.ndarray:
    """Return how many goats have a nonzero value of a gene, i64[samples]; 0 if it can only code for 0."""
    return (
        frequencies.count[:, -1]
        if len(frequencies.values) == 2
        else np.zeros(len(frequencies.ticks), np.int64)
    )


def text(x: np.ndarray) -> str:
    """Return numbers as one line of text."""
    return " ".join(f"{v:g}" for v in np.round(x, 2))


def numbers(line: str) -> np.ndarray:
    """Return the numbers in a line written by `text`: f64."""
    return np.array([float(v) for v in line.split()])
