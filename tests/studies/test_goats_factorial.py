"""The factorial of what goats learn and inherit: all arms are told, and what was registered is decided."""

from studies.common.goats import GENES
from studies.goats_factorial import REGISTERED, summarise


def result(genes, learn, seed):
    s = {"red": 0.8 - 0.1 * learn, "yellow": 0.2, "green": -2.0, "blue": 0.0}
    return {
        "s": {g: s[g] + 0.01 * (seed % 3) if genes or g == "blue" else None for g in GENES},
        "n": 300.0,
        "generations": 20.0,
        "extinct": seed == 1 and not genes,
        "eat yellow": None if seed == 1 and not genes else 0.5 - 0.1 * learn + 0.01 * (seed % 2),
    }


def test_all_hypotheses_are_decided_though_nobody_carries_a_gene_that_says_nothing():
    cases = [
        {"case": {"arm": name, "seed": seed}, "result": result(of["genes"], of["learn"], seed)}
        for name, of in REGISTERED.arms.items()
        for seed in range(4)
    ]
    told = summarise(cases)
    met = {line["registered"]: line["met"] for line in told["verdicts"] if "registered" in line}
    assert met == {
        "red": True,
        "yellow-inherited": False,
        "yellow-none": False,
        "yellow-frozen": True,
        "green": True,
        "baldwin-red": True,
        "assimilated": True,
    }
    rows = {row[0]: row for row in told["table"]["rows"]}
    assert len(rows) == 12
    assert rows["none, frozen, no genes"][2] == 1
