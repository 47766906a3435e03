"""Phylogenies in standard formats: ALife data standards (CSV) and Newick."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ecs_eco.analysis.page import write_text
from ecs_eco.analysis.pedigree import Pedigree

PLAIN = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-")


def write_csv(lineage: Pedigree, path: Path) -> Path:
    """Write a row per organism in the order of uids, after the phylogeny standard of Lalejini et al. (2019).

    id; ancestor_list "[1,2]", "[none]" for founders; origin_time and destruction_time [ticks], "inf" while
    alive; taxon_label, the species; genome; recorded fields, empty where there is none. "Data Standards for
    Artificial Life Software", Proceedings of ALIFE 2019.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    head = ["id", "ancestor_list", "origin_time", "destruction_time", "taxon_label", "genome"]
    writer.writerow([*head, *lineage.recorded])
    parents = zip(lineage.parent.tolist(), lineage.parent2.tolist(), strict=True)
    ancestors = [f"[{','.join(str(p) for p in dict.fromkeys(pair) if p) or 'none'}]" for pair in parents]
    ends = ["inf" if died < 0 else died for died in lineage.died.tolist()]
    writer.writerows(
        zip(
            lineage.uid.tolist(),
            ancestors,
            lineage.born.tolist(),
            ends,
            lineage.species.tolist(),
            lineage.genome.tolist(),
            *(["" if np.isnan(x) else x for x in values] for values in lineage.recorded.values()),
            strict=True,
        )
    )
    return write_text(path, out.getvalue())


def newick(lineage: Pedigree, names: Sequence[str] | None = None) -> str:
    """The tree along first parents: every organism is a node, named by its uid;
    children follow in the order of uids.

    A branch is as long as the time from the parent's birth to the child's [ticks]. Several founders hang on
    one root without a name, which is as old as the first of them; nobody at all is the tree ";".
    """
    n = len(lineage)
    if not n:
        return ";"
    label = [quoted(str(name)) for name in (lineage.uid.tolist() if names is None else names)]
    born, mother = lineage.born.tolist(), lineage.mother.tolist()
    roots = [i for i in range(n) if mother[i] < 0]
    first = min(born[i] for i in roots)
    order = np.argsort(lineage.mother, kind="stable")
    # the children of i are order[begin[i] : begin[i + 1]]
    begin = np.searchsorted(lineage.mother[order], np.arange(n + 1)).tolist()
    order = order.tolist()
    alone = len(roots) == 1
    words: list[str] = [] if alone else ["("]
    stack = roots[::-1]  # i opens a node, −1 − i closes it
    while stack:
        i = stack.pop()
        if i >= 0 and begin[i] < begin[i + 1]:
            if words and words[-1] != "(":
                words.append(",")
            words.append("(")
            stack.append(-1 - i)
            stack.extend(order[begin[i] : begin[i + 1]][::-1])
            continue
        if i >= 0 and words and words[-1] != "(":
            words.append(",")
        if i < 0:
            i = -1 - i
            words.append(")")
        since = born[mother[i]] if mother[i] >= 0 else first
        words.append(label[i] if alone and mother[i] < 0 else f"{label[i]}:{born[i] - since}")
    return "".join([*words, ";" if alone else ");"])


def quoted(name: str) -> str:
    """A name as Newick takes it: in single quotes where it holds more than letters, digits, dots and hyphens."""
    return name if name and PLAIN.issuperset(name) else "'" + name.replace("'", "''") + "'"
