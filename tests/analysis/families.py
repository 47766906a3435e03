"""Families for tests of lineages: one made by hand, forests at random, herds with recorded fields, and a reader of
Newick trees."""

import json
import re
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ecs_eco.analysis.lineage import ALIVE, Lineage

#         uid, mother, father, born, died, genome
FAMILY = [
    (1, 0, 0, 0, 4, "AA"),
    (2, 0, 0, 0, 7, "CA"),
    (3, 1, 0, 2, 6, "AA"),
    (4, 1, 2, 3, 9, "CA"),
    (5, 3, 4, 5, ALIVE, "AC"),
    (6, 5, 0, 8, ALIVE, "TA"),
    (7, 0, 0, 8, ALIVE, "CG"),
    (8, 6, 7, 9, ALIVE, "TT"),
    (9, 0, 0, 9, 10, "AA"),
]
SIZE, PACE = "birth: Body.radius", "birth: Speed.pace"
GENES = {
    "finch": {
        "alphabet": "ACGT",
        "ploidy": 1,
        "genes": [
            {"name": "beak", "at": 0, "letters": 1, "trait": "body.mass"},
            {
                "name": "red",
                "at": 0,
                "letters": 1,
                "trait": "reflex.red.weight",
                "values": [0.0, 0.0, 0.0, -1.0],
            },
            {"name": "song", "at": 1, "letters": 1, "trait": "Song.length", "values": [3.0, 1.0, 3.0, 2.0]},
        ],
    }
}


def family(rows=FAMILY, species="finch", end=10, genomes=GENES):
    uid, parent, parent2, born, died, genome = zip(*rows, strict=True)
    names = [species] * len(rows) if isinstance(species, str) else species
    return Lineage(
        np.array(uid, np.uint64),
        np.array(parent, np.uint64),
        np.array(parent2, np.uint64),
        np.array(names),
        np.array(born),
        np.array(died),
        np.where(np.array(died) < 0, "", "starved"),
        np.array(genome, object),
        end,
        1.0,
        genomes,
    )


def herd(mother, father, born, died, end, **fields):
    """A lineage of finches from indices of parents (−1: none) and recorded fields."""
    rows = zip(np.add(mother, 1), np.add(father, 1), born, died, strict=True)
    made = family([(i + 1, *map(int, row), "AA") for i, row in enumerate(rows)], end=end)
    return replace(made, recorded={name: np.array(of, float) for name, of in fields.items()})


def numbers(cohort):
    """The estimates of a cohort, without intervals."""
    return {name: x.value for name, x in cohort.estimates.items()}


def write_folder(folder, rows=FAMILY, genome=True, genomes=GENES):
    """A run folder with the births and deaths of a family, and no more than that."""
    uid, parent, parent2, born, died, letters = (np.array(c) for c in zip(*rows, strict=True))
    births = {
        "tick": born,
        "species": pa.array(["finch"] * len(uid)).dictionary_encode(),
        "uid": uid.astype(np.uint64),
        "parent": parent.astype(np.uint64),
        "parent2": parent2.astype(np.uint64),
    } | ({"genome": letters} if genome else {})
    gone = np.argsort(died, kind="stable")[(died < 0).sum() :]
    deaths = {
        "tick": died[gone],
        "species": pa.array(["finch"] * len(gone)).dictionary_encode(),
        "uid": uid[gone].astype(np.uint64),
        "cause": pa.array(["starved"] * len(gone)).dictionary_encode(),
    }
    for kind, columns in (("births", births), ("deaths", deaths)):
        (folder / kind).mkdir(parents=True)
        for part in range(2):  # in two parts
            half = len(columns["uid"]) // 2
            rows_of_part = slice(0, half) if part == 0 else slice(half, None)
            pq.write_table(
                pa.table({k: v[rows_of_part] for k, v in columns.items()}),
                folder / kind / f"part-{part:05d}.parquet",
            )
    (folder / "manifest.json").write_text(
        json.dumps({"done": 11, "dt": 1.0, "species": ["finch"], "genomes": genomes})
    )
    return folder


def parsed(newick):
    """The parent's name ("" for the root without a name) and branch length of each node,
    read letter by letter."""
    parents, open_, at = {}, [], len(newick) - 2
    assert newick.endswith(";")
    while at >= 0:  # from the end: a name stands behind its children
        if newick[at] == "(":
            open_.pop()
            at -= 1
        elif newick[at] == ",":
            at -= 1
        else:
            label = re.search(r"('(?:[^']|'')*'|[^(),:']*)(?::([0-9.]+))?$", newick[: at + 1])
            name = label[1].strip("'").replace("''", "'")
            if name or label[2]:
                parents[name] = (open_[-1] if open_ else None, float(label[2] or 0))
            at -= len(label[0])
            if at >= 0 and newick[at] == ")":
                open_.append(name)
                at -= 1
    return parents


def forest(seed, n=60):
    """A family at random: parents are alive when their child is born, some have two, some none."""
    rng = np.random.default_rng(seed)
    born = np.sort(rng.integers(0, 30, n))
    died = np.where(rng.random(n) < 0.7, born + rng.integers(1, 12, n), ALIVE)
    rows = []
    for i in range(n):
        able = [j for j in range(i) if born[j] < born[i] and (died[j] < 0 or died[j] >= born[i])]
        two = [*rng.permutation(able)[:2], -1, -1][:2] if able and rng.random() < 0.8 else [-1, -1]
        mother, father = two[0], two[1] if rng.random() < 0.5 else -1
        rows.append(
            (
                3 * i + 1,
                *(3 * int(p) + 1 if p >= 0 else 0 for p in (mother, father)),
                int(born[i]),
                int(min(died[i], 30)),
                "".join(rng.choice(list("ACGT"), 2)),
            )
        )
    return rows
