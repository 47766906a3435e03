"""Explain a run folder: why.json for machines, why.html and figures/why.svg for people."""

import json
import math
from collections import Counter
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis import matter
from ecs_eco.analysis.compare import clean
from ecs_eco.analysis.page import drawn, page, table, verdict, write_text
from ecs_eco.analysis.why.advice import advise
from ecs_eco.analysis.why.case import Case
from ecs_eco.analysis.why.diagnose import diagnose
from ecs_eco.analysis.why.figure import draw
from ecs_eco.analysis.why.limits import phases
from ecs_eco.analysis.why.words import sentences
from ecs_eco.config.models.interventions import describe

MOST = 2000  # organisms of one snapshot from which distances are measured


def conduct(case: Case, species: str, first: int, last: int) -> dict[str, Any]:
    """Behaviour of a species in rows first … last − 1, per head and tick; None where it was not recorded."""
    span = slice(first, last)
    heads = float(case.series.of(species)[span].sum())
    if not heads:
        return {}
    per = {name: float(case.flow(species, name)[span].sum() / heads) for name in ("taken_in", "burnt")}
    return {
        "meals": float(case.meals(species)[span].sum() / heads),
        "intake": per["taken_in"],
        "burnt": per["burnt"],
        "effort": effort(case, species, per["burnt"]),
        "enemies": {e: distance(case, species, e, first, last) for e in case.eaters(species)},
        "food": {f.eats: distance(case, species, f.eats, first, last) for f in case.diet(species)},
    }


def effort(case: Case, species: str, burnt: float) -> float | None:
    """The cost of locomotion, as a share of using the costliest gait all the time; None if moving is free."""
    values, dt = case.of(species), case.series.dt
    costs = ((values.get("locomotion") or {}).get("cost") or {}).values()
    basal = (values.get("metabolism") or {}).get("basal", 0.0)
    dearest = max(costs, default=0.0)
    return float(np.clip((burnt / dt - basal) / dearest, 0, 1)) if dearest else None


def distance(case: Case, species: str, other: str, first: int, last: int) -> dict[str, float] | None:
    """Mean distance [m] from a species to the nearest of another over the snapshots between two rows, and as
    a multiple of chance (Clark & Evans 1954): above 1 they avoid each other. None if no snapshot has both."""
    a, b = case.snapshots.get(species), case.snapshots.get(other)
    size = case.config.get("space", {}).get("size")
    if a is None or b is None or not size:
        return None
    ticks = case.series.ticks
    low, high = ticks[first], ticks[min(last, len(ticks)) - 1]
    common = [t for t in np.intersect1d(a["tick"], b["tick"]) if low <= t <= high]
    means, ratios = [], []
    for t in common[:: max(1, len(common) // 20)]:
        here, there = (_places(table, t, len(size)) for table in (a, b))
        nearest = _nearest(
            here[:: max(1, len(here) // MOST)],
            there,
            size,
            case.config["space"].get("edges", "torus") == "torus",
        )
        means.append(nearest)
        ratios.append(nearest / chance(len(there), size))
    return {"mean": float(np.mean(means)), "to_chance": float(np.mean(ratios))} if means else None


def chance(n: int, size: list[float]) -> float:
    """Expected distance [m] to the nearest of n at random places: 1 / (2 √density) in a plane,
    Γ(4/3) (3 / 4π density)^⅓ in a volume."""
    density = n / math.prod(size)
    return (
        0.5 / math.sqrt(density)
        if len(size) == 2
        else math.gamma(4 / 3) * (3 / (4 * math.pi * density)) ** (1 / 3)
    )


def _places(table: Mapping[str, np.ndarray], tick: int, dims: int) -> np.ndarray:
    rows = table["tick"] == tick
    return np.stack([table[axis][rows] for axis in "xyz"[:dims]], 1).astype(float)


def _nearest(here: np.ndarray, there: np.ndarray, size: list[float], torus: bool) -> float:
    """Mean distance to the nearest; a torus has no edges in the plane, a volume a floor and a surface."""
    from scipy.spatial import cKDTree

    if not torus:
        return float(cKDTree(there).query(here)[0].mean())
    box = [*size[:2], *(4 * s for s in size[2:])]  # the third axis does not wrap
    tree = cKDTree(there % box, boxsize=box)
    return float(tree.query(here % box)[0].mean())


FLOWS = ("taken_in", "burnt", "given", "lost")
NEAR = 0.05  # of a species' mean: at fewer it came near extinction


def explain(case: Case) -> dict[str, Any]:
    """All findings on a run, as in why.json."""
    findings = diagnose(case)
    ends = {
        f["species"]: (
            int(np.searchsorted(case.series.ticks, f["since"])),
            int(np.searchsorted(case.series.ticks, f["tick"])),
        )
        for f in findings["fell"]
    }
    rows = len(case.series.ticks)
    findings["phases"] = {
        s: phases(case, s) for s in case.species if case.series.present[case.series.index(s)]
    }
    findings["energy"] = {s: _flows(case, s) for s in findings["phases"]}
    findings["lowest"] = {s: _lowest(case, s) for s in findings["phases"]}
    findings["conduct"] = {
        s: (conduct(case, s, 0, max(ends[s][0], 1)), conduct(case, s, *ends[s]))
        if s in ends
        else (conduct(case, s, 0, rows), {})
        for s in findings["phases"]
        if case.is_animal(s)
    }
    findings["interventions"] = dict(
        Counter(describe(done) for _, done in case.series.manifest.get("intervened") or ())
    )
    held = {
        species: max(listed, key=lambda p: p["to"] - p["from"])["limit"]
        for species, listed in findings["phases"].items()
        if listed and case.is_animal(species)
    }
    findings["parameters"] = advise(case, findings, held)
    return {"format": 1, **findings}


def write_why(run: Path | str, out: Path | str | None = None) -> dict[str, Any]:
    """Explain a run folder in why.json, why.html and figures/why.svg there, or in `out`; return the content
    of why.json. FileNotFoundError where it holds no run, RecordingError where a file is damaged."""
    folder, case = Path(out or run), Case.read(run)
    findings = explain(case)
    sections = sentences(case, findings)
    if (ledger := matter.read(run)) is not None:
        findings["matter"] = sections["Matter"] = matter.told(ledger)
    findings = clean(findings | {"sentences": sections})
    write_text(
        folder / "why.json", json.dumps(findings, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    )
    title = f"Why: {case.series.manifest.get('title') or case.series.manifest.get('world', 'a run')}"
    blocks = [
        f"<h1>{escape(title)}</h1>",
        verdict(sections.pop("What happened"), findings["verdict"] != "healthy"),
    ]
    if len(case.series.ticks):
        blocks.append(drawn(draw(case, findings), folder / "figures" / "why.svg", CAPTION))
    for head, lines in sections.items():
        blocks += [
            f"<h2>{head}</h2>",
            _turns(findings["parameters"]) if head == "What to turn" else _list(lines),
        ]
    write_text(folder / "why.html", page(title, *blocks))
    return findings


CAPTION = (
    "Numbers on a log scale (a cross is the end of a species), causes of death as shares of all deaths at a "
    "time, and energy per head and tick: taken in above zero, burnt, given and lost below."
)


def _flows(case: Case, species: str) -> dict[str, float]:
    heads = max(float(case.series.of(species).sum()), 1.0)
    return {name: float(case.flow(species, name).sum() / heads) for name in FLOWS}


def _lowest(case: Case, species: str) -> dict[str, Any]:
    n = case.series.of(species)
    here = np.flatnonzero(n)
    at = int(here[0] + n[here[0] :].argmin()) if here.size else 0  # it was gone within its first tick
    low, mean = int(n[at]), float(n.mean())
    return {
        "n": low,
        "tick": int(case.series.ticks[at]),
        "mean": mean,
        "end": int(n[-1]),
        "near": low < max(3, NEAR * mean),
    }


def _list(lines: list[str]) -> str:
    return "<ul>" + "".join(f"<li>{escape(x)}</li>" for x in lines) + "</ul>"


def _turns(advice: list[dict[str, Any]]) -> str:
    rows = [[a["key"], a["value"], a["turn"], a["effect"]] for a in advice]
    return table(["value of the world file", "now", "turn", "what it does"], rows)
