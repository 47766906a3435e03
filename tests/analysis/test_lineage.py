"""Lineages of families made by hand, with counted answers; of forests at random, against slow twins."""

import json
import time

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from ecs_eco.analysis.lineage import ALIVE, Lineage
from tests.analysis.families import FAMILY, GENES, family, forest, write_folder

# questions


def test_ancestors_come_through_both_parents():
    lineage = family()
    assert lineage.ancestors(5).tolist() == [1, 2, 3, 4]
    assert lineage.ancestors(5, 1).tolist() == [3, 4]
    assert lineage.ancestors(8, 2).tolist() == [5, 6, 7]
    assert lineage.ancestors(1).tolist() == []
    assert lineage.ancestors(5, 0).tolist() == []


def test_descendants_come_through_both_parents():
    lineage = family()
    assert lineage.descendants(2).tolist() == [4, 5, 6, 8]
    assert lineage.descendants(7).tolist() == [8]
    assert lineage.descendants(9).tolist() == []


def test_a_generation_is_the_mean_of_the_parents_plus_one():
    assert family().generation().tolist() == [0, 0, 1, 1, 2, 3, 0, 2.5, 0]


def test_founders_are_left_while_they_or_their_descendants_live():
    lineage = family()
    assert lineage.founders_left(1).tolist() == [1, 2]
    assert lineage.founders_left(9).tolist() == [1, 2, 7, 9]
    assert lineage.founders_left().tolist() == [1, 2, 7]


def test_the_most_recent_common_ancestor_is_along_mothers():
    lineage = family()
    assert lineage.most_recent_common_ancestor([4, 5]) == 1
    assert lineage.most_recent_common_ancestor([8, 5]) == 5
    assert lineage.most_recent_common_ancestor([8, 7]) == 0  # 7 is a father
    assert lineage.most_recent_common_ancestor([6]) == 6
    with pytest.raises(ValueError, match="no uids to find"):
        lineage.most_recent_common_ancestor([])


def _plain_ancestors(rows, uid):
    parents = {r[0]: [p for p in r[1:3] if p] for r in rows}
    return {a for p in parents[uid] for a in [p, *_plain_ancestors(rows, p)]}


@pytest.mark.parametrize("seed", range(5))
def test_answers_agree_with_their_slow_plain_twins(seed):
    rows = forest(seed)
    lineage, of = family(rows, end=30), {r[0]: r for r in rows}
    above = {uid: _plain_ancestors(rows, uid) for uid in of}
    depth = {0: -1.0}
    for uid, mother, father, *_ in rows:
        parents = [depth[p] for p in (mother, father) if p]
        depth[uid] = sum(parents) / len(parents) + 1 if parents else 0.0
    assert lineage.generation().tolist() == [depth[r[0]] for r in rows]
    for uid in of:
        assert lineage.ancestors(uid).tolist() == sorted(above[uid])
        assert lineage.descendants(uid).tolist() == sorted(d for d in of if uid in above[d])
    for tick in (0, 7, 30):
        living = {r[0] for r in rows if r[3] <= tick and not 0 <= r[4] <= tick}
        lines = living.union(*(above[uid] for uid in living))
        assert lineage.founders_left(tick).tolist() == sorted(uid for uid in lines if of[uid][1:3] == (0, 0))
        assert lineage.uid[lineage.alive(tick)].tolist() == sorted(living)
        counted = lineage.frequencies("finch", (1, 1), 1)
        assert [counted.count[tick, counted.values.index(c)] for c in counted.values] == [
            sum(of[u][5][1] == c for u in living) for c in counted.values
        ]


def test_pruned_to_the_living_a_lineage_keeps_their_ancestors_alone():
    assert family().living().uid.tolist() == [1, 2, 3, 4, 5, 6, 7, 8]
    assert family([*FAMILY[:4], (10, 2, 0, 6, ALIVE, "AA")]).living().uid.tolist() == [2, 10]


def test_one_species_is_a_lineage_of_its_own():
    lineage = family(species=["finch"] * 6 + ["wren"] * 3)
    assert lineage.of_species("finch").uid.tolist() == [1, 2, 3, 4, 5, 6]
    assert lineage.of_species("wren").parent.tolist() == [0, 0, 0]  # 8 has parents of another species
    with pytest.raises(KeyError, match="unknown species 'wrem'; known: finch, wren; did you mean \"wren\""):
        lineage.of_species("wrem")


# what does not fit


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (
            (10, 10, 0, 9, ALIVE, "A"),
            "the organism 10 has the parent 10; expected 0 or the uid of an earlier organism",
        ),
        (
            (10, 1, 12, 9, ALIVE, "A"),
            "the organism 10 has the parent 12; expected 0 or the uid of an earlier",
        ),
        ((19, 0, 11, 9, ALIVE, "A"), "the organism 19 has the parent 11, whose birth is not recorded"),
        ((9, 0, 0, 9, ALIVE, "A"), "the uid 9 is a duplicate or out of order"),
    ],
)
def test_loops_unknown_parents_and_twins_are_refused(row, message):
    with pytest.raises(ValueError, match=message):
        family([*FAMILY, row])


def test_the_death_of_one_who_was_not_born_is_refused(tmp_path):
    folder = write_folder(tmp_path / "run")
    pq.write_table(
        pa.table({"tick": [3], "species": ["finch"], "uid": pa.array([77], pa.uint64()), "cause": ["old"]}),
        folder / "deaths" / "part-00002.parquet",
    )
    with pytest.raises(ValueError, match="lineage: 77 died, but its birth was not recorded"):
        Lineage.read(folder)


def test_names_and_numbers_that_are_not_there_are_said():
    lineage = family()
    for ask in (lineage.ancestors, lineage.descendants, lineage.place):
        with pytest.raises(KeyError, match="no organism of this lineage has the uid 12"):
            ask(12)
    with pytest.raises(KeyError, match="unknown gene 'beek'; known: beak, red, song; did you mean"):
        lineage.frequencies("finch", "beek", 1)
    with pytest.raises(KeyError, match="unknown species 'fynch'"):
        lineage.frequencies("fynch", "beak", 1)
    with pytest.raises(ValueError, match="gene '1:3' is at loci 1 to 2; a genome of 'finch' has 2 loci"):
        lineage.frequencies("finch", (1, 2), 1)
    with pytest.raises(ValueError, match="every is 0; it must be at least 1 tick"):
        lineage.frequencies("finch", "beak", 0)
    with pytest.raises(KeyError, match="unknown value 'G'; known: A, C, T"):
        lineage.frequencies("finch", "beak", 1).of("G")


# files


def test_a_folder_is_read_as_it_was_written(tmp_path):
    lineage, expected = Lineage.read(write_folder(tmp_path / "run")), family()
    for name in ("uid", "parent", "parent2", "species", "born", "died", "cause", "genome"):
        assert getattr(lineage, name).tolist() == getattr(expected, name).tolist(), name
    assert (lineage.end, lineage.dt, lineage.genomes) == (10, 1.0, GENES)


def test_an_old_folder_without_genomes_and_founders_is_readable(tmp_path):
    old = [row for row in FAMILY if row[1]]  # 9 left nothing but its death, which these rows lack, too
    folder = write_folder(tmp_path / "run", old, genome=False, genomes={})
    pq.write_table(
        pa.table(
            {
                "tick": [4, 10],
                "species": ["finch", "finch"],
                "uid": pa.array([1, 9], pa.uint64()),
                "cause": ["old", "old"],
            }
        ),
        folder / "deaths" / "part-00002.parquet",
    )
    lineage = Lineage.read(folder)
    assert lineage.uid.tolist() == list(range(1, 10))
    assert lineage.founders.tolist() == [True, True, False, False, False, False, True, False, True]
    assert lineage.died[[0, 1, 8]].tolist() == [4, ALIVE, 10]
    assert lineage.born[lineage.founders].tolist() == [0] * 4
    assert set(lineage.species) == {"finch"}
    assert set(lineage.genome) == {""}


# size


@pytest.mark.slow
def test_a_million_births_are_read_and_counted_in_seconds(tmp_path):
    rng, n = np.random.default_rng(1), 1_000_000
    born = np.sort(rng.integers(1, 10_000, n))
    died = born + rng.integers(1, 300, n)
    parent = np.where(np.arange(n) < 1000, 0, np.maximum(np.arange(n) - rng.integers(1, 999, n), 1))
    genome = np.frombuffer(rng.choice(np.frombuffer(b"ACGT", np.uint8), 12 * n).tobytes(), "S12").astype(str)
    rows = (np.arange(1, n + 1), parent, np.zeros(n, int), born, died, genome)
    folder = tmp_path / "run"
    columns = dict(zip(("uid", "parent", "parent2", "tick", "died", "genome"), rows, strict=True))
    whole = pa.table(
        {k: v for k, v in columns.items() if k != "died"}
        | {"species": pa.array(["finch"] * n).dictionary_encode()}
    )
    gone = pa.table({"tick": died, "species": ["finch"] * n, "uid": rows[0], "cause": [""] * n})
    for kind, table in (("births", whole), ("deaths", gone)):
        (folder / kind).mkdir(parents=True)
        pq.write_table(table, folder / kind / "part-00000.parquet")
    (folder / "manifest.json").write_text(json.dumps({"done": 10_300, "dt": 1.0, "genomes": GENES}))
    start = time.process_time()
    lineage = Lineage.read(folder)
    share = lineage.frequencies("finch", "red", 20)
    generation = lineage.generation()
    seconds = time.process_time() - start
    assert share.count[100].sum() == share.n[100] == ((born <= 2000) & (died > 2000)).sum()
    assert generation[lineage.alive(4000)].mean() > 1
    assert seconds < 15
