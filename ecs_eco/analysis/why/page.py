"""Explain a run in plain sentences: why.json for programs, why.html with a figure for people."""

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis import matter
from ecs_eco.analysis.compare import clean
from ecs_eco.analysis.extinction import decline
from ecs_eco.analysis.page import bullets, drawn, number, page, table, verdict, write_text
from ecs_eco.analysis.runs import DIED
from ecs_eco.analysis.why.advice import advise
from ecs_eco.analysis.why.case import Case
from ecs_eco.analysis.why.diagnose import VERDICTS, diagnose
from ecs_eco.analysis.why.figure import OUT, draw
from ecs_eco.analysis.why.limits import phases
from ecs_eco.config.models.interventions import describe

Blocks = dict[str, list[str]]
LIMITED = {
    "food": "lack of food",
    "predators": "animals that eat it",
    "poison": "poison in its food",
    "age": "old age",
    "room": "births that failed despite enough food (lack of space or mates)",
    "removal": "interventions",
    "surroundings": "environmental conditions",
}


def sentences(case: Case, findings: Mapping[str, Any]) -> Blocks:
    """Return the text on a run as headings with their sentences, in order."""
    blocks: Blocks = {
        "What happened": [headline(case, findings), *happened(case, findings)],
        "Why": list(chain(case, findings)),
        "Energy": [line for s in findings["energy"] if (line := energy(s, findings["energy"][s]))],
        "What limited each species": [phase(case, s, p) for s, of in findings["phases"].items() for p in of],
        "Behavior of the animals": [
            x for s, both in findings["conduct"].items() for x in conducted(s, *both)
        ],
        "What to change": [turn(a) for a in findings["parameters"]],
    }
    return {head: lines for head, lines in blocks.items() if lines}


def headline(case: Case, findings: Mapping[str, Any]) -> str:
    """Return the verdict in one sentence."""
    series, verdict = case.series, findings["verdict"]
    if not len(series.ticks):
        return "The run has no ticks."
    if verdict == "healthy":
        late = "" if series.persisted else " after the first tick"
        text = f"No species died out{late} in {len(series.ticks):,} tick{'s' * (len(series.ticks) != 1)}."
    elif verdict == "nobody":
        text = "No organism was alive at the end of any tick."
    else:
        text = f"{verdict.capitalize()} ({findings['species']}): {VERDICTS[verdict]}."
        sure = f" Confidence: {findings['confidence']:.0%}"
        other = findings["runner_up"]
        text += sure + (f"; alternatively {other['verdict']} ({other['confidence']:.0%})." if other else ".")
    if not series.manifest.get("finished", True):
        done, wanted = series.ticks[-1] + 1, series.manifest.get("ticks", 0)
        text += f" The run was stopped at tick {done:,} of {wanted:,}."
    return text


def happened(case: Case, findings: Mapping[str, Any]) -> Iterator[str]:
    """Yield sentences on species that died out, nearly died out or did well, and on interventions."""
    for f in findings["fell"]:
        gone = "died out" if f["extinct"] else "nearly died out"
        yield (
            f"{f['species']} {gone} at tick {f['tick']:,}; at tick {f['since']:,} (the last with at least half of "
            f"the peak) there were {f['from']:,}."
        )
        if f["deaths"]:
            yield _died_of(case, f)
    for s, low in findings["lowest"].items():
        if not low["mean"]:
            end = decline(case.series, s)
            yield f"{s} died out in the first tick: {end.shares()}." if end else f"{s} was never present."
        elif s not in {f["species"] for f in findings["fell"]}:
            near = f"{s} never fell below {low['n']:,}"
            if low["near"]:
                near = f"{s} nearly died out: only {low['n']:,} remained"
            yield f"{near} (tick {low['tick']:,}); {low['mean']:,.0f} on average, {low['end']:,} at the end."
    done = findings["interventions"]
    if done:
        kinds = ", ".join(f"{k} ({v:,}×)" if v > 1 else k for k, v in done.items())
        yield f"Interventions: {kinds}."


def _died_of(case: Case, f: Mapping[str, Any]) -> str:
    """Return a sentence on the recorded causes of death."""
    first, last = np.searchsorted(case.series.ticks, [f["since"], f["tick"]]).tolist()
    span = slice(min(first + 1, last), last + 1)
    counts = {c: case.series.of(f["species"], DIED + c)[span].sum() for c in case.series.causes}
    total, ranked = sum(counts.values()) or 1, sorted(counts.items(), key=lambda x: -x[1])
    shares = [f"{k / total:.0%} {c}" for c, k in ranked if k / total >= 0.01]
    refused = case.flow(f["species"], "refused")[span].sum()
    more = f"; max_count prevented {refused:,.0f} more births" if refused else ""
    return f"Deaths since then: {f['deaths']:,} ({', '.join(shares)}). Births: {f['births']:,}{more}."


def chain(case: Case, findings: Mapping[str, Any]) -> Iterator[str]:
    """Yield sentences that link each decline to its causes."""
    for f in findings["fell"]:
        yield from (_link(f, cause, share) for cause, share in f["causes"].items() if share >= 0.15)


def _link(f: Mapping[str, Any], cause: str, share: float) -> str:
    s, (kind, _, other) = f["species"], cause.partition(": ")
    food = {x["eats"]: x for x in f["food"]}
    young = f["newborn"]
    part = f"{s} ({share:.0%} of its decline)"
    if kind == "eaten":
        return f"{part}: {other} ate {s} faster than {s} reproduced."
    if kind == "scarce":
        x = food[other]
        if not x["full"]:
            return f"{part}: starvation because there was no {other}."
        left = f"While they starved, {x['left']:.0%} of the peak of {x['full']:,.0f} {other} were left"
        return (
            f"{part}: starvation because there was too little {other}. {left}; the peak would "
            f"have covered {number(x['feeds'], 2)} times the energy that {s} burn."
        )
    if kind == "amid plenty":
        fed = max((x["feeds"] for x in food.values()), default=0.0)
        worth = " and ".join(f"{number(x['gain'], 2)} energy from each {name}" for name, x in food.items())
        return (
            f"{part}: starvation despite available food. At the rate at which they found and caught "
            f"food, its peak number would have covered {number(fed, 2)} times the energy that {s} burn"
            f"{f', with {worth}' if worth else ''}."
        )
    if kind == "energy ran out":
        budget = f["budget"]
        return (
            f"{part}: they took in {number(budget['taken_in'], 2)} energy per capita per tick and burned "
            f"{number(budget['burnt'], 2)}. They eat no other species, but live on light, parents or "
            "reactions."
        )
    if kind == "newborns starve":
        lasts = (
            f"Their initial energy lasts {number(young['lasts'], 2)} ticks; they find a meal every "
            f"{number(young['meal_every'], 2)} ticks"
        )
        return f"{part}: {young['starved_young']:.0%} of {young['births']:,.0f} newborns starved. {lasts}."
    if kind == "poisoned":
        return f"{part}: their food was deadly or cost more energy than they could spare."
    if kind == "unreplaced":
        text = f"{part}: deaths were not replaced; {f['births']:,} births for {f['deaths']:,} deaths."
        heirs = f" A well-fed individual has {number(f['offspring'], 2)} offspring in its lifetime."
        return text if f["offspring"] is None else text + heirs
    return f"{part}: {LIMITED.get({'removed': 'removal'}.get(kind, kind), kind)}."


def energy(species: str, flows: Mapping[str, float]) -> str:
    """Return a sentence on the energy budget of a species."""
    total = sum(max(flows[name], 0.0) for name, _, _ in OUT)
    if total <= 0 or flows["taken_in"] == flows["burnt"] == 0:
        return ""
    parts = ", ".join(f"{max(flows[name], 0) / total:.0%} {word}" for name, word, _ in OUT)
    return (
        f"{species}: {number(flows['taken_in'])} taken in per capita per tick, "
        f"{number(flows['burnt'])} burned. Outflows: {parts}."
    )


def phase(case: Case, species: str, p: Mapping[str, Any]) -> str:
    """Return a sentence on a species' limit in one phase."""
    named = LIMITED | ({} if case.is_animal(species) else {"room": "lack of space"})
    limit = "with no limiting factor"
    if p["limit"]:
        mainly, of = ("mainly ", "the increase in ") if p["by"] == "rise" else ("", "")
        limit = f"limited {mainly}by {named[p['limit']]} ({p['share']:.0%} of {of}losses)"
    a, b = p["n"]
    return f"{species}, ticks {p['from']:,} to {p['to']:,}: {p['trend']} from {a:,} to {b:,}, {limit}."


def conducted(species: str, before: Mapping[str, Any], during: Mapping[str, Any]) -> Iterator[str]:
    """Yield a sentence on the behavior of a species over the run, or before and during its decline."""
    if not before:
        return
    both = (before, during) if during else (before,)
    meals = f"{' then '.join(number(x['meals'] * 100, 2) for x in both)} meals per 100 ticks"
    parts = [meals] * bool(before["food"])
    if before.get("effort") is not None:
        share = " then ".join(f"{x['effort']:.0%}" for x in both if x.get("effort") is not None)
        parts.append(f"movement at {share} of the cost of the most expensive gait")
    for word in ("enemies", "food"):
        for other in before[word]:
            far = [x[word].get(other) for x in both]
            distances = [
                f"{number(d['mean'], 2)} m ({number(d['to_chance'], 2)} × the random expectation)"
                for d in far
                if d
            ]
            if distances:
                parts.append(f"{' then '.join(distances)} to the nearest {other}")
    if parts:
        yield f"{species}{' (before, then during its decline)' if during else ''}: {'; '.join(parts)}."


def turn(a: Mapping[str, Any]) -> str:
    """Return a sentence on a value in the world file and the direction in which to change it."""
    value = a["value"]
    if isinstance(value, bool | int | float):
        value = str(value).lower() if isinstance(value, bool) else number(value)
    return f"{a['key']} = {value}: {a['turn']} ({a['effect']})."


MOST = 2000  # maximum number of organisms per snapshot from which distances are measured


def conduct(case: Case, species: str, first: int, last: int) -> dict[str, Any]:
    """Return a species' behavior in rows first … last − 1, per capita per tick, or None if not recorded."""
    span = slice(first, last)
    heads = float(case.series.of(species)[span].sum())
    if not heads:
        return {}
    burnt = float(case.flow(species, "burnt")[span].sum() / heads)
    return {
        "meals": float(case.meals(species)[span].sum() / heads),
        "intake": float(case.flow(species, "taken_in")[span].sum() / heads),
        "burnt": burnt,
        "effort": effort(case, species, burnt),
        "enemies": {e: distance(case, species, e, first, last) for e in case.eaters(species)},
        "food": {f.eats: distance(case, species, f.eats, first, last) for f in case.diet(species)},
    }


def effort(case: Case, species: str, burnt: float) -> float | None:
    """Return the cost of locomotion relative to the most expensive gait, or None if movement is free."""
    values, dt = case.of(species), case.series.dt
    costs = ((values.get("locomotion") or {}).get("cost") or {}).values()
    basal = (values.get("metabolism") or {}).get("basal", 0.0)
    dearest = max(costs, default=0.0)
    return float(np.clip((burnt / dt - basal) / dearest, 0, 1)) if dearest else None


def distance(case: Case, species: str, other: str, first: int, last: int) -> dict[str, float] | None:
    """Return the mean distance [m] to the nearest organism of another species in the snapshots between two rows,
    and its ratio to the random expectation (Clark & Evans 1954): 1 for random positions, more if the species
    avoid each other. None if no snapshot contains both species."""
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
        torus = case.config["space"].get("edges", "torus") == "torus"
        means.append(_nearest(here[:: max(1, len(here) // MOST)], there, size, torus))
        ratios.append(means[-1] / chance(len(there), size))
    return {"mean": float(np.mean(means)), "to_chance": float(np.mean(ratios))} if means else None


def chance(n: int, size: list[float]) -> float:
    """Return the expected distance [m] to the nearest of n random positions in a plane or a volume."""
    density = n / math.prod(size)
    if len(size) == 2:
        return 0.5 / math.sqrt(density)
    return math.gamma(4 / 3) * (3 / (4 * math.pi * density)) ** (1 / 3)


def _places(table: Mapping[str, np.ndarray], tick: int, dims: int) -> np.ndarray:
    rows = table["tick"] == tick
    return np.stack([table[axis][rows] for axis in "xyz"[:dims]], 1).astype(float)


def _nearest(here: np.ndarray, there: np.ndarray, size: list[float], torus: bool) -> float:
    """Return the mean distance from `here` to the nearest of `there`; a torus wraps only horizontally."""
    from scipy.spatial import cKDTree

    if not torus:
        return float(cKDTree(there).query(here)[0].mean())
    box = [*size[:2], *(4 * s for s in size[2:])]  # too high for the third axis to wrap
    tree = cKDTree(there % box, boxsize=box)
    return float(tree.query(here % box)[0].mean())


FLOWS = ("taken_in", *(name for name, _, _ in OUT))
NEAR = 0.05  # fraction of its mean below which a species counts as nearly extinct


def explain(case: Case) -> dict[str, Any]:
    """Return all findings on a run, as stored in why.json.

    Parameters
    ----------
    case : Case
        A run, from `Case.read(folder)`.

    Returns
    -------
    dict
    """
    findings = diagnose(case)
    rows, ticks = len(case.series.ticks), case.series.ticks
    ends = {f["species"]: np.searchsorted(ticks, [f["since"], f["tick"]]).tolist() for f in findings["fell"]}
    findings["phases"] = {s: phases(case, s) for s in case.series.there}
    heads = {s: max(float(case.series.of(s).sum()), 1.0) for s in findings["phases"]}
    findings["energy"] = {
        s: {name: float(case.flow(s, name).sum() / n) for name in FLOWS} for s, n in heads.items()
    }
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
    """Explain what happened in a run and why; write why.json, why.html and figures/why.svg.

    Parameters
    ----------
    run : str or Path
        Folder of a run.
    out : str or Path, optional
        Folder for the files; default: the folder of the run.

    Returns
    -------
    dict
        Contents of why.json: the verdict, what limited each species, and values in the world file that affect
        it.

    Raises
    ------
    FileNotFoundError
        If the folder contains no run.
    RecordingError
        If a file is damaged.

    Examples
    --------
    >>> from ecs_eco.analysis.why import write_why
    >>> from ecs_eco.runs.run import run_to_folder
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=20, out="my-run", report=False)
    >>> write_why("my-run")["verdict"]
    'healthy'
    """
    folder, case = Path(out or run), Case.read(run)
    findings = explain(case)
    sections = sentences(case, findings)
    if (ledger := matter.read(run)) is not None:
        findings["matter"] = sections["Matter"] = matter.told(ledger)
    findings = clean(findings | {"sentences": sections})
    text = json.dumps(findings, indent=1, ensure_ascii=False, allow_nan=False)
    write_text(folder / "why.json", text + "\n")
    title = f"Why: {case.series.manifest.get('title') or case.series.manifest.get('world', 'a run')}"
    blocks = [
        f"<h1>{escape(title)}</h1>",
        verdict(sections.pop("What happened"), findings["verdict"] != "healthy"),
    ]
    if len(case.series.ticks):
        blocks.append(drawn(draw(case, findings), folder / "figures" / "why.svg", CAPTION))
    rows = [[a["key"], a["value"], a["turn"], a["effect"]] for a in findings["parameters"]]
    for head, lines in sections.items():
        turned = table(["key in the world file", "current value", "change", "effect"], rows)
        blocks += [f"<h2>{head}</h2>", turned if head == "What to change" else bullets(lines)]
    write_text(folder / "why.html", page(title, *blocks))
    return findings


CAPTION = (
    "Numbers on a log scale (a cross marks an extinction), causes of death as shares of all deaths at the "
    "time, and energy per capita per tick: intake above zero; energy burned, given and lost below zero."
)


def _lowest(case: Case, species: str) -> dict[str, Any]:
    n = case.series.of(species)
    here = np.flatnonzero(n)
    at = int(here[0] + n[here[0] :].argmin()) if here.size else 0  # 0: it disappeared within its first tick
    low, mean, near = int(n[at]), float(n.mean()), bool(n[at] < max(3, NEAR * n.mean()))
    return {"n": low, "tick": int(case.series.ticks[at]), "mean": mean, "end": int(n[-1]), "near": near}
