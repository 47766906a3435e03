"""Does a duplicated reflex gene diverge where a second reflex is useful?

Goats walk straight ahead and eat what they touch: green grass feeds them, red grass kills them, and in the
arm `use`, yellow grass also kills. Their genomes vary in length. Founders have one copy of a gene whose
reflex keeps them from eating near red grass; they have no gene for yellow grass, whose promoter differs from
red's in one letter. A goat thus gains a reflex against yellow through a point mutation of a red gene, at the
cost of that copy; a goat with two copies keeps one for red. Genes are duplicated and lost at equal rates
through mutation and, where already duplicated, also through unequal crossover.

Goats also carry two markers that have no effect, blue and white, with the same lengths and rates and with
promoters that differ in the same letter; founders have one copy of blue and none of white. The markers are
the neutral control within each run. Births and deaths are the only selection.

Arms, with the same seeds:
  use            yellow grass kills
  no use         yellow grass exists, but no goat eats it
  neutral drift  like `use`, but genes are not expressed; they are inherited and mutate but have no effect

These hypotheses were written before the final runs (a pilot with seed 91 set the rates). "Doubled" is the
share of goats with two or more copies of red and yellow together, and "diverged" is the share with a red and
a yellow gene that both prevent eating; both are measured for blue and white as well. Values are means over
the last quarter of a run; differences are paired by seed with a 95% t interval:
  1. Diverged duplicates are more frequent in `use` than in `no use`.
  2. They are also more frequent in `use` than in `neutral drift`.
  3. Doubled genes are more frequent in `use` than in `no use`.
  4. In `use`, red and yellow are doubled, and diverged, more often than blue and white in the same goats.
  5. In `neutral drift`, red and yellow are doubled as often as blue and white: the interval contains 0.
  6. In most runs of `use`, more than half of the goats have diverged duplicates at the end.
Reported without a goal: in `no use`, doubled red and yellow minus doubled blue and white (a second copy of
red protects against the loss of the first); and the origin of yellow genes: among goats born with a yellow
gene to parents without one, the share with a parent that has two or more copies of red.
"""

from typing import Any

import numpy as np

from studies.common.study import Study, verdict

SEEDS = tuple(range(1, 11))
ARMS = ("use", "no use", "neutral drift")
SHARES = ("doubled", "diverged", "doubled markers", "diverged markers")
KEEPS_OFF = [0, -1, -1, -1]


def gene(name: str, promoter: str, copies: int, trait: bool) -> dict[str, Any]:
    """Return a one-letter gene behind a three-letter promoter."""
    return {
        "name": name,
        "promoter": promoter,
        "copies": copies,
        "letters": 1,
        "values": KEEPS_OFF,
        **({"trait": f"reflex.{name}.weight"} if trait else {}),
    }


def grass(count: int, seed_rain: float, spacing: float) -> dict[str, Any]:
    """Return a grass species on separate sites that regrows quickly."""
    return {
        "count": count,
        "body": {"radius": 0.2, "mass": 0.2, "opaque": False},
        "metabolism": {"energy": 0.06, "energy_max": 0.06},
        "reproduction": {"kind": "spread", "rate": 0.0, "seed_rain": seed_rain, "spacing": spacing},
    }


GENOME = {
    "longest": 48,
    "duplication": 0.02,
    "loss": 0.02,
    "mate": {"operator": "cxUnequal", "slip": 0.1},
    "mutate": {"operator": "mutUniformInt", "indpb": 0.01},
    "genes": [
        gene("red", "TAC", 1, True),
        gene("yellow", "TAG", 0, True),
        gene("blue", "GAC", 1, False),
        gene("white", "GAG", 0, False),
    ],
}
GOAT = {
    "count": 400,
    "max_count": 500,
    "body": {"radius": 0.3, "mass": 50.0},
    "metabolism": {"energy": 0.6, "energy_max": 1.0, "basal": 0.005},
    "locomotion": {"speed": {"walk": 0.8}},
    "diet": [
        {"eats": "red", "gain": 0.0, "deadly": True},
        {"eats": "yellow", "gain": 0.0, "deadly": True},
        {"eats": "green", "gain": 0.4},
    ],
    "sensors": [{"kind": "nearest", "target": name, "radius": 2.0} for name in ("red", "yellow")],
    "actions": {"speed": ["walk"], "eat": ["eat"]},
    "automatic": ["walk", "eat"],
    "reflex": {
        "connections": [
            {"name": name, "sensor": f"{name}_near", "above": 0.3, "action": "eat", "weight": 0}
            for name in ("red", "yellow")
        ]
    },
    "reproduction": {
        "kind": "sexual",
        "energy_min": 0.6,
        "energy_given": 0.3,
        "age_min": 20.0,
        "reach": 8.0,
        "consent": "none",
        "rest": 10.0,
    },
    "lethal": [
        {"property": "energy", "min": 0.0, "low": "starved"},
        {"property": "age", "max": 150.0, "high": "too old"},
    ],
    "genome": GENOME,
}
WORLD = {
    "format": 1,
    "name": "gene_duplication",
    "dt": 1.0,
    "space": {"size": [60.0, 60.0], "edges": "torus"},
    "species": {
        "red": grass(16, 0.3, 15.0),
        "yellow": grass(16, 0.3, 15.0),
        "green": grass(400, 0.03, 2.5),
        "goat": GOAT,
    },
}


class FirstYellow:
    """Goats born with a yellow gene to parents without one: their number, and how many have a parent with two
    or more copies of red."""

    def __init__(self, world: Any) -> None:
        self.table, self.n, self.of_doubled = world.tables["goat"], 0, 0
        world.on_birth.append(self.born)

    def born(self, table: Any, rows: np.ndarray, first: np.ndarray, second: np.ndarray) -> None:
        """Record newborns: rows i64[k], uids of their parents u64[k]."""
        if table is not self.table:
            return
        from ecs_eco.components import Genome
        from ecs_eco.life.births import rows_of

        layout = table.species.heredity.layout
        copies = layout.copy_numbers(table[Genome].loci[rows])
        for i in np.flatnonzero(copies["yellow"]):
            parents = rows_of(table, np.array([first[i], second[i]], np.uint64))
            had = layout.copy_numbers(table[Genome].loci[parents[parents >= 0]])
            if parents.min() >= 0 and not had["yellow"].any():
                self.n += 1
                self.of_doubled += bool((had["red"] > 1).any())


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one arm; return the shares every `every` ticks, numbers of goats, births, and causes of death."""
    import copy

    from ecs_eco import World

    world = copy.deepcopy(config["world"])
    if case["arm"] == "no use":
        world["species"]["goat"]["diet"].pop(1)
    living = World.from_config(
        world, seed=case["seed"], controls=("neutral-drift",) if case["arm"] == "neutral drift" else ()
    )
    origins, samples = FirstYellow(living), [shares(living)]
    while living.tick < config["ticks"]:
        living.run(config["every"])
        samples.append(shares(living))
    series = living.series().to_pydict()
    goats = [i for i, name in enumerate(series["species"]) if name == "goat"]
    deaths = {c: sum(series[c][i] for i in goats) for c in series if c.startswith("died: ")}
    return {
        "shares": {name: " ".join(f"{s[name]:.3f}" for s in samples) for name in samples[0]},
        "goats": float(np.mean([series["n"][i] for i in goats])),
        "births": sum(series["births"][i] for i in goats),
        "deaths": {c.removeprefix("died: "): n for c, n in deaths.items() if n},
        "first yellow": origins.n,
        "of doubled red": origins.of_doubled,
        "at limit": origins.table.species.heredity.operators.at_limit.tolist(),
    }


def shares(world: Any) -> dict[str, float]:
    """Return the shares of living goats with doubled and with diverged genes, and the number of letters per
    string; NaN if no goats are alive."""
    from ecs_eco.components import Genome

    goat = world.tables["goat"]
    layout, loci = goat.species.heredity.layout, goat[Genome].loci[goat.rows()]
    if not len(loci):
        return dict.fromkeys((*SHARES, "letters"), np.nan)
    n, say = layout.copy_numbers(loci), layout.decode(loci)
    out = {}
    for what, (one, other) in {"": ("red", "yellow"), " markers": ("blue", "white")}.items():
        out[f"doubled{what}"] = float((n[one] + n[other] > 1).mean())
        out[f"diverged{what}"] = float(((say[one] < 0) & (say[other] < 0)).mean())
    return out | {"letters": float(layout.lengths(loci).mean())}


def late(entry: dict[str, Any], name: str) -> float:
    """Return the mean of the last quarter of a run's samples."""
    line = [float(v) for v in entry["result"]["shares"][name].split()]
    return float(np.mean(line[-max(1, len(line) // 4) :]))


def by_seed(cases: list[dict[str, Any]], arm: str, name: str) -> dict[int, float]:
    """Return, for each seed, a share's mean late in an arm's run, excluding runs in which goats went
    extinct."""
    values = {e["case"]["seed"]: late(e, name) for e in cases if e["case"]["arm"] == arm}
    return {seed: value for seed, value in values.items() if np.isfinite(value)}


def apart(one: dict[int, float], other: dict[int, float]) -> list[float]:
    """Return the mean difference, paired by seed, and its 95% interval; the bounds are NaN for fewer than two
    pairs."""
    from studies.common.selection import pooled

    estimate = pooled([one[s] - other[s] for s in sorted(set(one) & set(other))])
    return [estimate.mean, *estimate.interval95]


def above(statement: str, difference: list[float]) -> dict[str, Any]:
    """Return the verdict on a difference expected to be above 0."""
    return verdict(statement, difference, "above 0", difference[1] > 0)


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the six hypotheses, and the results without a goal."""
    arms = [arm for arm in ARMS if any(e["case"]["arm"] == arm for e in cases)]
    of = {(arm, name): by_seed(cases, arm, name) for arm in arms for name in SHARES}
    out = [
        above(
            f"share of goats with {name} genes, use minus {control}",
            apart(of["use", name], of[control, name]),
        )
        for name, control in (("diverged", "no use"), ("diverged", "neutral drift"), ("doubled", "no use"))
        if control in arms
    ]
    out += [
        above(
            f"use: {name} red and yellow minus {name} blue and white",
            apart(of["use", name], of["use", f"{name} markers"]),
        )
        for name in ("doubled", "diverged")
    ]
    if "neutral drift" in arms:
        drift = apart(of["neutral drift", "doubled"], of["neutral drift", "doubled markers"])
        out.append(
            verdict(
                "neutral drift: doubled red and yellow minus doubled blue and white",
                drift,
                "0 within the interval",
                drift[1] <= 0 <= drift[2],
            )
        )
    ends = [float(e["result"]["shares"]["diverged"].split()[-1]) for e in cases if e["case"]["arm"] == "use"]
    out.append(
        verdict(
            "use: runs that end with diverged duplicates in more than half of the goats",
            f"{sum(end > 0.5 for end in ends)} of {len(ends)}",
            "most",
            2 * sum(end > 0.5 for end in ends) > len(ends),
        )
    )
    if "no use" in arms:
        spare = apart(of["no use", "doubled"], of["no use", "doubled markers"])
        out.append(
            verdict("no use: doubled red and yellow minus doubled blue and white", spare, "reported", True)
        )
    mine = [e["result"] for e in cases if e["case"]["arm"] == "use"]
    out += [
        verdict(
            "use: goats born with a yellow gene that their parents lack, and how many of these have a "
            "parent with two or more copies of red",
            [sum(r[k] for r in mine) for k in ("first yellow", "of doubled red")],
            "reported",
            True,
        ),
        verdict(
            "mean number of goats in the smallest run",
            min(e["result"]["goats"] for e in cases),
            "300 or more",
            min(e["result"]["goats"] for e in cases) >= 300,
        ),
    ]
    rows = [
        [arm, name, len(of[arm, name]), float(np.mean(list(of[arm, name].values())))]
        for arm in arms
        for name in SHARES
        if of[arm, name]
    ]
    return {
        "verdicts": out,
        "table": {"head": ["arm", "share of goats in the last quarter", "runs", "mean"], "rows": rows},
    }


STUDY = Study(
    name="gene_duplication",
    claim="A duplicated reflex gene diverges where a second reflex is useful, and does not where it is "
    "useless.",
    config={"world": WORLD, "ticks": 5000, "every": 250},
    cases=[{"arm": arm, "seed": seed} for seed in SEEDS for arm in ARMS],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": arm, "seed": seed} for seed in (101, 102) for arm in ARMS],
    short_config={"ticks": 100, "every": 50},
)

if __name__ == "__main__":
    STUDY.main()
