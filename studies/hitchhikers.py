"""Do forks tell a letter that was planted from a neutral letter that rises with it?

The animals are those of `planted_sweeps`, but crossovers are rare and leave neighboring letters together. In a
tenth of the founders' strings, T at one of eight loci raises fertility, and one or two loci away there is a G
without any effect. No other string has either letter. Both rise as one event; each letter in the event is then
taken out of half of its carriers, in forks at half of the rise.

The control is the letter that leads the event: the one whose rise is clearest, judged without forks. The
hypotheses are in registered/hitchhikers.toml.
"""

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.registration import registration
from studies.common.study import Study, verdict
from studies.planted_sweeps import LIFE, LOCI, world

REGISTERED = registration("hitchhikers")
FIRST = 0.1  # frequency of both letters among founders
FEW = 6  # forks of which the driver is named a second time, to see how the answer depends on their number


def places(seed: int) -> tuple[int, int]:
    """Return the loci of the letter with the benefit and of the other one, which is 1 or 2 loci away."""
    locus, step = seed % LOCI, (1, -2, -1, 2)[seed // 3 % 4]
    return locus, locus + step if 0 <= locus + step < LOCI else locus - step


def linked_world(n: int, s: float, locus: int, crossover: float) -> dict[str, Any]:
    """Return a world of n animals in which the letter T at a locus has the benefit s per generation.

    A string of a parent has a crossover with this probability, which falls between two given neighbors in a
    seventh of these.
    """
    config = world(n, s, locus)
    genome = config["species"]["vole"]["genome"]
    good = next(gene for gene in genome["genes"] if gene["name"] == "good")
    c = s / (1 + s * (1 - FIRST))
    good["values"] = [1 - 2 * c] * 3 + [1.0]
    neutral = {"letters": 1, "low": 0.0, "high": 1.0}
    genome["genes"] = [good if i == locus else {"name": f"neutral{i}"} | neutral for i in range(LOCI)]
    genome["mate"] = {"operator": "cxOnePoint", "chance": crossover}
    return config


def together(herd: Any, locus: int, other: int, seed: int) -> None:
    """Put T and G into the same tenth of the founders' strings, and other letters into the rest."""
    from ecs_eco.components import Genome
    from ecs_eco.explain.edits import rewrite

    table = herd.table("vole")
    rows, rng = table.by_uid(), np.random.default_rng(seed)
    old = table[Genome].loci[rows]
    new = old.copy()
    strings = new.reshape(-1, LOCI)
    alphabet = "ACGT"
    chosen = rng.permutation(len(strings)) < round(FIRST * len(strings))
    for at, letter in ((locus, "T"), (other, "G")):
        rest = [i for i, x in enumerate(alphabet) if x != letter]
        strings[:, at] = np.where(chosen, alphabet.index(letter), rng.choice(rest, len(strings)))
    rewrite(table, rows, old, new)


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run one world, take the letters of its event out, and return what the forks say."""
    with tempfile.TemporaryDirectory() as folder:
        return explained(config, case, Path(folder) / "run")


def explained(config: dict[str, Any], case: Mapping[str, Any], out: Path) -> dict[str, Any]:
    """Return the same, and leave the run in a folder."""
    from ecs_eco.analysis.lineage import Lineage
    from ecs_eco.explain import Allele, driver, rises
    from ecs_eco.explain.account import account
    from ecs_eco.record import run_to_folder

    s, seed = case["s"], case["seed"]
    locus, other = places(seed)
    run_to_folder(
        linked_world(case["n"], s, locus, case["crossover"]),
        seed=seed,
        ticks=round(LIFE / 2 * config["logit"] / s),
        out=out,
        report=False,
        prepare=lambda herd: together(herd, locus, other, seed),
    )
    planted = Allele("vole", "letter", "good", locus, "T")
    passenger = Allele("vole", "letter", f"neutral{other}", other, "G")
    role = {planted: "planted", passenger: "passenger"}
    sweeps = rises(Lineage.read(out))
    events = [[sweep.lead, *(allele for allele, _ in sweep.linked)] for sweep in sweeps]
    result: dict[str, Any] = {
        "distance": abs(other - locus),
        "events": [[role.get(allele, allele.name) for allele in event] for event in events],
    }
    both = [sweep for sweep, event in zip(sweeps, events, strict=True) if {planted, passenger} <= set(event)]
    if not both:
        return result | {"event": False}
    sweep = both[0]
    found = account(out, sweep, forks=config["forks"], workers=1)
    taken = [one for _, one in found.taken]
    few = [replace(one, n=one.n[:FEW], means={"births": one.means["births"][:FEW]}) for one in taken]
    named = {
        id(one): role.get(allele, allele.name) for (allele, _), one in zip(found.taken, few, strict=True)
    }
    some = driver(few)
    return result | {
        "event": True,
        "r2": min(r2 for allele, r2 in sweep.linked if allele in role),
        "lead": role.get(sweep.lead, sweep.lead.name),
        "tick": sweep.half,
        "driver": None if found.driver is None else role.get(found.driver, found.driver.name),
        "driver of few": None if some is None else named[id(some)],
        "gap": found.gap,
        "taken": {
            role.get(allele, allele.name): {
                "carriers": float(one.n.sum(axis=1).mean()),
                "births": one.control().value,
                "effect": list(one.effect()),
            }
            for allele, one in found.taken
        },
    }


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Test the registered hypotheses; return the verdicts and a table by benefit, animals and crossover."""
    decisive = [e["result"] for e in cases if e["case"]["s"] >= LEAST]
    named = count(decisive, "driver", "planted")
    lines = [
        REGISTERED.verdict("named", named, named >= 16),
        REGISTERED.verdict("wrong", wrong := misnamed(decisive, "driver"), wrong <= 1),
    ]
    for statement, value in (
        ("worlds in which both letters are in one event, of 20", count(decisive, "event", True)),
        ("worlds in which no letter of the event is clear in the forks", count(decisive, "driver", None)),
        ("control: worlds in which the planted letter leads the event", count(decisive, "lead", "planted")),
        ("control: worlds in which another letter leads the event", misnamed(decisive, "lead")),
        (
            f"worlds in which {FEW} of the 24 forks name the planted letter",
            count(decisive, "driver of few", "planted"),
        ),
        (f"worlds in which {FEW} of the 24 forks name another letter", misnamed(decisive, "driver of few")),
    ):
        lines.append(verdict(statement, value, "reported", True))
    rows: list[list[Any]] = []
    for key in sorted({(e["case"]["s"], e["case"]["n"], e["case"]["crossover"]) for e in cases}):
        of = [e["result"] for e in cases if (e["case"]["s"], e["case"]["n"], e["case"]["crossover"]) == key]
        rows.append(
            [
                *key,
                len(of),
                count(of, "event", True),
                count(of, "lead", "planted"),
                count(of, "driver of few", "planted"),
                count(of, "driver", "planted"),
                misnamed(of, "driver"),
            ]
        )
    head = ["s", "animals", "crossover", "worlds", "one event", "leads", f"named by {FEW} forks"]
    return {"verdicts": lines, "table": {"head": [*head, "named by 24", "named wrongly"], "rows": rows}}


def count(results: list[dict[str, Any]], key: str, value: Any) -> int:
    """Return the number of worlds with this value; worlds without a common event have none."""
    return sum(key in r and r[key] == value for r in results)


def misnamed(results: list[dict[str, Any]], key: str) -> int:
    """Return the number of worlds in which a letter is named, but not the planted one."""
    return sum(r.get(key) not in (None, "planted") for r in results)


LEAST = 0.1  # smallest benefit of the worlds on which the hypotheses are tested
FIRST_SEED = REGISTERED.content["seeds"]["world"]
CASES = [
    {"n": n, "s": s, "crossover": crossover}
    for s in (0.05, 0.1, 0.2)
    for crossover in (0.02, 0.002)
    for n in (300, 300, 300, 1000, 1000)
]
STUDY = Study(
    name="hitchhikers",
    claim=REGISTERED.content["claim"],
    config={"logit": 6.0, "forks": 24},
    registered=REGISTERED,
    cases=[case | {"seed": FIRST_SEED + i} for i, case in enumerate(CASES)],
    run=run,
    summarise=summarise,
    short_config={"forks": 6},
    short_cases=[{"n": 300, "s": 0.4, "crossover": 0.02, "seed": 1}],
)

if __name__ == "__main__":
    STUDY.main()
