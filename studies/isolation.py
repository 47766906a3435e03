"""Does isolation preserve genetic and policy diversity that one panmictic world of the same size loses?

Goats on rich pasture mate; each has its own policy, which continues to learn and is inherited in its learned
state, with noise. Each goat has two strings of 16 neutral markers with 16 alleles, without mutation: all
alleles come from the founders. Population sizes are limited by `max_count`: 24 on an island and 192 in the
single world, which has the area of eight islands; newborns appear anywhere in their world.

Arms, with the same seeds:
  isolated    8 islands without migration
  few         8 islands with migration between all; at each barrier, every 100 s, each goat leaves with
              probability 0.03
  many        as `few`, with probability 0.3
  panmictic   one world with the area and numbers of the eight islands

H_S is the expected heterozygosity within islands and H_T is the expected heterozygosity of all goats
together, both corrected for the number of goats (Nei & Chesser 1983); F_ST = (H_T − H_S)/H_T. In the
panmictic arm, eight groups drawn by uid replace the islands. For policies, all goats see the same 64 random
observations; the divergence of two goats is the mean over observations of KL(p‖q) of their actions, in both
directions. The share between islands is 1 − (divergence within islands) / (divergence of goats from different
islands).

These hypotheses were written before the final runs; sizes were chosen without a pilot. Values are from the
end of a run; differences are paired by seed with a 95% t interval:
  1. H_T is higher in `isolated` than in `panmictic`.
  2. H_S is lower in `isolated` than in `panmictic`.
  3. F_ST is greater in `isolated` than in `few`, and greater in `few` than in `many`.
  4. F_ST of `few` and of `many` is within a factor of 2 of Wright's 1/(1 + 4 N m) (1931, Genetics 16: 97),
     with the factor (d/(d − 1))² on m for d islands (Takahata 1983, Genetics 104: 497-512). m is the number
     of emigrants per goat per generation. N is the effective population size, from the decline of H_S in
     `isolated`: ln H_S falls by 1/(2 N) per generation. A generation is the mean age of parents.
  5. The share of policy divergence between islands is greater in `isolated` than in `panmictic`.
  6. Policy divergence of all pairs of goats is greater in `isolated` than in `panmictic`.
Reported without a goal: the alleles per marker remaining among all goats, and values of the intermediate
arms.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.study import Study, verdict

SEEDS = tuple(range(1, 7))
ARMS = ("isolated", "few", "many", "panmictic")
LEAVE = {"isolated": 0.0, "few": 0.03, "many": 0.3}
ISLANDS, MARKERS = 8, 16
SIDE, NUMBER, GRASS = 24.0, 24, 100  # of one island
WHAT = ("H_S", "H_T", "F_ST", "alleles", "policies", "policies between")


def world(islands: int) -> dict[str, Any]:
    """Return one island's world, or a single world with the area and numbers of several."""
    markers = [{"name": f"m{i}", "letters": 1, "low": 0.0, "high": 15.0} for i in range(MARKERS)]
    goat = {
        "count": NUMBER * islands,
        "max_count": NUMBER * islands,
        "body": {"radius": 0.3, "mass": 50.0},
        "age": [0.0, 150.0],
        "metabolism": {"energy": 0.6, "energy_max": 1.0, "basal": 0.003},
        "locomotion": {"speed": {"walk": 0.8, "stay": 0.0}, "turn": 0.6},
        "diet": [{"eats": "green", "gain": 0.3}],
        "sensors": [
            {"kind": "own", "property": "energy"},
            {"kind": "nearest", "target": "green", "radius": 4.0},
        ],
        "actions": {"speed": ["walk", "stay"], "turn": ["left", "none", "right"], "eat": ["eat"]},
        "neutral": {"speed": "walk", "turn": "none"},
        "automatic": ["eat"],
        "happiness": {"weights": {"energy": 1.0}, "minimum": -1.0},
        "policy": {
            "kind": "individual",
            "hidden": [8],
            "learn": True,
            "inherit": "learned",
            "mutation": 0.02,
        },
        "ppo": {"horizon": 32, "epochs": 4, "learning_rate": 0.01, "discount": 0.5, "gae_lambda": 0.5},
        "reproduction": {
            "kind": "sexual",
            "energy_min": 0.5,
            "energy_given": 0.25,
            "age_min": 20.0,
            "reach": 12.0,
            "consent": "none",
            "choice": "random",
            "rest": 5.0,
            "place": "anywhere",
        },
        "lethal": [
            {"property": "energy", "min": 0.0, "low": "starved"},
            {"property": "age", "max": 150.0, "high": "too old"},
        ],
        "genome": {
            "alphabet": "ABCDEFGHIJKLMNOP",
            "ploidy": 2,
            "founders": "random",
            "mate": {"operator": "cxUniform", "indpb": 0.5},
            "mutate": {"operator": "mutUniformInt", "indpb": 0.0},
            "genes": markers,
        },
    }
    green = {
        "count": GRASS * islands,
        "body": {"radius": 0.2, "opaque": False},
        "metabolism": {"energy": 0.06, "energy_max": 0.06},
        "reproduction": {"kind": "spread", "rate": 0.0, "seed_rain": 0.03, "spacing": 2.0},
    }
    side = SIDE * islands**0.5
    return {
        "format": 1,
        "name": "isolation",
        "dt": 1.0,
        "space": {"size": [side, side], "edges": "torus"},
        "species": {"green": green, "goat": goat},
    }


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one arm; return the measures every `sample` ticks, and the generation time [ticks]."""
    from ecs_eco import World
    from ecs_eco.analysis.lineage import Lineage
    from ecs_eco.lab import Archipelago

    arm, ticks = case["arm"], range(0, config["ticks"] + 1, config["sample"])
    if arm == "panmictic":
        living = World.from_config(world(ISLANDS), seed=case["seed"], policies="untrained")
        samples = [measured([living.run(tick - living.tick)]) for tick in ticks]
        return {**lines(samples), "generation": None, "goats": living.tables["goat"].n}
    plan = {"islands": ISLANDS, "every": config["every"], "graph": "full", "emigration": {"goat": LEAVE[arm]}}
    with tempfile.TemporaryDirectory(prefix="ecs-eco-isolation-") as place:
        made = Archipelago.from_config(
            world(1) | {"archipelago": plan},
            seed=case["seed"],
            policies="untrained",
            ticks=config["ticks"],
            out=Path(place) / "run",
        )
        samples = []
        for tick in ticks[1:]:
            made.run(until=tick, report=False)
            samples.append(measured([made.world(name) for name in made.islands]))
        goats = sum(state["n"]["goat"] for state in made.manifest["islands"].values())
        return {
            **lines(samples),
            "generation": Lineage.read(made.folder).generation_time("goat"),
            "goats": goats,
        }


def lines(samples: list[dict[str, float]]) -> dict[str, str]:
    """Return the measures, each as one line of numbers."""
    return {name: " ".join(f"{s[name]:.4f}" for s in samples) for name in WHAT}


def measured(worlds: list[Any]) -> dict[str, float]:
    """Return the diversity of genes and policies within and between islands, or groups in the single
    world."""
    genes, policies = [], []
    for living in worlds:
        goat = living.tables["goat"]
        rows = goat.by_uid()
        drawn = rows[np.argsort(goat.uid[rows] % 1009, kind="stable")]
        groups = [rows] if len(worlds) > 1 else np.array_split(drawn, ISLANDS)
        for group in groups:
            if group.size > 1:
                genes.append(alleles(goat, group))
                policies.append(decisions(living, goat, group))
    return heterozygosity(genes) | divergence(policies)


def alleles(goat: Any, rows: np.ndarray) -> np.ndarray:
    """Return both alleles of each marker: i64[2 goats, markers]."""
    from ecs_eco.components import Genome

    return goat[Genome].loci[rows].reshape(-1, MARKERS).astype(np.int64)


def heterozygosity(groups: list[np.ndarray]) -> dict[str, float]:
    """Return H_S, H_T and F_ST (Nei & Chesser 1983) at Hardy-Weinberg proportions, and alleles per marker."""
    counts = np.stack([[np.bincount(marker, minlength=16) for marker in group.T] for group in groups])
    n = counts.sum(2)[:, 0]  # a group's alleles at a marker
    shares = counts / n[:, None, None]
    within = np.mean((n / (n - 1))[:, None] * (1 - (shares**2).sum(2)))
    size = len(n) / np.sum(1 / n)  # the harmonic mean
    total = np.mean(1 - (shares.mean(0) ** 2).sum(1)) + within / (size * len(n))
    return {
        "H_S": float(within),
        "H_T": float(total),
        "F_ST": float((total - within) / max(total, 1e-9)),
        "alleles": float((counts.sum(0) > 0).sum(1).mean()),
    }


def decisions(living: Any, goat: Any, rows: np.ndarray) -> np.ndarray:
    """Return the probability of each action under each goat's policy, for shared observations: f64[goats, 64,
    k]."""
    from ecs_eco.components import Policy

    minds, channels = goat.species.nerves.individuals, len(goat.species.nerves.channels)
    seen = np.random.default_rng(17).uniform(-1, 1, (64, channels)).astype(np.float32)
    seen[:, 0] = np.abs(seen[:, 0])  # energy
    logits, _ = minds.forward(goat[Policy], np.repeat(rows, 64), np.tile(seen, (rows.size, 1)), living.split)
    out = np.empty(logits.shape)
    for start, stop in zip(minds.offsets[:-1], minds.offsets[1:], strict=True):
        part = np.exp(logits[:, start:stop].astype(float) - logits[:, start:stop].max(1, keepdims=True))
        out[:, start:stop] = part / part.sum(1, keepdims=True)
    return out.reshape(rows.size, 64, -1)


def divergence(groups: list[np.ndarray]) -> dict[str, float]:
    """Return the mean KL divergence [nats] over all pairs of goats, and its share between groups."""
    p = np.concatenate(groups).reshape(sum(map(len, groups)), -1)
    log = np.log(np.maximum(p, 1e-12))
    kl = ((p * log).sum(1)[:, None] - p @ log.T) / 64
    group = np.repeat(np.arange(len(groups)), [len(g) for g in groups])
    same, other = group[:, None] == group, ~np.eye(len(p), dtype=bool)
    within, between = kl[same & other].mean(), kl[~same].mean()
    return {
        "policies": float(kl[other].mean()),
        "policies between": float((between - within) / max(between, 1e-12)),
    }


def numbers(entry: dict[str, Any], name: str) -> np.ndarray:
    """Return a line of numbers from one run."""
    return np.array([float(v) for v in entry["result"][name].split()])


def by_seed(cases: list[dict[str, Any]], arm: str, name: str) -> dict[int, float]:
    """Return, for each seed, a value at the end of an arm's runs."""
    return {e["case"]["seed"]: float(numbers(e, name)[-1]) for e in cases if e["case"]["arm"] == arm}


def apart(cases: list[dict[str, Any]], name: str, one: str, other: str) -> list[float]:
    """Return the mean difference between two arms, paired by seed, and its 95% interval."""
    from studies.common.selection import pooled

    a, b = by_seed(cases, one, name), by_seed(cases, other, name)
    estimate = pooled([a[seed] - b[seed] for seed in sorted(set(a) & set(b))])
    return [estimate.mean, *estimate.interval95]


def effective_number(cases: list[dict[str, Any]], sample: int) -> tuple[float, float]:
    """Return an island's effective population size and the generation time [ticks] from the isolated runs."""
    mine = [e for e in cases if e["case"]["arm"] == "isolated"]
    generation = float(np.mean([e["result"]["generation"] for e in mine]))
    slopes = []
    for entry in mine:
        h = np.log(np.maximum(numbers(entry, "H_S"), 1e-6))
        slopes.append(np.polyfit(np.arange(len(h)) * sample / generation, h, 1)[0] if len(h) > 1 else np.nan)
    return float(-1 / (2 * np.mean(slopes))), generation


def expected(number: float, moved: float) -> float:
    """Return F_ST under Wright's island model for a given number of islands and a given fraction of migrants
    per generation."""
    return 1 / (1 + 4 * number * moved * (ISLANDS / (ISLANDS - 1)) ** 2)


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the six hypotheses, and the results without a goal."""
    config = CONFIG if max(e["case"]["seed"] for e in cases) < 100 else CONFIG | SHORT
    number, generation = effective_number(cases, config["sample"])
    out = []
    for statement, name, one, other, sign in (
        ("H_T, isolated minus panmictic", "H_T", "isolated", "panmictic", 1),
        ("H_S, isolated minus panmictic", "H_S", "isolated", "panmictic", -1),
        ("F_ST, isolated minus few", "F_ST", "isolated", "few", 1),
        ("F_ST, few minus many", "F_ST", "few", "many", 1),
        (
            "share of policy divergence between islands, isolated minus panmictic",
            "policies between",
            "isolated",
            "panmictic",
            1,
        ),
        (
            "policy divergence over all pairs [nats], isolated minus panmictic",
            "policies",
            "isolated",
            "panmictic",
            1,
        ),
    ):
        d = apart(cases, name, one, other)
        out.append(
            verdict(statement, d, "above 0" if sign > 0 else "below 0", d[1] > 0 if sign > 0 else d[2] < 0)
        )
    for arm in ("few", "many"):
        moved = LEAVE[arm] * generation / config["every"]
        seen, wright = np.mean(list(by_seed(cases, arm, "F_ST").values())), expected(number, moved)
        out.append(
            verdict(
                f"F_ST of {arm} relative to Wright's {wright:.3f} (N = {number:.1f}, m = {moved:.3f})",
                float(seen / wright),
                "0.5 to 2",
                bool(0.5 <= seen / wright <= 2),
            )
        )
    rows = [
        [arm, *(float(np.mean(list(by_seed(cases, arm, name).values()))) for name in WHAT)] for arm in ARMS
    ]
    return {
        "verdicts": out,
        "table": {
            "head": [
                "arm, at the end",
                *WHAT[:-2],
                "policy divergence [nats]",
                "share of it between islands",
            ],
            "rows": rows,
        },
    }


CONFIG = {"world": world(1), "ticks": 5000, "sample": 500, "every": 100, "leave": LEAVE}
SHORT = {"ticks": 60, "sample": 30, "every": 30}
STUDY = Study(
    name="isolation",
    claim="Isolation keeps diversity of genes and policies that one panmictic world of the same size loses.",
    config=CONFIG,
    cases=[{"arm": arm, "seed": seed} for seed in SEEDS for arm in ARMS],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": arm, "seed": 101} for arm in ARMS],
    short_config=SHORT,
)

if __name__ == "__main__":
    STUDY.main()
