"""Families made by hand with counted answers, forests at random against slow plain twins, and a real run."""

import csv
import json
import re
import shutil
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

from ecs_eco import World
from ecs_eco.analysis.carriers import carriers, codon_number
from ecs_eco.analysis.figures import save
from ecs_eco.analysis.lineage import ALIVE, Lineage
from ecs_eco.analysis.phylogeny import quoted
from ecs_eco.analysis.report import write_report
from ecs_eco.analysis.runs import load_series
from ecs_eco.cli import app
from ecs_eco.components.genome import Genome
from ecs_eco.record import Recorder, run_to_folder
from ecs_eco.record.belonging import mark_of
from ecs_eco.record.parquet import write_part
from ecs_eco.record.seal import write_manifest

#         uid, mother, father, born, died, genome
FAMILY = [(1, 0, 0, 0, 4, "AA"), (2, 0, 0, 0, 7, "CA"), (3, 1, 0, 2, 6, "AA"), (4, 1, 2, 3, 9, "CA"),
          (5, 3, 4, 5, ALIVE, "AC"), (6, 5, 0, 8, ALIVE, "TA"), (7, 0, 0, 8, ALIVE, "CG"),
          (8, 6, 7, 9, ALIVE, "TT"), (9, 0, 0, 9, 10, "AA")]  # fmt: skip
GENES = {"finch": {"alphabet": "ACGT", "ploidy": 1, "genes": [
    {"name": "beak", "at": 0, "letters": 1, "trait": "body.mass"},
    {"name": "red", "at": 0, "letters": 1, "trait": "reflex.red.weight", "values": [0.0, 0.0, 0.0, -1.0]},
    {"name": "song", "at": 1, "letters": 1, "trait": "Song.length", "values": [3.0, 1.0, 3.0, 2.0]},
]}}  # fmt: skip


def family(rows=FAMILY, species="finch", end=10, genomes=GENES):
    uid, parent, parent2, born, died, genome = zip(*rows, strict=True)
    names = [species] * len(rows) if isinstance(species, str) else species
    return Lineage(np.array(uid, np.uint64), np.array(parent, np.uint64), np.array(parent2, np.uint64),
                   np.array(names), np.array(born), np.array(died),
                   np.where(np.array(died) < 0, "", "starved"), np.array(genome, object), end, 1.0, genomes)


def write_folder(folder, rows=FAMILY, genome=True, genomes=GENES):
    """A run folder with the births and deaths of a family, and no more than that."""
    uid, parent, parent2, born, died, letters = (np.array(c) for c in zip(*rows, strict=True))
    births = {"tick": born, "species": pa.array(["finch"] * len(uid)).dictionary_encode(),
              "uid": uid.astype(np.uint64), "parent": parent.astype(np.uint64),
              "parent2": parent2.astype(np.uint64)} | ({"genome": letters} if genome else {})
    gone = np.argsort(died, kind="stable")[(died < 0).sum() :]
    deaths = {"tick": died[gone], "species": pa.array(["finch"] * len(gone)).dictionary_encode(),
              "uid": uid[gone].astype(np.uint64),
              "cause": pa.array(["starved"] * len(gone)).dictionary_encode()}
    for kind, columns in (("births", births), ("deaths", deaths)):
        (folder / kind).mkdir(parents=True)
        for part in range(2):  # in two parts
            half = len(columns["uid"]) // 2
            rows_of_part = slice(0, half) if part == 0 else slice(half, None)
            pq.write_table(pa.table({k: v[rows_of_part] for k, v in columns.items()}),
                           folder / kind / f"part-{part:05d}.parquet")
    (folder / "manifest.json").write_text(json.dumps({"done": 11, "dt": 1.0, "species": ["finch"],
                                                      "genomes": genomes}))
    return folder


def parsed(newick):
    """The parent's name ("" for the root without a name) and branch length of each node,
    read letter by letter."""
    found, open_, at = {}, [], len(newick) - 2
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
                found[name] = (open_[-1] if open_ else None, float(label[2] or 0))
            at -= len(label[0])
            if at >= 0 and newick[at] == ")":
                open_.append(name)
                at -= 1
    return found


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
        rows.append((3 * i + 1, *(3 * int(p) + 1 if p >= 0 else 0 for p in (mother, father)), int(born[i]),
                     int(min(died[i], 30)), "".join(rng.choice(list("ACGT"), 2))))
    return rows


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


def test_the_mean_generation_is_that_of_the_living():
    generations = family().mean_generation("finch", 3)  # ticks 0, 3, 6, 9
    assert generations.tolist() == [0, (0 + 0 + 1 + 1) / 4, (0 + 1 + 2) / 3, (2 + 3 + 0 + 2.5 + 0) / 5]


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
    with pytest.raises(ValueError, match="of no organism"):
        lineage.most_recent_common_ancestor([])


def test_frequencies_are_counted_among_the_living():
    found = family().frequencies("finch", "beak", 3)
    assert found.ticks.tolist() == [0, 3, 6, 9]
    assert found.values == ("A", "C", "T")
    assert found.count.tolist() == [[1, 1, 0], [2, 2, 0], [1, 2, 0], [2, 1, 2]]
    assert found.n.tolist() == [2, 4, 3, 5]
    assert found.share[2].tolist() == [1 / 3, 2 / 3, 0]
    assert found.of("T").tolist() == [0, 0, 0, 2]


def test_codons_that_mean_the_same_are_one_value_in_the_order_of_codons():
    red = family().frequencies("finch", "red", 9)
    assert red.values == ("0", "-1")
    assert red.count.tolist() == [[2, 0], [3, 2]]
    song = family().frequencies("finch", "song", 9)  # A and G mean 3, C means 1, T means 2
    assert song.values == ("3", "1", "2")
    assert song.count.tolist() == [[2, 0, 0], [3, 1, 1]]


def test_a_gene_may_be_given_by_its_place():
    found = family().frequencies("finch", (0, 2), 9)
    assert found.values == ("AA", "AC", "CA", "CG", "TA", "TT")
    assert found.count[1].tolist() == [1, 1, 0, 1, 1, 1]


def test_one_of_two_strings_is_enough_to_carry_a_value():
    # strings of two loci
    rows = [(1, 0, 0, 0, ALIVE, "ATTT"), (2, 0, 0, 0, ALIVE, "CTAT"), (3, 0, 0, 0, ALIVE, "CGCG")]
    found = family(rows, genomes={"finch": GENES["finch"] | {"ploidy": 2}},
                   end=0).frequencies("finch", "beak", 1)
    assert dict(zip(found.values, found.count[0].tolist(), strict=True)) == {"A": 2, "C": 2, "T": 1}
    assert found.n.tolist() == [3]


def test_codons_are_numbered_with_the_first_letter_first():
    assert [codon_number(c, "ACGT") for c in ("A", "T", "CA", "TT", "CAG")] == [0, 3, 4, 15, 18]
    with pytest.raises(ValueError, match="codon 'AX' has the letter 'X'; the alphabet is 'ACGT'"):
        codon_number("AX", "ACGT")


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
        ((10, 10, 0, 9, ALIVE, "A"),
         "the organism 10 has the parent 10; allowed are 0 and the uids of those born before it: no loops"),
        ((10, 1, 12, 9, ALIVE, "A"), "the organism 10 has the parent 12; allowed .* no loops"),
        ((19, 0, 11, 9, ALIVE, "A"), "the organism 19 has the parent 11, of whom no birth is recorded"),
        ((9, 0, 0, 9, ALIVE, "A"), "the uid 9 is there twice or out of order"),
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
    with pytest.raises(ValueError, match="lineage: 77 died, of whom no birth is recorded"):
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
        pa.table({"tick": [4, 10], "species": ["finch", "finch"], "uid": pa.array([1, 9], pa.uint64()),
                  "cause": ["old", "old"]}),
        folder / "deaths" / "part-00002.parquet",
    )
    lineage = Lineage.read(folder)
    assert lineage.uid.tolist() == list(range(1, 10))
    assert lineage.founders.tolist() == [True, True, False, False, False, False, True, False, True]
    assert lineage.died[[0, 1, 8]].tolist() == [4, ALIVE, 10]
    assert lineage.born[lineage.founders].tolist() == [0] * 4
    assert set(lineage.species) == {"finch"}
    assert set(lineage.genome) == {""}


def test_the_csv_keeps_the_standard(tmp_path):
    path = family().to_csv(tmp_path / "finch.csv")
    rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))
    assert list(rows[0]) == ["id", "ancestor_list", "origin_time", "destruction_time",
                             "taxon_label", "genome"]
    assert [r["id"] for r in rows] == [str(row[0]) for row in FAMILY]
    assert [r["ancestor_list"] for r in rows][:5] == ["[none]", "[none]", "[1]", "[1,2]", "[3,4]"]
    assert [r["destruction_time"] for r in rows] == ["4", "7", "6", "9", "inf", "inf", "inf", "inf", "10"]
    assert [(r["origin_time"], r["taxon_label"], r["genome"]) for r in rows][3] == ("3", "finch", "CA")


def test_a_tree_of_several_founders_hangs_on_one_root(tmp_path):
    text = family().to_newick(tmp_path / "finch.nwk")
    assert text == "(((((8:1)6:3)5:3)3:2,4:3)1:0,2:0,7:8,9:9);"
    assert (tmp_path / "finch.nwk").read_text() == text + "\n"
    assert family().to_newick(living=True) == "(((((8:1)6:3)5:3)3:2,4:3)1:0,2:0,7:8);"


def test_the_tree_of_one_founder_has_it_as_its_root():
    assert family(FAMILY[:1]).to_newick() == "1;"
    assert family([FAMILY[0], FAMILY[2]]).to_newick() == "(3:2)1;"
    assert family([FAMILY[0]]).living().to_newick() == ";"


def test_names_are_quoted_where_newick_would_misread_them():
    assert [quoted(n) for n in ("12", "Elk-2.1", "", "a b", "a_b", "it's", "x:(y)")] == [
        "12", "Elk-2.1", "''", "'a b'", "'a_b'", "'it''s'", "'x:(y)'"
    ]  # fmt: skip
    text = family(FAMILY[:3]).to_newick(names=["Eve's", "old, oak", "c"])
    assert text == "((c:2)'Eve''s':0,'old, oak':0);"
    assert parsed(text) == {"Eve's": ("", 0.0), "old, oak": ("", 0.0), "c": ("Eve's", 2.0)}
    with pytest.raises(ValueError, match="2 names for 3 organisms"):
        family(FAMILY[:3]).to_newick(names=["a", "b"])


@pytest.mark.parametrize("seed", range(4))
def test_a_forest_is_read_back_from_its_tree(seed):
    rows = forest(seed)
    found, born = parsed(family(rows).to_newick()), {r[0]: r[3] for r in rows}
    first = min(born.values())
    assert {int(k): (int(p or 0), length) for k, (p, length) in found.items()} == {
        uid: (mother, float(when - (born[mother] if mother else first))) for uid, mother, _, when, *_ in rows
    }


def test_a_chain_of_100_000_births_is_no_matter_of_recursion():
    n = 100_000
    uid = np.arange(1, n + 1, dtype=np.uint64)
    none, text = np.zeros(n, np.uint64), np.full(n, "", object)
    chain = Lineage(uid, uid - np.uint64(1), none, np.full(n, "finch"), np.arange(n), np.full(n, ALIVE),
                    np.full(n, ""), text, n)
    tree = chain.to_newick()
    assert tree.startswith("(" * (n - 1) + f"{n}:1)")
    assert tree.endswith(")2:1)1;")
    assert chain.generation()[-1] == n - 1
    assert len(chain.ancestors(n)) == n - 1
    assert chain.most_recent_common_ancestor([n, n // 2]) == n // 2


# a real run


@pytest.fixture(scope="module")
def run(menagerie, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "out"
    run_to_folder(menagerie(), seed=7, ticks=60, out=folder, policies="untrained", report=False)
    return folder


def test_the_living_of_a_real_run_are_those_of_its_series_at_every_tick(run):
    lineage, series = Lineage.read(run), load_series(run)
    for species in series.species:
        assert (lineage.living_sums(series.ticks, mask=lineage.species == species).tolist()
                == series.of(species).tolist())
    assert (lineage.generation() > 1).any()


def test_a_world_in_memory_has_the_lineage_that_a_folder_has(run, menagerie):
    world = World.from_config(menagerie(), seed=7, policies="untrained", record=False)
    Recorder(world, keep_events=True)
    kept, read = Lineage.of(world.run(60)), Lineage.read(run)
    for name in ("uid", "parent", "parent2", "species", "born", "died", "cause", "genome"):
        assert (getattr(kept, name) == getattr(read, name)).all(), name
    assert (kept.end, kept.dt) == (read.end, read.dt) == (59, 0.5)
    assert set(read.cause) >= {"", "eaten by ram"}


def test_genomes_of_a_real_run_are_those_of_its_organisms(menagerie, tmp_path):
    genes = [{"name": "red", "letters": 1, "values": [0, 0, 0, 1]},
             {"name": "age", "trait": "life.age_max", "letters": 4, "low": 50, "high": 90}]
    config = menagerie(species={"ram": {
        "genome": {"ploidy": 2, "mutate": {"operator": "mutUniformInt", "indpb": 0.2}, "genes": genes}
    }})
    run_to_folder(config, seed=7, ticks=60, out=tmp_path / "run", policies="untrained", report=False)
    world = World.from_config(config, seed=7, policies="untrained").run(60)
    table, lineage = world.tables["ram"], Lineage.read(tmp_path / "run").of_species("ram")
    layout, loci, alive = table.species.heredity.layout, table[Genome].loci[table.by_uid()], lineage.alive(59)
    assert lineage.uid[alive].tolist() == table.uid[table.by_uid()].tolist()
    assert lineage.genome[alive].tolist() == [layout.alphabet.decode(row) for row in loci]
    red = lineage.frequencies("ram", "red", 1)
    assert [red.of(v)[-1] for v in ("0", "1")] == [(layout.alleles(loci, "red") == v).any(1).sum()
                                                   for v in (0, 1)]
    assert 0 < red.of("1")[-1] < table.n == red.n[-1]
    born = np.flatnonzero(lineage.mother >= 0)
    assert any(lineage.genome[i] != lineage.genome[lineage.mother[i]] for i in born)  # they mutate
    assert (lineage.genome[lineage.species == "ram"] != "").all()


def test_a_world_that_keeps_no_events_has_no_lineage(menagerie):
    with pytest.raises(RuntimeError, match="keep_events=True"):
        Lineage.of(World.from_config(menagerie()))
    with pytest.raises(RuntimeError, match="no recorder"):
        Lineage.of(World.from_config(menagerie(), record=False))


def test_csv_and_tree_of_a_real_run_agree_with_its_births_and_deaths(run, tmp_path):
    result = CliRunner().invoke(
        app, ["lineage", str(run), "--csv", str(tmp_path / "ram.csv"), "--newick", str(tmp_path / "ram.nwk"),
              "--species", "ram"]
    )
    assert result.exit_code == 0, result.output
    births, deaths = (pa.concat_tables([pq.read_table(p) for p in sorted((run / kind).glob("*.parquet"))])
                      for kind in ("births", "deaths"))
    births = {b["uid"]: b for b in births.to_pylist() if b["species"] == "ram"}
    died = {d["uid"]: d["tick"] for d in deaths.to_pylist() if d["species"] == "ram"}
    rows = list(csv.DictReader((tmp_path / "ram.csv").read_text(encoding="utf-8").splitlines()))
    assert [int(r["id"]) for r in rows] == sorted(births)
    assert {int(r["id"]): r["ancestor_list"] for r in rows} == {u: f"[{b['parent'] or 'none'}]"
                                                                for u, b in births.items()}
    assert {int(r["id"]): int(r["destruction_time"]) for r in rows if r["destruction_time"] != "inf"} == died
    assert {int(r["id"]): int(r["origin_time"]) for r in rows} == {u: b["tick"] for u, b in births.items()}
    tree = parsed((tmp_path / "ram.nwk").read_text().strip())
    assert {int(k): int(p or 0) for k, (p, _) in tree.items()} == {u: b["parent"] for u, b in births.items()}
    assert len(died) > 5
    assert any(b["parent"] for b in births.values())
    alive = len(births) - len(died)
    assert (f"ram\n  without parents: 40\n  born of parents: {len(births) - 40}\n  alive at tick 59: "
            f"{alive}\n" in result.output)
    assert "moss" not in result.output


def test_the_command_says_every_species_and_prunes_to_the_living(run, tmp_path):
    result = CliRunner().invoke(app, ["lineage", str(run), "--newick", str(tmp_path / "all.nwk"), "--living"])
    assert result.exit_code == 0, result.output
    assert [line for line in result.output.splitlines()
            if not line.startswith(" ")][:3] == ["moss", "ram", "lynx"]
    lineage = Lineage.read(run)
    assert len(parsed((tmp_path / "all.nwk").read_text().strip())) == len(lineage.living()) < len(lineage)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "DIR: \"nowhere\"\n  no such folder; allowed: a folder written by `ecs-eco run`"),
        (["."], "has no manifest.json"),
        (["RUN", "--species", "rem"],
         'no such species in this run; allowed: moss, ram, lynx; did you mean "ram"?'),
        (["RUN", "--csv", "missing/x.csv"], "--csv: \"missing/x.csv\"\n  its folder does not exist"),
        (["RUN", "--newick", "."], "is a folder; allowed: a file in a folder that exists"),
    ],
)
def test_the_command_refuses_what_cannot_be(run, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["lineage", *(str(run) if a == "RUN" else a for a in arguments)])
    assert result.exit_code == 2
    assert message in result.output


def test_the_command_says_what_does_not_fit_in_a_folder(tmp_path):
    result = CliRunner().invoke(
        app, ["lineage", str(write_folder(tmp_path / "run", [*FAMILY, (12, 11, 0, 9, ALIVE, "AA")]))]
    )
    assert result.exit_code == 2
    assert "the organism 12 has the parent 11, of whom no birth is recorded" in result.output


# size and figure


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
    whole = pa.table({k: v for k, v in columns.items() if k != "died"}
                     | {"species": pa.array(["finch"] * n).dictionary_encode()})
    gone = pa.table({"tick": died, "species": ["finch"] * n, "uid": rows[0], "cause": [""] * n})
    for kind, table in (("births", whole), ("deaths", gone)):
        (folder / kind).mkdir(parents=True)
        pq.write_table(table, folder / kind / "part-00000.parquet")
    (folder / "manifest.json").write_text(json.dumps({"done": 10_300, "dt": 1.0, "genomes": GENES}))
    start = time.process_time()
    lineage = Lineage.read(folder)
    share = lineage.frequencies("finch", "red", 20)
    mean = lineage.mean_generation("finch", 20)
    seconds = time.process_time() - start
    assert share.count[100].sum() == share.n[100] == ((born <= 2000) & (died > 2000)).sum()
    assert mean[200] > 1
    assert seconds < 15


def test_carriers_are_drawn_in_the_colour_of_their_gene(tmp_path):
    lineage = family()
    figure = carriers([lineage.frequencies("finch", gene, 1) for gene in ("red", "song")], "finch")
    (ax,) = figure.axes
    lines = {line.get_label(): line for line in ax.get_lines()}
    assert list(lines) == ["red", "song = 1", "song = 2", "all"]
    assert lines["red"].get_color() == "#d7191c"
    assert lines["red"].get_ydata().tolist() == [0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 2]
    assert len({line.get_color() for line in lines.values()}) == 4
    assert save(figure, tmp_path / "carriers.png").stat().st_size > 5000


def test_the_report_draws_genes_of_few_values_alone(run, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(run, folder)
    assert "Genes" not in write_report(folder).read_text()
    births = pa.concat_tables([pq.read_table(p) for p in sorted((folder / "births").glob("*.parquet"))])
    letters = ["ACGT"[u % 4] + "A" for u in births["uid"].to_pylist()]
    births = births.set_column(births.column_names.index("genome"), "genome", pa.array(letters))
    first = folder / "births" / "part-00000.parquet"
    head = write_part(births, first, mark_of(first)[0])
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["heads"]["births"] = head
    genomes = {"ram": GENES["finch"],
               "moss": {"alphabet": "ACGT", "ploidy": 1, "genes": GENES["finch"]["genes"][:1]}}
    write_manifest(folder, manifest | {"genomes": genomes})
    page = write_report(folder).read_text()
    assert "<h2>Genes</h2>" in page
    assert "Number of ram that carry each gene" in page
    assert "Number of moss" not in page
    assert (Path(folder) / "figures" / "carriers-1.png").is_file()
