"""Lineages as files: the standard table, and Newick trees that are read back."""

import csv

import numpy as np
import pytest

from ecs_eco.analysis.lineage import ALIVE, Lineage, quoted
from tests.analysis.families import FAMILY, family, forest, parsed


def test_the_csv_keeps_the_standard(tmp_path):
    path = family().to_csv(tmp_path / "finch.csv")
    rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))
    assert list(rows[0]) == [
        "id",
        "ancestor_list",
        "origin_time",
        "destruction_time",
        "taxon_label",
        "genome",
    ]
    assert [r["id"] for r in rows] == [str(row[0]) for row in FAMILY]
    assert [r["ancestor_list"] for r in rows][:5] == ["[none]", "[none]", "[1]", "[1,2]", "[3,4]"]
    assert [r["destruction_time"] for r in rows] == ["4", "7", "6", "9", "inf", "inf", "inf", "inf", "10"]
    assert [(r["origin_time"], r["taxon_label"], r["genome"]) for r in rows][3] == ("3", "finch", "CA")


def test_a_tree_of_several_founders_hangs_on_one_root(tmp_path):
    text = family().to_newick(tmp_path / "finch.nwk")
    assert text == "(((((8:1)6:3)5:3)3:2,4:3)1:0,2:0,7:8,9:9);"
    assert (tmp_path / "finch.nwk").read_text() == text + "\n"
    assert family().to_newick(living=True) == "(((((8:1)6:3)5:3)3:2)1:0,7:8);"  # 2 and 4 are dead fathers


def test_the_tree_of_one_founder_has_it_as_its_root():
    assert family(FAMILY[:1]).to_newick() == "1;"
    assert family([FAMILY[0], FAMILY[2]]).to_newick() == "(3:2)1;"
    assert family([FAMILY[0]]).living().to_newick() == ";"


def test_names_are_quoted_where_newick_would_misread_them():
    assert [quoted(n) for n in ("12", "Elk-2.1", "", "a b", "a_b", "it's", "x:(y)")] == [
        "12",
        "Elk-2.1",
        "''",
        "'a b'",
        "'a_b'",
        "'it''s'",
        "'x:(y)'",
    ]
    text = family(FAMILY[:3]).to_newick(names=["Eve's", "old, oak", "c"])
    assert text == "((c:2)'Eve''s':0,'old, oak':0);"
    assert parsed(text) == {"Eve's": ("", 0.0), "old, oak": ("", 0.0), "c": ("Eve's", 2.0)}
    with pytest.raises(ValueError, match="2 names for 3 organisms"):
        family(FAMILY[:3]).to_newick(names=["a", "b"])


@pytest.mark.parametrize("seed", range(4))
def test_a_forest_is_read_back_from_its_tree(seed):
    rows = forest(seed)
    parents, born = parsed(family(rows).to_newick()), {r[0]: r[3] for r in rows}
    first = min(born.values())
    assert {int(k): (int(p or 0), length) for k, (p, length) in parents.items()} == {
        uid: (mother, float(when - (born[mother] if mother else first))) for uid, mother, _, when, *_ in rows
    }


def test_a_chain_of_100_000_births_is_no_matter_of_recursion():
    n = 100_000
    uid = np.arange(1, n + 1, dtype=np.uint64)
    none, text = np.zeros(n, np.uint64), np.full(n, "", object)
    chain = Lineage(
        uid,
        uid - np.uint64(1),
        none,
        np.full(n, "finch"),
        np.arange(n),
        np.full(n, ALIVE),
        np.full(n, ""),
        text,
        n,
    )
    tree = chain.to_newick()
    assert tree.startswith("(" * (n - 1) + f"{n}:1)")
    assert tree.endswith(")2:1)1;")
    assert chain.generation()[-1] == n - 1
    assert len(chain.ancestors(n)) == n - 1
    assert chain.most_recent_common_ancestor([n, n // 2]) == n // 2
