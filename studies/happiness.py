"""Does happiness evolve?

During their lives, voles learn to seek what makes them happy, and their genes determine what that is. The
world prescribes no preferences. Founders' four happiness weights are random; births and deaths select among
them. Each arm removes one factor: the effect of genes (neutral drift), learning, the voles (so that berries
evolve without grazers), or the descent of a newborn's genes (shuffled genome). The last arm is not a null
model: genes drawn from living voles are survivors' genes, so the arm removes selection by breeding but keeps
selection by death. Runs with the same seed start with the same genomes and are compared in pairs.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.study import Study, config_hash, verdict

ARMS: dict[str, dict[str, Any]] = {
    "evolving": {},
    "neutral drift": {"controls": ("neutral-drift",)},
    "shuffled genome": {"controls": ("shuffled-genome",)},
    "no learning": {"learn": False},
    "no grazers": {},
}
# the weights expected to rise, and the weight expected to fall
WEIGHTS = {"energy": 1, "berry": 1, "nightshade": -1}
GENES = {"vole": (*WEIGHTS, "vole", "marker"), "berry": ("tough", "poison", "spread", "marker")}
SEEDS = tuple(range(2001, 2011))
Changes = dict[tuple[str, str], dict[int, float]]  # (arm, gene) → seed → change in the gene's mean
FIGURE = Path(__file__).parent.parent / "docs" / "img" / "happiness_genes.png"


class Generations:
    """The number of generations since the founders, for every organism of a species, by uid."""

    def __init__(self, world: Any, species: str) -> None:
        self.table = world.tables[species]
        self.of = dict.fromkeys(self.table.uid[self.table.rows()].tolist(), 0.0)
        world.on_birth.append(self.born)

    def born(self, table: Any, rows: np.ndarray, first: np.ndarray, second: np.ndarray) -> None:
        """Record newborns: their generation is one more than their parents' mean."""
        if table is self.table:
            for uid, a, b in zip(table.uid[rows].tolist(), first.tolist(), second.tolist(), strict=True):
                mother = self.of.get(a, 0.0)
                self.of[uid] = 1 + (mother + self.of.get(b, mother)) / 2

    def mean(self) -> float | None:
        """Return the mean over living organisms; None if no organisms are alive."""
        living = self.table.uid[self.table.rows()].tolist()
        return float(np.mean([self.of[uid] for uid in living])) if living else None


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run one arm; return the mean gene values every `every` ticks, generations, numbers and causes of
    death."""
    from ecs_eco import World
    from ecs_eco.config import load

    world = World.from_config(load(config["world"]), seed=case["seed"], **ARMS[case["arm"]])
    depth, means = Generations(world, "vole"), [genes(world)]
    if case["arm"] == "no grazers":
        for uid in world.tables["vole"].uid[world.tables["vole"].rows()]:
            world.kill(uid)
        world.flush()
    while world.tick < config["ticks"]:
        world.run(config["every"])
        means.append(genes(world))
    lived = {n: world.tables[n].n for n in ("vole", "berry", "nightshade")}
    return {
        "genes": {k: " ".join(f"{s[k]:.3f}" for s in means) for k in means[0]},
        "generations": depth.mean(),
        "end": lived,
        **lives(world),
    }


def genes(world: Any) -> dict[str, float]:
    """Return each gene's mean value over living organisms of its species; NaN if no organisms are alive."""
    from ecs_eco.components import Genome

    out: dict[str, float] = {}
    for species, names in GENES.items():
        table = world.tables[species]
        rows = table.rows()
        values = table.species.heredity.layout.decode(table[Genome].loci[rows])
        out |= {
            f"{species}.{n}": float(values[n].mean(dtype=np.float64)) if rows.size else np.nan for n in names
        }
    return out


def lives(world: Any) -> dict[str, Any]:
    """Return mean numbers, causes of death, and poisonings per vole, per nightshade and per 10⁶ ticks, all
    over the last quarter of a run."""
    series = world.series().to_pydict()
    rows = {
        n: [
            i
            for i, (s, t) in enumerate(zip(series["species"], series["tick"], strict=True))
            if s == n and t >= 0.75 * world.tick
        ]
        for n in ("vole", "berry", "nightshade")
    }
    n = {name: np.array([series["n"][i] for i in at], float) for name, at in rows.items()}
    died = {c: sum(series[c][i] for i in rows["vole"]) for c in series if c.startswith("died: ")}
    met = float((n["vole"] * n["nightshade"]).sum())
    return {
        "numbers": {k: v.mean() for k, v in n.items()},
        "deaths": {k: v for k, v in died.items() if v},
        "risk": died["died: poisoned by nightshade"] / met * 1e6 if met else None,
    }


def changed(cases: list[dict[str, Any]], arm: str, gene: str) -> dict[int, float]:
    """Return, for each seed, the change in a gene's mean from the founders to the last quarter of the run,
    excluding runs that went extinct."""
    out = {}
    for entry in cases:
        if entry["case"]["arm"] == arm and not np.isnan(end := late(line := numbers(entry, gene))):
            out[entry["case"]["seed"]] = end - float(line[0])
    return out


def numbers(entry: dict[str, Any], gene: str) -> np.ndarray:
    """Return a gene's mean value over time in one run: f64[samples], NaN if it had no carriers."""
    return np.array([float(v) for v in entry["result"]["genes"][gene].split()])


def late(line: np.ndarray) -> float:
    """Return the mean of the last quarter of the samples."""
    return float(line[-max(1, len(line) // 4) :].mean())


def interval(values: list[float]) -> list[float] | None:
    """Return the mean and 95% t interval over seeds; None for fewer than two seeds."""
    from studies.common.selection import pooled

    if len(values) < 2:
        return None
    estimate = pooled(values)
    return [estimate.mean, *estimate.interval95]


def apart(one: dict[int, float], other: dict[int, float]) -> list[float] | None:
    """Return the mean difference between two arms and its interval, paired by seed."""
    return interval([one[s] - other[s] for s in sorted(set(one) & set(other))])


def beyond(interval_: list[float] | None, sign: int) -> bool:
    """Return whether an interval excludes 0."""
    return interval_ is not None and (interval_[1] > 0 if sign > 0 else interval_[2] < 0)


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return every gene's change in each arm, and the differences between arms."""
    arms = [a for a in ARMS if any(e["case"]["arm"] == a for e in cases)]
    moved = {
        (a, f"{s}.{g}"): changed(cases, a, f"{s}.{g}")
        for a in arms
        for s, names in GENES.items()
        for g in names
    }
    out = [*weights_against_controls(moved, arms), *genes_at_rest(moved, arms)]
    if "no learning" in arms:
        out.append(risk_of_nightshade(cases))
    if "no grazers" in arms:
        out += defence_of_berries(moved)
    if "shuffled genome" in arms:
        out.append(breeding_against_survival(moved))
    out += sizes_of_runs(cases)
    rows = [
        [
            a,
            g,
            len(v),
            np.mean([numbers(e, g)[0] for e in cases if e["case"]["arm"] == a]),
            interval(list(v.values())),
        ]
        for (a, g), v in moved.items()
        if v
    ]
    return {"verdicts": out, "table": {"head": ["arm", "gene", "runs", "start", "change"], "rows": rows}}


def weights_against_controls(moved: Changes, arms: list[str]) -> list[dict[str, Any]]:
    """Test that happiness weights change as expected, and more than without selection or learning."""
    out = []
    for name, sign in WEIGHTS.items():
        for control in ("neutral drift", "no learning"):
            if control in arms:
                difference = apart(moved["evolving", f"vole.{name}"], moved[control, f"vole.{name}"])
                out.append(
                    verdict(
                        f"change of the weight of {name} in happiness, evolving minus {control}",
                        difference,
                        "above 0" if sign > 0 else "below 0",
                        beyond(difference, sign),
                    )
                )
    return out


def genes_at_rest(moved: Changes, arms: list[str]) -> list[dict[str, Any]]:
    """Test that at most one vole gene changes without selection."""
    out = []
    for control in [a for a in ("neutral drift", "no learning") if a in arms]:
        each = {g: interval(list(moved[control, f"vole.{g}"].values())) for g in (*WEIGHTS, "vole", "marker")}
        n = sum(beyond(v, 1) or beyond(v, -1) for v in each.values())
        out.append(
            verdict(
                f"{control}: vole genes that changed, of 5 (95% interval without 0)",
                n,
                "at most 1, by chance",
                n <= 1,
            )
        )
    return out


def risk_of_nightshade(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Test that voles that learn during life die less often from nightshade."""
    risk = {
        a: {
            e["case"]["seed"]: e["result"]["risk"]
            for e in cases
            if e["case"]["arm"] == a and e["result"]["risk"]
        }
        for a in ("evolving", "no learning")
    }
    difference = apart(
        {s: np.log(v) for s, v in risk["evolving"].items()},
        {s: np.log(v) for s, v in risk["no learning"].items()},
    )
    ratio = None if difference is None else [float(np.exp(v)) for v in difference]
    return verdict(
        "a vole's risk of death from nightshade, evolving relative to no learning",
        ratio,
        "below 1",
        beyond(difference, -1),
    )


def defence_of_berries(moved: Changes) -> list[dict[str, Any]]:
    """Test that grazers make berries tough but not poisonous."""
    tough, poison = (
        apart(moved["evolving", f"berry.{g}"], moved["no grazers", f"berry.{g}"]) for g in ("tough", "poison")
    )
    alone = interval(list(moved["no grazers", "berry.tough"].values()))
    return [
        verdict(
            "change of berry toughness, with grazers minus without grazers",
            tough,
            "above 0",
            beyond(tough, 1),
        ),
        verdict(
            "change of berry poison, with grazers minus without grazers",
            poison,
            "not above 0: poison protects only other berries",
            not beyond(poison, 1),
        ),
        verdict(
            "change of berry toughness without grazers",
            alone,
            "below 0: toughness costs seeds",
            beyond(alone, -1),
        ),
    ]


def breeding_against_survival(moved: Changes) -> dict[str, Any]:
    """Test that shuffled genes change less than genes inherited from parents."""
    sums = [
        {
            s: sum(sign * moved[a, f"vole.{g}"][s] for g, sign in WEIGHTS.items())
            for s in moved[a, "vole.energy"]
        }
        for a in ("evolving", "shuffled genome")
    ]
    difference = apart(sums[0], sums[1])
    return verdict(
        "changes of the energy and berry weights minus that of nightshade, evolving minus shuffled genome",
        difference,
        "above 0: breeding matters, not only survival",
        beyond(difference, 1),
    )


def sizes_of_runs(cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Test that evolving runs are long enough and their populations large enough to be informative."""
    mine = [e["result"] for e in cases if e["case"]["arm"] == "evolving"]
    generations = min(r["generations"] or 0 for r in mine)
    voles = min(r["numbers"]["vole"] for r in mine)
    return [
        verdict(
            "fewest generations of voles in an evolving run", generations, "30 or more", generations >= 30
        ),
        verdict(
            "smallest mean number of voles in the last quarter of an evolving run",
            voles,
            "300 or more",
            voles >= 300,
        ),
    ]


def draw(record: dict[str, Any], path: Path) -> None:
    """Plot mean genes over time: a line for each run, and a thick line for each arm's mean."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    from ecs_eco.analysis.figures import PALETTE

    panels = {
        "vole.energy": "own energy",
        "vole.berry": "proximity of a berry",
        "vole.nightshade": "proximity of nightshade",
        "vole.vole": "proximity of a vole",
        "vole.marker": "neutral marker",
        "berry.tough": "berries: toughness",
    }
    figure = Figure(figsize=(9.6, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    every = record["config"]["every"]
    for axes, (gene, title) in zip(figure.subplots(2, 3, sharex=True).flat, panels.items(), strict=True):
        shown = [
            a for a in ARMS if a != "shuffled genome" and (gene.startswith("berry") or a != "no grazers")
        ]
        for arm in shown:
            lines = np.array([numbers(e, gene) for e in record["cases"] if e["case"]["arm"] == arm])
            if not lines.size:
                continue
            t, color = np.arange(lines.shape[1]) * every, PALETTE[list(ARMS).index(arm)]
            axes.plot(t, lines.T, color=color, alpha=0.25, lw=0.6)
            axes.plot(t, lines.mean(0), color=color, lw=2, label=arm)
        axes.set_title(
            title if gene.startswith(("berry", "vole.marker")) else f"weight of {title}",
            fontsize=10,
            loc="left",
        )
        axes.spines[["top", "right"]].set_visible(False)
        axes.set_ylim(*((0, 1) if gene.startswith("berry") else (-1, 1)))
        if gene.startswith("vole"):
            axes.axhline(0, color="#999999", lw=0.6)
        if axes.get_subplotspec().is_last_row():
            axes.set_xlabel("tick")
        if gene in ("vole.energy", "berry.tough"):
            axes.legend(
                frameon=False, fontsize=8, loc="upper right" if gene.startswith("berry") else "lower right"
            )
    figure.savefig(path, dpi=100)
    Image.open(path).convert("RGB").quantize(96).save(path, optimize=True)  # one third of the size


def identity() -> str:
    """Return the hash of the shipped world, so that changing the world invalidates the results."""
    from ecs_eco.config import load

    return config_hash(load("happiness").resolved(former=True))[:16]


STUDY = Study(
    name="happiness",
    claim="Happiness weights evolve through which voles survive and breed, although no rule states what a "
    "vole should want.",
    config={"world": "happiness", "identity": identity(), "ticks": 4000, "every": 200},
    cases=[{"arm": arm, "seed": s} for s in SEEDS for arm in ARMS],
    run=run,
    summarise=summarise,
    short_cases=[
        {"arm": arm, "seed": s} for s in (1, 2) for arm in ("evolving", "neutral drift", "no grazers")
    ],
    short_config={"ticks": 400},
)

if __name__ == "__main__":
    if "--draw" in sys.argv:
        import json

        draw(json.loads((Path(__file__).parent / "results" / "happiness.json").read_text()), FIGURE)
    else:
        STUDY.main()
