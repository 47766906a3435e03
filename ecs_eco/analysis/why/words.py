"""A diagnosis in short plain sentences."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ecs_eco.analysis.extinction import decline
from ecs_eco.analysis.page import number
from ecs_eco.analysis.runs import DIED
from ecs_eco.analysis.why.case import Case
from ecs_eco.analysis.why.diagnose import VERDICTS

Blocks = dict[str, list[str]]
LIMITED = {
    "food": "want of food",
    "predators": "being eaten",
    "poison": "poison in its food",
    "age": "old age",
    "room": "births that failed though it was fed (room, mates)",
    "removal": "interventions",
    "surroundings": "its surroundings",
}


def sentences(case: Case, findings: Mapping[str, Any]) -> Blocks:
    """The text on a run: headings and their sentences, in order."""
    blocks: Blocks = {
        "What happened": [headline(case, findings), *happened(case, findings)],
        "Why": list(chain(case, findings)),
    }
    blocks["Energy"] = [line for s in findings["energy"] if (line := energy(s, findings["energy"][s]))]
    blocks["What limited whom"] = [
        phase(case, s, p) for s, phases in findings["phases"].items() for p in phases
    ]
    blocks["What the animals did"] = [
        line for s, both in findings["conduct"].items() for line in conduct(s, *both)
    ]
    blocks["What to turn"] = [turn(a) for a in findings["parameters"]]
    return {head: lines for head, lines in blocks.items() if lines}


def headline(case: Case, findings: Mapping[str, Any]) -> str:
    """The verdict in one sentence."""
    series, verdict = case.series, findings["verdict"]
    if not len(series.ticks):
        return "The run has no ticks."
    if verdict == "healthy":
        late = "" if series.persisted else " after the first tick"
        text = f"Nothing died out{late} in {len(series.ticks):,} tick{'s' * (len(series.ticks) != 1)}."
    elif verdict == "nobody":
        text = "Nobody lived at the end of any tick."
    else:
        text = f"{verdict.capitalize()} ({findings['species']}): {VERDICTS[verdict]}."
        sure = f" Confidence {findings['confidence']:.0%}"
        other = findings["runner_up"]
        text += sure + (f"; else {other['verdict']} ({other['confidence']:.0%})." if other else ".")
    if not series.manifest.get("finished", True):
        done, wanted = series.ticks[-1] + 1, series.manifest.get("ticks", 0)
        text += f" The run was stopped at tick {done:,} of {wanted:,}."
    return text


def happened(case: Case, findings: Mapping[str, Any]) -> Iterator[str]:
    """Which species died out, came near, or did well, and which interventions there were."""
    for f in findings["fell"]:
        yield _ended(f)
        if f["deaths"]:
            yield _died_of(case, f)
    for s, low in findings["lowest"].items():
        if not low["mean"]:
            end = decline(case.series, s)
            yield f"{s} died out in the first tick: {end.shares() if end else 'it was never there'}."
        elif s not in {f["species"] for f in findings["fell"]}:
            near = (
                f"{s} came near: {low['n']:,} were left"
                if low["near"]
                else f"{s} never fell below {low['n']:,}"
            )
            yield f"{near} (tick {low['tick']:,}); {low['mean']:,.0f} on average, {low['end']:,} at the end."
    done = findings["interventions"]
    if done:
        kinds = ", ".join(f"{k} ({v:,}×)" if v > 1 else k for k, v in done.items())
        yield f"Somebody intervened: {kinds}."


def _ended(f: Mapping[str, Any]) -> str:
    if f["extinct"]:
        return (
            f"{f['species']} died out at tick {f['tick']:,}; "
            f"at tick {f['since']:,} there had been {f['from']:,}."
        )
    return (
        f"{f['species']} had nearly died out at tick {f['tick']:,}; "
        f"at tick {f['since']:,} there had been {f['from']:,}."
    )


def _died_of(case: Case, f: Mapping[str, Any]) -> str:
    """The recorded causes of death."""
    span = slice(
        int(np.searchsorted(case.series.ticks, f["since"])),
        int(np.searchsorted(case.series.ticks, f["tick"])) + 1,
    )
    i = case.series.index(f["species"])
    counts = {c: case.series.columns[DIED + c][span, i].sum() for c in case.series.causes}
    total = sum(counts.values()) or 1
    shares = [
        f"{k / total:.0%} {c}" for c, k in sorted(counts.items(), key=lambda x: -x[1]) if k / total >= 0.01
    ]
    refused = case.flow(f["species"], "refused")[span].sum()
    more = f"; max_count left no room for {refused:,.0f} more" if refused else ""
    return f"Of {f['deaths']:,} deaths since then: {', '.join(shares)}. {f['births']:,} were born{more}."


def chain(case: Case, findings: Mapping[str, Any]) -> Iterator[str]:
    """The links from each fall to its causes."""
    for f in findings["fell"]:
        for cause, share in f["causes"].items():
            if share >= 0.15:
                yield _link(f, cause, share)


def _link(f: Mapping[str, Any], cause: str, share: float) -> str:
    s, (kind, _, other) = f["species"], cause.partition(": ")
    food = {x["eats"]: x for x in f["food"]}
    young = f["newborn"]
    part = f"{s} ({share:.0%} of its fall)"
    if kind == "eaten":
        return f"{part}: {other} ate {s} faster than they were born."
    if kind == "scarce":
        x = food[other]
        left = f"While they starved, {x['left']:.0%} of the {x['full']:,.0f} {other} were left"
        return (
            f"{part}: hunger for lack of {other}. {left}; "
            f"all of them would have fed {number(x['feeds'], 2)} times what {s} burn."
        )
    if kind == "amid plenty":
        fed = max((x["feeds"] for x in food.values()), default=0.0)
        rate = "at the rate at which they found and caught it"
        worth = " and ".join(f"{number(x['gain'], 2)} from each {name}" for name, x in food.items())
        return (
            f"{part}: hunger though there was food. All of it would have fed {number(fed, 2)} times what "
            f"{s} burn, {rate}{f', with {worth}' if worth else ''}."
        )
    if kind == "energy ran out":
        budget = f["budget"]
        return (
            f"{part}: they took in {number(budget['taken_in'], 2)} per head and tick and burnt "
            f"{number(budget['burnt'], 2)}. They eat nobody: they live on light, parents or reactions."
        )
    if kind == "newborns starve":
        lasts = (
            f"Their initial energy lasts {number(young['lasts'], 2)} ticks; "
            f"a meal comes every {number(young['meal_every'], 2)}"
        )
        return f"{part}: newborn starved, {young['starved_young']:.0%} of {young['births']:,.0f}. {lasts}."
    if kind == "poisoned":
        return f"{part}: what they ate was deadly, or cost more energy than they could spare."
    if kind == "unreplaced":
        heirs = (
            ""
            if f["offspring"] is None
            else f" A well-fed one has {number(f['offspring'], 2)} offspring in its life."
        )
        return (
            f"{part}: the dead were not replaced; "
            f"{f['births']:,} births against {f['deaths']:,} deaths.{heirs}"
        )
    return f"{part}: {LIMITED.get({'removed': 'removal'}.get(kind, kind), kind)}."


def energy(species: str, flows: Mapping[str, float]) -> str:
    """The energy budget of a species."""
    total = sum(max(flows[k], 0.0) for k in ("burnt", "given", "lost"))
    if total <= 0 or flows["taken_in"] == flows["burnt"] == 0:
        return ""
    words = {"burnt": "burnt", "given": "given to newborn", "lost": "lost with the dead"}
    parts = ", ".join(f"{max(flows[k], 0) / total:.0%} {word}" for k, word in words.items())
    return (
        f"{species}: {number(flows['taken_in'])} taken in per head and tick, "
        f"{number(flows['burnt'])} burnt. Outflows: {parts}."
    )


def phase(case: Case, species: str, p: Mapping[str, Any]) -> str:
    """What limited a species in one phase."""
    named = LIMITED | ({} if case.is_animal(species) else {"room": "want of room"})
    limit = "nothing limited it"
    if p["limit"]:
        limit = (
            f"mostly by {named[p['limit']]} ({p['share']:.0%} of what rose)"
            if p["by"] == "rise"
            else f"limited by {named[p['limit']]} ({p['share']:.0%})"
        )
    a, b = p["n"]
    return f"{species}, ticks {p['from']:,} to {p['to']:,}: {p['trend']} from {a:,} to {b:,}, {limit}."


def conduct(species: str, before: Mapping[str, Any], during: Mapping[str, Any]) -> Iterator[str]:
    """Behaviour of a species, over the run or before and during its fall."""
    if not before:
        return
    both = (before, during) if during else (before,)
    parts = (
        [f"{' then '.join(number(x['meals'] * 100, 2) for x in both)} meals in 100 ticks"]
        if before["food"]
        else []
    )
    if before.get("effort") is not None:
        share = " then ".join(f"{x['effort']:.0%}" for x in both if x.get("effort") is not None)
        parts.append(f"moving cost {share} of its costliest gait")
    for word in ("enemies", "food"):
        for other in before[word]:
            far = [x[word].get(other) for x in both]
            distances = [f"{number(d['mean'], 2)} m ({number(d['to_chance'], 2)} × chance)" for d in far if d]
            if distances:
                parts.append(f"{' then '.join(distances)} to the nearest {other}")
    if parts:
        yield f"{species}{' (before, then in its fall)' if during else ''}: {'; '.join(parts)}."


def turn(a: Mapping[str, Any]) -> str:
    """A value of the world file and the direction to change it."""
    value = a["value"]
    if isinstance(value, bool | int | float):
        value = str(value).lower() if isinstance(value, bool) else number(value)
    return f"{a['key']} = {value}: {a['turn']} ({a['effect']})."
