"""A diagnosis in short plain sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ecs_eco.analysis.page import number
from ecs_eco.analysis.runs import DIED
from ecs_eco.analysis.why.case import Case
from ecs_eco.analysis.why.diagnose import VERDICTS

Blocks = dict[str, list[str]]
LIMITED = {
    "food": "want of food", "predators": "being eaten", "poison": "poison in its food", "age": "old age",
    "room": "births that failed though it was fed (room, mates)", "removal": "interventions", "surroundings": "its surroundings",
}  # fmt: skip


def sentences(case: Case, found: Mapping[str, Any]) -> Blocks:
    """What to say of a run: headings and their sentences, in order."""
    told: Blocks = {"What happened": [headline(case, found), *happened(case, found)], "Why": list(chain(case, found))}
    told["Energy"] = [line for s in found["energy"] if (line := energy(s, found["energy"][s]))]
    told["What limited whom"] = [phase(case, s, p) for s, phases in found["phases"].items() for p in phases]
    told["What the animals did"] = [line for s, both in found["conduct"].items() for line in conduct(s, *both)]
    told["What to turn"] = [turn(a) for a in found["parameters"]]
    return {head: lines for head, lines in told.items() if lines}


def headline(case: Case, found: Mapping[str, Any]) -> str:
    """The verdict in one sentence."""
    series, what = case.series, found["verdict"]
    if not len(series.ticks):
        return "The run has no ticks."
    if what == "healthy":
        said = f"Nothing died out in {len(series.ticks):,} ticks."
    elif what == "nobody":
        said = "Nobody lived at the end of any tick."
    else:
        said = f"{what.capitalize()} ({found['species']}): {VERDICTS[what]}."
        sure = f" Confidence {found['confidence']:.0%}"
        other = found["runner_up"]
        said += sure + (f"; else {other['verdict']} ({other['confidence']:.0%})." if other else ".")
    if not series.manifest.get("finished", True):
        said += f" The run was stopped at tick {series.ticks[-1]:,} of {series.manifest.get('ticks', 0):,}."
    return said


def happened(case: Case, found: Mapping[str, Any]) -> Iterator[str]:
    """Who died out, who came near, who is well, and what was done from outside."""
    for f in found["fell"]:
        yield _ended(f)
        if f["deaths"]:
            yield _died_of(case, f)
    for s, low in found["lowest"].items():
        if s not in {f["species"] for f in found["fell"]}:
            near = f"{s} came near: {low['n']:,} were left" if low["near"] else f"{s} never fell below {low['n']:,}"
            yield f"{near} (tick {low['tick']:,}); {low['mean']:,.0f} on average, {low['end']:,} at the end."
    done = found["interventions"]
    if done:
        kinds = ", ".join(f"{k} ({v:,}×)" if v > 1 else k for k, v in done.items())
        yield f"Somebody intervened: {kinds}."


def _ended(f: Mapping[str, Any]) -> str:
    if f["extinct"]:
        return f"{f['species']} died out at tick {f['tick']:,}; at tick {f['since']:,} there had been {f['from']:,}."
    return f"{f['species']} had as good as died out at tick {f['tick']:,}; at tick {f['since']:,} there had been {f['from']:,}."


def _died_of(case: Case, f: Mapping[str, Any]) -> str:
    """The causes of death as the record has them."""
    span = slice(int(np.searchsorted(case.series.ticks, f["since"])), int(np.searchsorted(case.series.ticks, f["tick"])) + 1)
    i = case.series.index(f["species"])
    counts = {c: case.series.columns[DIED + c][span, i].sum() for c in case.series.causes}
    total = sum(counts.values()) or 1
    shares = [f"{k / total:.0%} {c}" for c, k in sorted(counts.items(), key=lambda x: -x[1]) if k / total >= 0.01]
    return f"Of {f['deaths']:,} deaths since then: {', '.join(shares)}. {f['births']:,} were born."


def chain(case: Case, found: Mapping[str, Any]) -> Iterator[str]:
    """The links from each fall to what was behind it."""
    for f in found["fell"]:
        for what, share in f["causes"].items():
            if share >= 0.15:
                yield _link(f, what, share)


def _link(f: Mapping[str, Any], what: str, share: float) -> str:
    s, (kind, _, other) = f["species"], what.partition(": ")
    food = {x["eats"]: x for x in f["food"]}
    young = f["newborn"]
    part = f"{s} ({share:.0%} of its fall)"
    if kind == "eaten":
        return f"{part}: {other} ate {s} faster than they were born."
    if kind == "scarce":
        x = food[other]
        left = f"While they starved, {x['left']:.0%} of the {x['full']:,.0f} {other} were left"
        return f"{part}: hunger for want of {other}. {left}; all of them would have fed {number(x['feeds'], 2)} times what {s} burn."
    if kind == "amid plenty":
        fed = max((x["feeds"] for x in food.values()), default=0.0)
        rate = "at the rate at which they found and caught it"
        return f"{part}: hunger though there was food. All of it would have fed {number(fed, 2)} times what {s} burn, {rate}."
    if kind == "newborns starve":
        lasts = f"What they were given lasts {number(young['lasts'], 2)} ticks; a meal comes every {number(young['meal_every'], 2)}"
        return f"{part}: newborn starved, {young['starved_young']:.0%} of {young['births']:,.0f}. {lasts}."
    if kind == "poisoned":
        return f"{part}: what they ate was deadly, or cost more energy than they could spare."
    if kind == "unreplaced":
        heirs = "" if f["offspring"] is None else f" One that lacks nothing bears {number(f['offspring'], 2)} young in its life."
        return f"{part}: the dead were not replaced; {f['births']:,} births against {f['deaths']:,} deaths.{heirs}"
    return f"{part}: {LIMITED.get({'removed': 'removal'}.get(kind, kind), kind)}."


def energy(species: str, flows: Mapping[str, float]) -> str:
    """Where the energy of a species went."""
    total = sum(max(flows[k], 0.0) for k in ("burnt", "given", "lost"))
    if total <= 0 or flows["taken_in"] == flows["burnt"] == 0:
        return ""
    words = {"burnt": "burnt", "given": "given to newborn", "lost": "lost with the dead"}
    parts = ", ".join(f"{max(flows[k], 0) / total:.0%} {word}" for k, word in words.items())
    return f"{species}: {number(flows['taken_in'])} taken in per head and tick, {number(flows['burnt'])} burnt. Of what went out: {parts}."


def phase(case: Case, species: str, p: Mapping[str, Any]) -> str:
    """What limited a species in one phase."""
    named = LIMITED | ({} if case.is_animal(species) else {"room": "want of room"})
    limit = f"limited by {named[p['limit']]} ({p['share']:.0%})" if p["limit"] else "nothing held it back"
    a, b = p["n"]
    return f"{species}, ticks {p['from']:,} to {p['to']:,}: {p['trend']} from {a:,} to {b:,}, {limit}."


def conduct(species: str, before: Mapping[str, Any], during: Mapping[str, Any]) -> Iterator[str]:
    """What a species did, over the run or before and during its fall."""
    if not before:
        return
    both = (before, during) if during else (before,)
    said = [f"{' then '.join(number(x['meals'] * 100, 2) for x in both)} meals in 100 ticks"] if before["food"] else []
    if before.get("effort") is not None:
        share = " then ".join(f"{x['effort']:.0%}" for x in both if x.get("effort") is not None)
        said.append(f"moving cost {share} of what its dearest gait costs")
    for word in ("enemies", "food"):
        for other in before[word]:
            far = [x[word].get(other) for x in both]
            told = [f"{number(d['mean'], 2)} m ({number(d['to_chance'], 2)} × chance)" for d in far if d]
            if told:
                said.append(f"{' then '.join(told)} to the nearest {other}")
    if said:
        yield f"{species}{' (before, then in its fall)' if during else ''}: {'; '.join(said)}."


def turn(a: Mapping[str, Any]) -> str:
    """A value of the world file and which way to turn it."""
    value = a["value"]
    if isinstance(value, bool | int | float):
        value = str(value).lower() if isinstance(value, bool) else number(value)
    return f"{a['key']} = {value}: {a['turn']} ({a['effect']})."
