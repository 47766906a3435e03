"""Do wolves and deer enter an arms race if their pace, range of sight and policies can change?

Genes encode the pace of all gaits (a gait's cost grows with the square of its pace) and how far deer see
wolves and wolves see deer; founders' genes are drawn at random. Policies are pre-trained and continue to
learn during life. At four points during a run, the study stores the mean genes and policies of deer and
wolves. Hunters from each time then meet prey from each time (Gandon et al. 2008) in the training world, where
population sizes are held constant: K[i, j] is the logarithm of the kills per wolf per second when hunters
from time i meet prey from time j. In an arms race, K rises with the hunters' time and falls with the prey's;
the double-centered diagonal shows whether hunters do best against contemporary prey. The hypotheses are in
registered/arms_race.toml.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.moved import Policies
from studies.common.policies import trained, without_policies
from studies.common.predator_prey import SPARSE_WOLVES, SPECIES, numbers
from studies.common.registration import registration
from studies.common.seed_grid import by_training
from studies.common.selection import mean_interval
from studies.common.study import Study, verdict
from studies.common.training_seeds import share_of_lives

REGISTERED = registration("arms_race")
Entries = list[dict[str, Any]]
GENES = ("pace", "sight")
# for each species: the species that it watches, and the sensor's name and number
SIGHT = {"deer": ("wolf", 3), "wolf": ("deer", 1)}


# --- worlds -----------------------------------------------------------------------------------------------


def genome(ranges: Mapping[str, Any], species: str) -> dict[str, Any]:
    """Return a genome section with both genes."""
    traits = {"pace": "locomotion.pace", "sight": f"sensors.{SIGHT[species][0]}.range"}
    genes = [
        {
            "name": name,
            "trait": traits[name],
            "letters": 4,
            "code": "gray",
            "low": ranges[species][name][0],
            "high": ranges[species][name][1],
        }
        for name in GENES
    ]
    return {"mutate": {"operator": "mutUniformInt", "indpb": ranges["mutation"]}, "genes": genes}


def world(config: Mapping[str, Any], arm: Mapping[str, Any], values: Mapping[str, Any] | None = None) -> Any:
    """Return an arm's world; if gene values are given for a species, all its animals have those values."""
    from ecs_eco.config import load

    content = without_policies(load("predator-prey", SPARSE_WOLVES | config["world"]))
    content["training"]["set"] |= config["small training"]
    for name, (_, sensor) in SIGHT.items():
        species = content["species"][name]
        if values is not None:
            pace, gaits = values[name]["pace"], species["locomotion"]
            gaits["speed"] = {gait: v * pace for gait, v in gaits["speed"].items()}
            gaits["cost"] = {gait: v * pace**2 for gait, v in gaits["cost"].items()}
            species["sensors"][sensor]["radius"] = values[name]["sight"]
        elif arm.get("genes"):
            species["genome"] = genome(config["genes"], name)
    if arm.get("hunters") is False:
        content["species"]["wolf"]["count"] = 0
    return load(content)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one world of an arm; return its genes over time and the kill rate for each pair of sampling
    times."""
    from ecs_eco import World

    arm = REGISTERED.arms[case["arm"]]
    learnt = trained(world(config, {"genes": True}), case["training"], config["training ticks"])
    made = World.from_config(
        world(config, arm),
        seed=case["seed"],
        policies=str(learnt),
        learn=bool(arm.get("learn")),
        controls=arm.get("controls", ()),
    )
    began, times = Policies(made), []
    mortal = [name for name in SIGHT if made.tables[name].n]
    with tempfile.TemporaryDirectory() as folder:
        while True:
            times.append(kept(made, Path(folder) / str(len(times))))
            if made.tick >= config["ticks"]:
                break
            made.run(config["every"])
            if not all(made.tables[name].n for name in mortal):
                break
        lived = made.tick >= config["ticks"] and all(made.tables[name].n for name in mortal)
        tests = meetings(config, case, times) if lived and arm.get("tests") else None
    return {
        "persisted": lived,
        "lived": made.tick,
        "genes": [t["genes"] for t in times],
        "tests": tests,
        "numbers": dict(zip(SPECIES, numbers(made).mean(0), strict=True)),
        "moved": began.moved() if arm.get("learn") and lived else None,
    }


def kept(made: Any, folder: Path) -> dict[str, Any]:
    """Return each gene's mean and standard deviation by species, and the folder of the policies."""
    from ecs_eco.components import Genome
    from ecs_eco.learning.weights import save

    out: dict[str, dict[str, list[float]]] = {}
    folder.mkdir()
    for name in SIGHT:
        table = made.tables[name]
        species = table.species
        save(folder / f"{name}.safetensors", species.nerves.brain.state())
        if species.heredity is None or not table.n:
            out[name] = {}
            continue
        decoded = species.heredity.layout.decode(table[Genome].loci[table.rows()])
        out[name] = {gene: [float(np.mean(decoded[gene])), float(np.std(decoded[gene]))] for gene in GENES}
    return {"genes": out, "folder": str(folder)}


def meetings(
    config: Mapping[str, Any], case: Mapping[str, Any], times: list[dict[str, Any]]
) -> list[list[float]]:
    """Return K, indexed by the sampling times of hunters and prey."""
    from ecs_eco import World

    shift, middle = (
        config["shift"],
        {name: {gene: float(np.mean(config["genes"][name][gene])) for gene in GENES} for name in SIGHT},
    )
    chosen = [times[i * (len(times) - 1) // (shift["times"] - 1)] for i in range(shift["times"])]

    def like(time: Mapping[str, Any], name: str) -> dict[str, float]:
        return {gene: time["genes"][name][gene][0] for gene in GENES} if time["genes"][name] else middle[name]

    out = []
    for hunters in chosen:
        out.append([])
        for prey in chosen:
            pair = world(config, {}, {"deer": like(prey, "deer"), "wolf": like(hunters, "wolf")})
            policies = {"deer": prey["folder"], "wolf": hunters["folder"]}
            made = World.from_config(pair, seed=case["seed"], policies=policies, learn=False, training=True)
            made.run(shift["ticks"])
            series = made.series().to_pydict()
            killed = sum(
                k
                for k, who, tick in zip(
                    series["died: eaten by wolf"], series["species"], series["tick"], strict=True
                )
                if who == "deer" and tick >= shift["after"]
            )
            wolves = made.tables["wolf"].species.count
            out[-1].append(float(np.log((killed + 0.5) / wolves / (shift["ticks"] - shift["after"]))))
    return out


# --- statistics -------------------------------------------------------------------------------------------


def slope(tests: list[list[float]], of: str, ticks: float) -> float:
    """Return the least-squares change in K per 1,000 ticks of the hunters' or prey's sampling time."""
    k = np.array(tests)
    y = k.mean(1 if of == "hunters" else 0)
    return float(1000 * np.polyfit(np.linspace(0, ticks, len(y)), y, 1)[0])


def contemporary(tests: list[list[float]], ticks: float = 0.0) -> float:
    """Return the mean of the diagonal of K minus the means of its rows and columns."""
    k = np.array(tests)
    return float(np.diag(k - k.mean(0) - k.mean(1)[:, None] + k.mean()).mean())


def shifts(entries: Entries, arm: str, of: str, ticks: float) -> list[float]:
    """Return, for each training seed, the mean of `slope` or `contemporary` over its tested runs."""

    def value(tests: list[list[float]]) -> float:
        return contemporary(tests) if of == "contemporary" else slope(tests, of, ticks)

    by = by_training(entries, arm)
    return [
        float(np.mean(own))
        for results in by.values()
        if (own := [value(r["tests"]) for r in results if r["tests"]])
    ]


def changed(entries: Entries, arm: str, species: str, gene: str) -> dict[int, float]:
    """Return, for each training seed, the change in a gene's mean, averaged over the runs that persist."""
    out = {}
    for seed, results in by_training(entries, arm).items():
        own = [
            r["genes"][-1][species][gene][0] - r["genes"][0][species][gene][0]
            for r in results
            if r["persisted"]
        ]
        if own:
            out[seed] = float(np.mean(own))
    return out


def difference(one: Mapping[int, float], other: Mapping[int, float]) -> list[float]:
    """Return the mean difference over training seeds common to both arms, and its 95% interval (t)."""
    return mean_interval([one[k] - other[k] for k in one if k in other])


def persisting(entries: Entries, arm: str) -> float:
    """Return the share of runs in which all species persist."""
    return float(np.mean([r["persisted"] for of in by_training(entries, arm).values() for r in of]))


# --- conclusions ------------------------------------------------------------------------------------------


def summarise(entries: Entries) -> dict[str, Any]:
    """Test the registered hypotheses; return the verdicts, K for each arm and a line for each arm."""
    if {e["case"]["arm"] for e in entries} < set(REGISTERED.arms):  # the short form omits some arms
        return {"verdicts": [verdict("cases that ran", len(entries), "reported", True)]}
    ticks = REGISTERED.content["ticks"]
    both = [e["case"] | e["result"] for e in entries if e["case"]["arm"] == "both"]
    share = share_of_lives(both, "persisted")
    lines = [REGISTERED.verdict("persists", share, persisting(entries, "both") >= 0.8)]
    for arm in ("both", "genes", "learning"):
        for of in ("hunters", "prey", "contemporary"):
            value, name = mean_interval(shifts(entries, arm, of, ticks)), f"{arm}-{of}"
            if name not in REGISTERED.hypotheses:
                continue
            margin = REGISTERED.hypotheses[name].get("margin")
            met = (
                max(-value[1], value[2]) < margin
                if margin
                else value[2] < 0
                if of == "prey"
                else value[1] > 0
            )
            lines.append(REGISTERED.verdict(name, value, bool(met)))
    for species, gene in (("deer", "pace"), ("deer", "sight"), ("wolf", "sight")):
        gap = difference(changed(entries, "both", species, gene), changed(entries, "drift", species, gene))
        lines.append(REGISTERED.verdict(f"{species}-{gene}", gap, bool(gap[1] > 0)))
    for gene in GENES:
        gap = difference(*(changed(entries, arm, "deer", gene) for arm in ("genes", "no hunters")))
        lines.append(REGISTERED.verdict(f"hunted-{gene}", gap, bool(gap[1] > 0)))
    lines += moved(entries)
    head = [
        "arm",
        "runs",
        "persist",
        *(f"{s}: {g}, first → last" for s in SIGHT for g in GENES),
        "kills per wolf per 1,000 s, by sampling time of hunters (rows) and prey (columns)",
    ]
    rows = []
    for arm in REGISTERED.arms:
        results = [r for of in by_training(entries, arm).values() for r in of]
        lived, tests = [r for r in results if r["persisted"]], [r["tests"] for r in results if r["tests"]]
        rows.append(
            [
                arm,
                len(results),
                len(lived),
                *(course(lived, s, g) for s in SIGHT for g in GENES),
                kills(tests) if tests else "–",
            ]
        )
    return {"verdicts": lines, "table": {"head": head, "rows": rows}}


def moved(entries: Entries) -> list[dict[str, Any]]:
    """Return the lines that report how far learning moved the policies."""
    out = []
    for arm in ("both", "learning"):
        nats = [r["moved"] for of in by_training(entries, arm).values() for r in of if r["moved"]]
        out += [
            verdict(
                f"{arm}: change of the {name} policy [nats] (KL divergence of the first policy from the last)",
                float(np.mean([n[name] for n in nats if n[name] is not None])),
                "reported",
                True,
            )
            for name in SIGHT
            if nats
        ]
    return out


def course(results: list[dict[str, Any]], species: str, gene: str) -> str:
    """Return a gene's mean over runs at the start and at the end."""
    own = [
        [t[species][gene][0] for t in (r["genes"][0], r["genes"][-1])]
        for r in results
        if r["genes"][-1][species]
    ]
    return "{:.2f} → {:.2f}".format(*np.mean(own, 0)) if own else "–"


def kills(tests: list[list[list[float]]]) -> str:
    """Return a table of kills per wolf per 1,000 s (geometric means over runs), with a row for each of the
    hunters' times."""
    return "; ".join(" ".join(f"{v:.1f}" for v in row) for row in 1000 * np.exp(np.mean(tests, 0)))


CONTENT = REGISTERED.content
SEEDS = CONTENT["seeds"]
SMALL = {
    "space.size": [60.0, 60.0],
    "species.grass.count": 200,
    "species.deer.count": 40,
    "species.wolf.count": 10,
}
STUDY = Study(
    name="arms_race",
    claim=CONTENT["claim"],
    registered=REGISTERED,
    config={
        "world": {},  # changes to predator-prey and to its training
        "small training": {},
        "genes": CONTENT["genes"],
        "shift": CONTENT["shift"],
        "ticks": CONTENT["ticks"],
        "every": CONTENT["every"],
        "training ticks": None,
    },
    cases=[
        {"arm": arm, "training": training, "seed": seed}
        for i, seed in enumerate(SEEDS["world"])
        for training in SEEDS["training"]
        for arm, of in REGISTERED.arms.items()
        if i < of["worlds"]
    ],
    run=run,
    summarise=summarise,
    short_cases=[{"arm": "both", "training": 1, "seed": 1}, {"arm": "no hunters", "training": 1, "seed": 1}],
    short_config={
        "world": SMALL | {"species.wolf.count": 12},
        "small training": SMALL,
        "ticks": 40,
        "every": 20,
        "training ticks": 8,
        "shift": {"times": 2, "ticks": 20, "after": 5},
    },
)

if __name__ == "__main__":
    STUDY.main()
