"""Write what evolved in a run and why: explain.html for people, explain.json and Parquet for programs."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from html import escape
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import pyarrow as pa

from ecs_eco.analysis.breeding import responses
from ecs_eco.analysis.carriers import genes_in
from ecs_eco.analysis.compare import clean
from ecs_eco.analysis.genes import quantitative
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.page import drawn, interval, number, page, table, verdict, write_text
from ecs_eco.analysis.runs import read_manifest
from ecs_eco.engine.arguments import called_with, whole_number
from ecs_eco.engine.errors import in_words
from ecs_eco.explain import figures
from ecs_eco.explain.account import (
    Account,
    Options,
    When,
    Which,
    account,
    candidates,
    jobs_of,
    moments,
    rose,
    signed,
)
from ecs_eco.explain.alleles import Paths
from ecs_eco.explain.events import LEAST, Sweep, sweeps_and_tests
from ecs_eco.record.archipelago import is_archipelago, read as read_archipelago
from ecs_eco.record.container import inside
from ecs_eco.record.parquet import write_part

MOST = 8  # sweeps whose alleles are taken out, the clearest first
HOW = (
    "Drift is measured from the births and deaths of the run. The test treats organisms as exchangeable: if "
    "relatives share a place and its risks, drift is stronger than measured. q is the p-value adjusted for the "
    "number of alleles: of the alleles with q up to {fdr:g}, on average at most this fraction rose by drift only "
    "(false discovery rate). Alleles that rose together are then combined into one sweep. s is the slope of the "
    "log odds per generation that is due to unequal births and deaths, in the part of the run in which the rise is "
    "clearest. Its 95% interval ignores this choice, so s of weak sweeps is rather too high. A rise begins when a "
    "quarter of it is over, and ends at 95% of it. At the end of the run, a complete sweep is at 95% or more, a "
    "balanced one has been level for a third of the run (which does not prove balancing selection), and a passing "
    "one has lost at least three quarters of its rise; all others are partial. r² is the squared correlation of "
    "two alleles among living organisms."
)
QUANTITATIVE = 4  # quantitative genes of a species with a section
WORDS = {
    "mean": "mean of newborns",
    "sd": "standard deviation within cohorts",
    "opportunity": "opportunity for selection (variance of relative lifetime births)",
    "differential": "selection differential S",
    "intensity": "selection intensity [standard deviations]",
    "response": "response R",
    "midparent": "slope of offspring on parents (heritability)",
    "realized": "realized heritability",
}
EFFECTS = (
    "Effects of taking each allele out: differences between carriers that lost it and carriers that kept it in the "
    "same worlds, from the change to death or the end of the fork. Shares of deaths and actions are in percentage "
    "points, all others in percent. Lines are 95% intervals over forks, gray if they contain 0. All forks begin "
    "with the same organisms, so intervals describe this population at this tick; for other populations, use "
    "several seeds. Both halves compete in the same worlds: if all organisms lose an allele, its effect can differ."
)


def write_explanation(
    run: Path | str,
    out: Path | str | None = None,
    *,
    species: str | None = None,
    fdr: float = 0.01,
    tick: When = None,
    forks: int = 24,
    learned: bool = False,
    reverse: bool = False,
    together: bool = False,
    progress: Callable[[int, int], None] | None = None,
    **how: Unpack[Options],
) -> dict[str, Any]:
    """Find the alleles that rose in a run, take them out in forks, and report their effects.

    Writes explain.html, explain.json, figures/explain-*.svg, and the Parquet files explain/frequencies.parquet
    and explain/effects.parquet. Forks that are already in RUN/explain/ are not run again.

    Parameters
    ----------
    run : str or Path
        Folder of a run or an archipelago; only runs can be forked.
    out : str or Path, optional
        Folder for the files; default: the folder of the run.
    species : str, optional
        Default: every species that reproduces.
    fdr : float, default 0.01
        Largest expected proportion of false positives among the alleles that pass the test; see `rises`.
    tick : int or {"before", "within", "after"}, or a sequence of them, optional
        Ticks of the forks: a number, or when the rise begins, is half over and ends. Default: "within". Only the
        effects of single alleles are measured at more than the first of several ticks.
    forks : int, default 24
        Forks for each allele; 0: none.
    learned : bool, default False
        Whether to undo learning, too, in a 2 × 2 comparison with each lead; see `account`.
    reverse : bool, default False
        Whether to put each lead into organisms without it, too.
    together : bool, default False
        Whether to take out the leads of the two clearest sweeps of a species together, too, in a 2 × 2
        comparison.
    progress : callable, optional
        Called as `progress(done, forks)`.
    **how
        Other arguments of `take_out`: ticks, seed, engine, workers, trust.

    Returns
    -------
    dict
        Contents of explain.json.

    Raises
    ------
    FileNotFoundError
        If the folder contains no run.
    ValueError
        If no organism was born to recorded parents, or a tick is invalid or outside the run.

    Examples
    --------
    >>> from ecs_eco.explain import write_explanation
    >>> from ecs_eco.runs.run import run_to_folder
    >>> manifest = run_to_folder("reflexes", seed=1, ticks=300, out="herd", report=False)
    >>> write_explanation("herd", species="goat", forks=0)["species"]
    ['goat']
    """
    called_with("progress", progress, "done", "forks")
    islands = is_archipelago(Path(run))
    manifest = read_archipelago(Path(run)) if islands else read_manifest(run)
    for at in moments(tick):
        if not isinstance(at, str) and not islands:
            whole_number("tick", at, 0, manifest["done"])
    lineage = Lineage.read(run)
    sweeps, tests = sweeps_and_tests(lineage, species, fdr)
    paths = {name: of.paths for name, of in tests.items()}
    some = [] if islands or not forks else sorted(sweeps, key=lambda sweep: sweep.p)[:MOST]
    options: Which = {"tick": tick, "forks": forks, "learned": learned, "reverse": reverse}
    accounts = accounts_of(run, some, options, how, together, progress)
    told = [accounts.get(id(sweep), Account(sweep)) for sweep in sweeps]
    ticks = lineage.end + 1 - (manifest.get("forked") or {"tick": 0})["tick"]
    summary = [
        *headline(told),
        *opening(sweeps, lineage, ticks, list(paths), islands and bool(forks), bool(some)),
    ]
    if together and some and not with_another(some):
        summary.append("No species has two sweeps whose alleles can be taken out together.")
    contents: dict[str, Any] = {"format": 1, "species": list(paths), "fdr": fdr, "forks": forks}
    found = clean(contents | {"summary": summary, "sweeps": [one.to_json() for one in told]})
    place, name = Path(out or run), manifest.get("title") or manifest.get("world", "a run")
    write_data(place, found, told, paths)
    write_page(place, f"What evolved: {name}", summary, told, lineage, paths, fdr)
    return found


def write_data(
    place: Path, found: dict[str, Any], told: Sequence[Account], paths: Mapping[str, Paths]
) -> None:
    """Write explain.json and the Parquet files into a folder."""
    text = json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False)
    write_text(place / "explain.json", text + "\n")
    inside(place, place / "explain").mkdir(exist_ok=True)
    write_part(frequencies(paths), place / "explain" / "frequencies.parquet")
    effects = [row for one in told for row in one.effects()]
    write_part(pa.Table.from_pylist(effects), place / "explain" / "effects.parquet")


def write_page(
    place: Path,
    title: str,
    summary: Sequence[str],
    told: Sequence[Account],
    lineage: Lineage,
    paths: Mapping[str, Paths],
    fdr: float,
) -> None:
    """Write explain.html and its figures into a folder."""
    sweeps, pictures = [one.sweep for one in told], place / "figures"
    blocks = [f"<h1>{escape(title)}</h1>", verdict(summary, False)]
    blocks += [overview(sweeps), f"<p class='under'>{escape(HOW.format(fdr=fdr))}</p>"] if sweeps else []
    for i, (name, of) in enumerate(paths.items(), 1):  # names in a record may not be file names
        caption = f"Fractions of living {name} by founder, through first parents. Dashed: half of each rise."
        own = [sweep for sweep in sweeps if sweep.species == name]
        if any(allele.kind == "clade" for allele in of.alleles):
            blocks += [
                f"<h2>Clades of {escape(name)}</h2>",
                drawn(figures.clades(of, own), pictures / f"explain-clades-{i}.svg", caption),
            ]
    traits = {
        name: {gene["name"]: gene.get("trait") or "" for gene in genes_in(lineage.genomes.get(name, {}))}
        for name in paths
    }
    for i, one in enumerate(told, 1):
        blocks += section(one, paths[one.sweep.species], traits[one.sweep.species], pictures / f"explain-{i}")
    for i, name in enumerate(paths, 1):
        blocks += bred(lineage, name, pictures / f"explain-selection-{i}")
    write_text(place / "explain.html", page(title, *blocks))


def accounts_of(
    run: Path | str,
    sweeps: Sequence[Sweep],
    which: Which,
    how: Options,
    together: bool,
    progress: Callable[[int, int], None] | None,
) -> dict[int, Account]:
    """Take the alleles of several sweeps, the clearest first, out of a run, with one progress for all of them;
    return the accounts by the sweeps' ids."""
    others = with_another(sweeps) if together else {}
    rest = which["tick"], which["learned"], which["reverse"]
    jobs = [len(jobs_of(sweep, *rest, others.get(id(sweep)))) for sweep in sweeps]
    accounts = {}
    for i, sweep in enumerate(sweeps):

        def show(done: int, _: int, before: int = sum(jobs[:i])) -> None:
            if progress is not None:
                progress(before * which["forks"] + done, sum(jobs) * which["forks"])

        other = others.get(id(sweep))
        accounts[id(sweep)] = account(run, sweep, other=other, progress=show, **which, **how)
    return accounts


def with_another(sweeps: Sequence[Sweep]) -> dict[int, Sweep]:
    """Return the second sweep of each species, by the id of its first, of those that can be taken out."""
    found: dict[int, Sweep] = {}
    for name in dict.fromkeys(sweep.species for sweep in sweeps):
        own = [sweep for sweep in sweeps if sweep.species == name and candidates(sweep)]
        found |= {id(own[0]): own[1]} if len(own) > 1 else {}
    return found


def bred(lineage: Lineage, species: str, place: Path) -> list[str]:
    """Return sections on selection on quantitative genes, and the response; figures are `place`-*.svg."""
    blocks, kept = [], lineage.genomes.get(species, {})
    recorded = (lineage.genome[lineage.species == species] != "").any()
    genes = quantitative(kept) if kept and recorded else []
    for i, gene in enumerate(genes[:QUANTITATIVE], 1):
        found = lineage.breeding(species, gene)
        rows = [[WORDS[name], interval(x)] for name, x in found.whole.estimates.items() if name in WORDS]
        caption = (
            f"Newborns of {species} by tick of birth, selection and response, and realized heritability."
        )
        blocks += [
            f"<h2>Selection on {escape(gene)} ({escape(species)})</h2>",
            table(["estimate for the whole run", "value (95% interval)"], rows),
            drawn(responses(found), place.with_name(f"{place.name}-{i}.svg"), caption),
        ]
    if (more := len(genes) - QUANTITATIVE) > 0:
        blocks.append(
            f"<p class='under'>Quantitative genes not shown: {more}. Lineage.breeding examines any of them.</p>"
        )
    return blocks


def headline(told: Sequence[Account]) -> list[str]:
    """Return the clearest sweep and the effect of its allele on the number of young, if there is a sweep."""
    lines = []
    for one in sorted(told, key=lambda one: one.sweep.p)[:1]:
        lines.append(rose(one.sweep))
        births = one.taken[0][1].effect("births") if one.taken else None
        if births is not None and not np.isnan(births.low):
            lines.append(f"Taking it out changes the number of young of its carriers by {signed(births)}.")
    return lines


def opening(
    sweeps: Sequence[Sweep], lineage: Lineage, ticks: int, names: Sequence[str], unforked: bool, forked: bool
) -> list[str]:
    """Return the first sentences of the page."""
    many = "1 sweep was" if len(sweeps) == 1 else f"{len(sweeps) or 'no'} sweeps were"
    lines = [
        f"In {ticks:,} ticks, {many} found in {in_words(names)}. In a sweep, an allele rises by at least "
        f"{100 * LEAST:.0f} percentage points and by more than drift allows."
    ]
    if bare := [name for name in names if not lineage.genomes.get(name)]:
        lines.append(
            f"No genomes of {in_words(bare)} are recorded, so only the clades of founders were followed. To follow "
            "genes, give the species a section “genome”."
        )
    if forked and len(sweeps) > MOST:
        lines.append(f"Only alleles of the {MOST} clearest sweeps were taken out in forks.")
    if unforked:
        lines.append("Islands cannot be forked, so no allele was taken out.")
    return lines


def overview(sweeps: Sequence[Sweep]) -> str:
    """Return a table of all sweeps."""
    head = [
        *("allele", "species", "kind", "before the rise", "at the end of the run", "begin", "half", "end"),
        *("s per generation", "alleles with it", "q"),
    ]
    return table(
        head,
        [
            [
                s.lead.name,
                s.species,
                s.kind,
                f"{s.first:.0%}",
                f"{s.last:.0%}",
                *(f"{t:,}" for t in (s.begin, s.half, s.end)),
            ]
            + [
                f"{number(s.s, 2)} ({number(s.interval[0], 2)} to {number(s.interval[1], 2)})",
                len(s.linked),
                number(s.q, 2),
            ]
            for s in sweeps
        ],
    )


def section(one: Account, paths: Paths, traits: Mapping[str, str], place: Path) -> list[str]:
    """Return the heading, sentences and figures of a sweep; figures are `place`-*.svg."""
    sweep = one.sweep
    caption = (
        "Frequency over time. Dashed: begin, half and end of the rise. The band of drift begins with it."
    )
    blocks = [
        f"<h2>{escape(sweep.species)}: {escape(sweep.lead.name)}</h2>",
        *(f"<p>{escape(line)}</p>" for line in one.sentences()),
        drawn(figures.frequency(sweep, paths), place.with_name(f"{place.name}-frequency.svg"), caption),
    ]
    colour = f"&colour=gene:{sweep.lead.gene}" if sweep.lead.gene else ""
    there = (
        "To watch it, run ecs-eco watch on the folder and choose the sweep in the tab Why, or add "
        f"#tick={sweep.half}{colour} to the address."
    )
    blocks.append(f"<p class='under'>{escape(there)}</p>")
    if one.taken:
        way = (
            "From the allele to the number of young: the action and the cause of death that change most. The forks "
            "measure each change; that one causes the next is plausible, but not tested."
        )
        blocks += [
            births_of(one),
            drawn(figures.effects(one), place.with_name(f"{place.name}-effects.svg"), EFFECTS),
            drawn(
                figures.way(one, traits.get(sweep.lead.gene, "")),
                place.with_name(f"{place.name}-way.svg"),
                way,
            ),
        ]
    return blocks


def births_of(one: Account) -> str:
    """Return a table of the effects of all comparisons on the number of young."""
    head = ["change", "tick", "copies changed", "number of young, unchanged", "difference (95% interval)"]
    rows = [
        [row["change"], f"{row['tick']:,}", row["dose"] or "any", number(row["control"], 2)]
        + [interval([row["effect"], row["low"], row["high"]])]
        for row in one.effects()
        if row["measure"] == "births"
    ]
    return table(head, rows)


def frequencies(paths: Mapping[str, Paths]) -> pa.Table:
    """Return the frequencies of all alleles as a long table."""
    parts = []
    for of in paths.values():
        for j, allele in enumerate(of.alleles):
            columns = {"tick": of.ticks, "frequency": of.p[:, j], "copies": of.n}
            words = {key: np.repeat(value, len(of.ticks)) for key, value in asdict(allele).items()}
            parts.append(pa.table({**words, **columns}))
    return pa.concat_tables(parts) if parts else pa.table({"tick": pa.array([], pa.int64())})
