"""What does `ecs-eco explain` say of the genes in worlds of the evidence?

Each world runs once, with seed 41, chosen before the first run. For each gene named in a claim, the allele of the
clearest sweep is taken out of a random half of its carriers, in forks at half of the rise. One run cannot show that
a gene spreads, which the worlds' own studies test: it shows what the allele did in this run. arms_race is the world
of its study's first registration, with genes and with the frozen policies of `predator-prey`; "arms_race, learning"
is the world of the second, `predator-prey` with the same genes, whose animals learn in life. The only goal was set
before the first run: without the reflex against red grass, more goats die by it, and they have fewer young.
"""

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from studies.arms_race import STUDY as ARMS_RACE, genome
from studies.common.predator_prey import SPARSE_WOLVES, frozen
from studies.common.study import Study, verdict
from studies.gene_duplication import WORLD as GENE_DUPLICATION

SEED = 41
WORLDS: dict[str, dict[str, Any]] = {  # length of the run [ticks], and the genes by species
    "reflexes": {"ticks": 2500, "genes": {"goat": ["red"]}},
    "arms_race": {"ticks": 2000, "genes": {"deer": ["sight", "pace"], "wolf": ["sight", "pace"]}},
    "happiness": {"ticks": 2000, "genes": {"vole": ["energy", "berry", "nightshade"]}},
    "gene_duplication": {"ticks": 1500, "genes": {"goat": ["red", "yellow"]}},
    "innate": {"ticks": 2500, "genes": {"goat": ["brain"]}},
    "arms_race, learning": {"ticks": 6000, "genes": {"deer": ["sight", "pace"], "wolf": ["sight", "pace"]}},
}
FIRST_RACE = {
    "space.size": [170.0, 170.0],
    "species.grass.count": 2150,
    "species.deer.count": 350,
    "species.wolf.count": 60,
    "species.deer.locomotion.cost.run": 0.008,
    "species.wolf.locomotion.speed.run": 1.2,
    "species.wolf.locomotion.cost.run": 0.008,
    "species.wolf.diet.0.chance": 0.5,
    "species.wolf.diet.0.gain": 0.6,
    "species.wolf.reproduction.spacing": 12.0,
}
LONGER = {"gene_duplication": 5000, "arms_race": 6000}  # [ticks]


def world(name: str) -> Any:
    """Return a world, or the name of a shipped one."""
    from ecs_eco.config import load

    if not name.startswith("arms_race"):
        return GENE_DUPLICATION if name == "gene_duplication" else name
    base = frozen(FIRST_RACE) if name == "arms_race" else load("predator-prey", SPARSE_WOLVES)
    content = base.resolved()
    for species in ("deer", "wolf"):
        content["species"][species]["genome"] = genome(ARMS_RACE.config["genes"], species)
    return content


def run(config: dict[str, Any], case: Mapping[str, Any]) -> dict[str, Any]:
    """Run one world and explain its genes: {species gene: its account, or None}."""
    from ecs_eco.analysis.lineage import Lineage
    from ecs_eco.explain import rises
    from ecs_eco.explain.account import account
    from ecs_eco.record import run_to_folder

    how, found = config["worlds"][case["world"]], {}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        ticks = config.get("most ticks", case.get("ticks", how["ticks"]))
        run_to_folder(world(case["world"]), seed=case["seed"], ticks=ticks, out=out, report=False)
        lineage = Lineage.read(out)
        for species, genes in how["genes"].items():
            sweeps = rises(lineage, species)
            for gene in genes:
                sweep = of_gene(sweeps, gene)
                options = {"forks": config["forks"], "ticks": config["fork ticks"], "workers": 1}
                found[f"{species} {gene}"] = sweep and account(out, sweep, **options).to_json()
    return found


def of_gene(sweeps: list[Any], gene: str) -> Any:
    """Return the clearest sweep with an allele of a gene, with this allele as its only one, or None."""
    for sweep in sorted(sweeps, key=lambda sweep: sweep.p):
        for allele in (sweep.lead, *(allele for allele, _ in sweep.linked)):
            if allele.gene == gene and allele.kind in ("letter", "value", "copies"):
                return replace(sweep, lead=allele, linked=())
    return None


def effect(told: Mapping[str, Any] | None, measure: str = "births") -> list[Any]:
    """Return the effect of taking an allele out, with its interval; NaN if it was not taken out."""
    rows = [row for row in told["effects"] if row["measure"] == measure and not row["dose"]] if told else []
    return [rows[0][key] for key in ("effect", "low", "high")] if rows else [float("nan")] * 3


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the verdicts, a table of genes, and the sentences on them."""
    names = [e["case"]["world"] + ", longer" * ("ticks" in e["case"]) for e in cases]
    both = zip(names, cases, strict=True)
    all_genes = {(name, gene): one for name, e in both for gene, one in e["result"].items()}
    told = {key: one for key, one in all_genes.items() if one}
    red = told.get(("reflexes", "goat red"))
    low, high = effect(red, "died: poisoned by red")[1], effect(red)[2]
    clear = sum(effect(one)[2] < 0 for one in told.values())
    missing = ", ".join(" ".join(key) for key in all_genes if key not in told) or "none"
    return {
        "verdicts": [
            verdict("reflexes, red: more deaths by red grass without it, lower end", low, "> 0", low > 0),
            verdict("reflexes, red: young without it, upper end of the change", high, "< 0", high < 0),
            verdict(f"genes whose loss clearly costs young, of {len(told)}", clear, "reported", True),
        ],
        "table": {
            "head": ["world", "gene", "allele", "from", "to", "s", "change in young without it"],
            "rows": [
                [*key, one["lead"], f"{one['first']:.0%}", f"{one['last']:.0%}", one["s"], effect(one)]
                for key, one in told.items()
            ],
        },
        "notes": "The first runs of arms_race and gene_duplication had no sweep of these genes, so we added runs "
        "as long as in their studies, with the same seed, and one with learning. Without a sweep: "
        f"{missing}.\n\n"
        + "\n\n".join(f"{' '.join(key)}: {' '.join(one['sentences'])}" for key, one in told.items()),
    }


STUDY = Study(
    name="explained",
    claim="`ecs-eco explain` names the letters that spread in worlds of the evidence, and what they did.",
    config={"worlds": WORLDS, "forks": 8, "fork ticks": 500},
    cases=[{"world": name, "seed": SEED} for name in WORLDS]
    + [{"world": name, "seed": SEED, "ticks": ticks} for name, ticks in LONGER.items()],
    run=run,
    summarise=summarise,
    short_config={"forks": 2, "fork ticks": 20, "most ticks": 300},
    short_cases=[{"world": "reflexes", "seed": SEED}],
)

if __name__ == "__main__":
    STUDY.main()
