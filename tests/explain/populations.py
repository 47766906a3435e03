"""Populations of overlapping generations in numpy, far quicker than a world: their lineages have genomes."""

import numpy as np

from ecs_eco.analysis.lineage import Lineage


def population(
    seed,
    n=300,
    ticks=600,
    loci=4,
    *,
    ploidy=1,
    parents=1,
    recombination=0.5,
    mutation=0.0,
    s=0.0,
    locus=0,
    start=0.5,
    adult=5,
    death=0.05,
    founders=None,
    letters="AT",
):
    """The lineage of n organisms that die at random, and are replaced by children of adults; T at `locus`
    multiplies the birth rate by e**s, in a diploid for each copy. Every newborn letter changes with
    probability `mutation`."""
    rng = np.random.default_rng(seed)
    one = rng.random((n, ploidy, loci)) < 0.5
    one[:, :, locus] = rng.permuted(np.arange(n * ploidy) < round(start * n * ploidy)).reshape(n, ploidy)
    if founders is not None:
        one = founders
    born, genomes, lines = [np.zeros(n, int)], [one], [np.full((n, 2), -1)]
    died = {}
    row, birth, uids = one.copy(), np.zeros(n, int) - rng.integers(0, 40, n), np.arange(n)
    total = n
    for tick in range(1, ticks + 1):
        dead = np.flatnonzero(rng.random(n) < death)
        able = np.flatnonzero(tick - birth >= adult)
        able = able[~np.isin(able, dead)]
        if not len(dead) or not len(able):
            continue
        weight = np.exp(s * row[able, :, locus].sum(axis=1))
        pair = rng.choice(able, (len(dead), 2), p=weight / weight.sum())
        child = row[pair[:, 0]].copy()
        if parents == 2:
            crossed = np.cumsum(rng.random((len(dead), 2, loci)) < recombination, axis=2)
            which = (rng.integers(0, 2, (len(dead), 2, 1)) + crossed) % 2
            if ploidy == 1:
                child[:, 0] = np.where(which[:, 0] == 0, row[pair[:, 0], 0], row[pair[:, 1], 0])
            else:
                for side in range(2):
                    of = row[pair[:, side]]
                    child[:, side] = np.where(which[:, side] == 0, of[:, 0], of[:, 1])
        child ^= rng.random(child.shape) < mutation
        died |= dict.fromkeys(uids[dead].tolist(), tick)
        line = uids[pair]
        if parents == 1:
            line[:, 1] = -1
        lines.append(line)
        row[dead], birth[dead], uids[dead] = child, tick, total + np.arange(len(dead))
        born.append(np.full(len(dead), tick))
        genomes.append(child)
        total += len(dead)
    line = np.concatenate(lines)
    ends = np.full(total, -1)
    ends[list(died)] = list(died.values())
    codes = np.array([ord(c) for c in letters], np.uint8)[np.concatenate(genomes).astype(int)]
    text = codes.reshape(total, -1).view(f"S{ploidy * loci}")[:, 0].astype(str).astype(object)
    known = {"a": {"alphabet": letters, "ploidy": ploidy, "genes": []}}
    parent = (line + 1).astype(np.uint64)
    causes = np.full(total, "")
    return Lineage(
        np.arange(1, total + 1, dtype=np.uint64),
        parent[:, 0],
        parent[:, 1],
        np.full(total, "a"),
        np.concatenate(born),
        ends,
        causes,
        text,
        ticks,
        1.0,
        known,
    )
