"""Genes in a comparison: allele frequencies, selection and means, with intervals over runs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import stdtrit

from ecs_eco.analysis import genes_figures
from ecs_eco.analysis.carriers import genes_in
from ecs_eco.analysis.genes import few_valued, generation_time, haldanes, quantitative, selections
from ecs_eco.analysis.genes_figures import Band
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.page import drawn, interval, table
from ecs_eco.analysis.runs import mean_of_there, read_manifest
from ecs_eco.analysis.seed_grid import mean_of_seeds
from ecs_eco.analysis.survival import bootstrap_difference

SAMPLES = 200  # approximate maximum number per run
ALLELE = ("first", "last", "s", "per_tick")  # outcomes for a value of a gene, one number per run
QUANTITY = ("first", "last", "sd_first", "sd_last", "haldanes")  # outcomes for a quantitative gene


@dataclass
class Gene:
    """One line of the comparison: a value of a gene, or a quantitative gene, in all runs."""

    species: str
    gene: str
    value: str | None  # None if the gene is quantitative
    trait: str | None
    every: int
    # by arm: each run's frequency or mean over time; outcomes, by run index
    curves: dict[str, list[np.ndarray]] = field(default_factory=dict)
    outcomes: dict[str, dict[int, dict[str, float]]] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The displayed name."""
        return self.gene if self.value is None else f"{self.gene} = {self.value}"

    @property
    def rate(self) -> str:
        """The outcome that measures the rate of evolution."""
        return "haldanes" if self.value is None else "s"


def genes_of(arms: Mapping[str, Sequence[Any]]) -> list[Gene]:
    """Read the genes of all runs (empty if a run is not a folder or has no recorded genomes)."""
    folders = [run for runs in arms.values() for run in runs]
    if not all(isinstance(run, str | Path) for run in folders):
        return []
    manifests = [read_manifest(run) for run in folders]
    genomes = [m.get("genomes", {}).values() for m in manifests]
    if not all(any(few_valued(kept) or quantitative(kept) for kept in of) for of in genomes):
        return []
    every = max(1, max(int(m.get("done", m.get("ticks", 0))) for m in manifests) // SAMPLES)
    found: dict[tuple[str, ...], Gene] = {}
    for arm, runs in arms.items():
        for k, run in enumerate(runs):
            _read(found, arm, k, Lineage.read(run), every)
    return list(found.values())


def _read(found: dict[tuple[str, ...], Gene], arm: str, k: int, lineage: Lineage, every: int) -> None:
    """Add run k of an arm."""
    for s, kept in lineage.genomes.items():
        traits = {g["name"]: g["trait"] for g in genes_in(kept)}
        for name, value, curve, outcome in _outcomes(lineage, s, every) if s in lineage.species else ():
            gene = found.setdefault((s, name, value or ""), Gene(s, name, value, traits[name], every))
            gene.curves.setdefault(arm, []).append(curve)
            gene.outcomes.setdefault(arm, {})[k] = outcome


def _outcomes(
    lineage: Lineage, s: str, every: int
) -> Iterator[tuple[str, str | None, np.ndarray, dict[str, float]]]:
    """Yield each gene of a species in one run, with its value, curve and outcomes."""
    kept, generation = lineage.genomes[s], generation_time(lineage, s)
    for name in few_valued(kept):
        for value, p, outcome in selections(lineage.frequencies(s, name, every), generation):
            yield name, value, p, outcome._asdict()
    for name in quantitative(kept):
        c = lineage.course(s, name, every)
        there = np.flatnonzero(c.n)
        at = (there[0], there[-1]) if there.size else ()
        outcomes = {"haldanes": haldanes(c, generation), "generation": generation}
        outcomes |= zip(("first", "last"), c.mean[list(at)], strict=False)
        outcomes |= zip(("sd_first", "sd_last"), c.sd[list(at)], strict=False)
        yield name, None, c.mean, outcomes


def summary(
    genes: Sequence[Gene], rows: Mapping[str, Sequence[Sequence[int]]], reference: str, seed: int = 0
) -> dict[str, Any]:
    """Return outcomes with 95% intervals by species, gene (with its value) and arm, and `against` the reference.
    `rows` contains the indices of an arm's runs by training seed; both kinds of seeds are replicates."""
    out: dict[str, Any] = {}
    for gene in genes:
        words = QUANTITY if gene.value is None else ALLELE
        tables = {
            arm: {
                w: np.array([[by_run.get(k, {}).get(w, np.nan) for k in row] for row in rows[arm]])
                for w in (*words, "generation")
            }
            for arm, by_run in gene.outcomes.items()
        }
        out.setdefault(gene.species, {})[gene.label] = {
            "trait": gene.trait,
            "kind": "allele" if gene.value is not None else "quantitative",
            "arms": {
                arm: {"n": int(np.isfinite(of["last"]).sum()), **{w: mean_of_seeds(v) for w, v in of.items()}}
                for arm, of in tables.items()
            },
            "against": {
                arm: {w: _difference(of[w], tables[reference][w], seed) for w in ("last", gene.rate)}
                for arm, of in tables.items()
                if reference in tables and arm != reference
            },
        }
    return out


def _difference(one: np.ndarray, two: np.ndarray, seed: int) -> Any:
    """Return the difference between two arms, computed by cell for crossed designs, otherwise by bootstrap."""
    if max(len(one), len(two)) > 1:
        cells = one.shape[1] == two.shape[1] and (len(one) == len(two) or 1 in (len(one), len(two)))
        return mean_of_seeds(one - two) if cells else None
    a, b = (v[np.isfinite(v)] for v in (one, two))
    return bootstrap_difference(a, b, seed=seed) if a.size and b.size else None


def bands(gene: Gene) -> dict[str, Band]:
    """Return the mean over each arm's runs, with Student's t intervals where two or more runs have survivors."""
    out = {}
    for arm, curves in gene.curves.items():
        table = np.array([*zip_longest(*curves, fillvalue=np.nan)]).T
        n, mean = np.isfinite(table).sum(axis=0), mean_of_there(table)
        variance = np.nansum((table - mean) ** 2, axis=0) / np.maximum(n - 1, 1) / np.maximum(n, 1)
        half = np.where(n > 1, stdtrit(np.maximum(n - 1, 1), 0.975) * np.sqrt(variance), np.nan)
        out[arm] = Band(np.arange(len(n)) * gene.every, mean, mean - half, mean + half)
    return out


_FIGURE = "{} of {}: means over runs, with 95% bands from Student's t."
_ALLELES = (
    "<p>Means over runs with 95% intervals. s is the slope of the log odds of a value against all others, "
    "per generation (in each run, the mean age of parents at the birth of their offspring). It includes "
    "drift and mutation; a neutral gene in the same genome shows how large they are.</p>"
)
_QUANTITIES = (
    "<p>The mean and the standard deviation among living organisms, averaged over runs, with 95% intervals. "
    "Change is the slope of the mean, in standard deviations per generation (haldanes).</p>"
)


_RATE = {"allele": "s per generation", "quantitative": "change per generation [sd]"}
_HEADS = {
    "alleles": {
        "first": "first frequency",
        "last": "last",
        "s": _RATE["allele"],
        "generation": "generation [ticks]",
    },
    "genes": {"first": "first mean", "last": "last mean", "sd_first": "first sd", "sd_last": "last sd"}
    | {"haldanes": _RATE["quantitative"]},
}


def blocks(out: Path, genes: Sequence[Gene], result: Mapping[str, Any], reference: str) -> list[str]:
    """Return the figures (also written to `out`) and tables as HTML (empty if there are no genes)."""
    parts = []
    for k, s in enumerate(dict.fromkeys(gene.species for gene in genes)):
        for kind, words, note in (
            ("alleles", "Allele frequencies", _ALLELES),
            ("genes", "Quantitative genes", _QUANTITIES),
        ):
            chosen = [g for g in genes if g.species == s and (g.value is None) == (kind == "genes")]
            if chosen:
                labels = {g.label: "allele frequency" if g.value else g.trait or g.gene for g in chosen}
                figure = genes_figures.arms({g.label: bands(g) for g in chosen}, labels, s, kind == "alleles")
                file = out / "figures" / f"{kind}-{k}.svg"
                of, heads = {g.label: result[s][g.label] for g in chosen}, _HEADS[kind]
                rows = [
                    [gene, arm, a["n"], *(interval(a[w]) for w in heads)]
                    for gene, g in of.items()
                    for arm, a in g["arms"].items()
                ]
                tabled = table(["gene", "arm", "runs", *heads.values()], rows)
                parts += [
                    drawn(figure, file, _FIGURE.format(words, s)),
                    note,
                    tabled,
                    _against(of, reference),
                ]
    return ["<h2>Genes</h2>", *parts] if parts else []


def _against(rows: Mapping[str, Any], reference: str) -> str:
    found = [
        [gene, arm, *(interval(x) for x in gaps.values())]
        for gene, g in rows.items()
        for arm, gaps in g["against"].items()
    ]
    if not found:
        return ""
    rate = _RATE[next(iter(rows.values()))["kind"]]
    head = ["gene", "arm", "last, difference", f"{rate}, difference"]
    return f"<p>Differences from {escape(reference)}:</p>{table(head, found)}"
