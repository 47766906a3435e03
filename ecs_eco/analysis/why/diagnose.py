"""Follow the causes of death to the first of them: who fell, what of, and what had happened to its food or its enemies before.

A species that starved because its food was gone leads on to who ate the food; one that starved amid plenty, aged without heirs, lost
its newborn or was poisoned is itself where it began. Each step has a weight in 0 … 1; the verdict is the heaviest end of the chain.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np

from ecs_eco.analysis.why.case import Case
from ecs_eco.analysis.why.limits import losses, poisoned_share

VERDICTS = {
    "healthy": "nothing died out",
    "overgrazing": "plants were eaten faster than they grow",
    "predators too good": "prey was eaten faster than it breeds",
    "predators too few": "predators could not keep up their numbers though there was prey",
    "newborns starve": "newborn starved before they could feed themselves",
    "poisoned": "food was poisonous",
    "starved amid plenty": "food was there and not found or not caught",
    "too few births": "the old were not replaced though they were fed",
    "removed": "interventions took too many",
    "surroundings": "the surroundings were deadly",
    "nobody": "nobody lived at the end of any tick",
}
FEEDS = (0.9, 1.3)  # intake at the food's full number over what is burnt: hunger amid plenty below, for want of food above
LEFT = (0.95, 0.6)  # food left while they starved, as a share of its full number: no want of it above, certainly want below
GONE = (0.3, 0.1)  # food left: want of it, whatever its full number would have fed
GROWN = (0.6, 0.9)  # intake over burnt at the food's full number: below, those who are grown starve as well
HEIRS = (0.5, 1.0)  # young that one which lacks nothing bears in its life: below, numbers fall whatever happens
HUNGRY = (0.55, 0.8)  # chance that a newborn finds no meal in time: as among others below, a death sentence above
FALLEN = 0.05  # a species at less than this share of its greatest number at the end of a run has as good as died out
Scores = dict[tuple[str, str, str], float]  # (verdict, species whose doing it was, victim): weight


@dataclass(frozen=True)
class Fall:
    """A species' decline: rows of the series from when it last had half its greatest number, to its end."""

    species: str
    first: int
    last: int  # the first row without it, or the row after the last
    extinct: bool


def falls(case: Case) -> list[Fall]:
    """Who died out or has as good as died out at the end, the first first."""
    found = []
    for i, s in enumerate(case.species):
        n = case.series.n[:, i]
        top = n.max(initial=0)
        gone = not np.isnan(case.series.extinct[i])
        if top < 1 or not (gone or n[-1] <= min(FALLEN * top, 10)):
            continue
        last = int(np.flatnonzero(n)[-1]) + 1
        high = np.flatnonzero(n[:last] >= 0.5 * top)
        found.append(Fall(s, min(int(high[-1]), last - 1), last, gone))
    return sorted(found, key=lambda f: (not f.extinct, f.last))


def diagnose(case: Case) -> dict[str, Any]:
    """The verdict on a run, with evidence, confidence 0 … 1 and the runner-up."""
    fallen = falls(case)
    if not fallen:
        return {"verdict": "healthy" if case.series.present.any() else "nobody", "species": None, "victim": None, "confidence": _safety(case), "runner_up": None, "fell": []}
    told = {f.species: f for f in fallen}
    scores = blame(case, fallen[0], told, frozenset())
    total = sum(scores.values()) or 1.0
    ranked = sorted(scores.items(), key=lambda x: -x[1])
    by_verdict: dict[str, float] = defaultdict(float)
    for (verdict, _, _), weight in ranked:
        by_verdict[verdict] += weight / total
    best, *rest = sorted(by_verdict.items(), key=lambda x: -x[1])
    (_, species, victim), _ = next(r for r in ranked if r[0][0] == best[0])
    return {"verdict": best[0], "species": species, "victim": victim, "confidence": best[1],
            "runner_up": {"verdict": rest[0][0], "confidence": rest[0][1]} if rest else None,
            "fell": [_told(case, f, told) for f in fallen]}  # fmt: skip


def blame(case: Case, fall: Fall, told: dict[str, Fall], seen: frozenset[str]) -> Scores:
    """What a fall goes back to, with weights that add up to 1."""
    found: Scores = defaultdict(float)
    s = fall.species
    for what, weight in causes(case, fall).items():
        kind, _, other = what.partition(": ")
        if weight <= 0:
            continue
        if kind == "eaten":
            _taken(case, found, other, s, weight, fall, told)
        elif kind == "scarce":
            _scarce(case, found, other, weight, fall, told, seen | {s})
        elif kind in ("amid plenty", "unreplaced"):
            hunts = any(case.is_animal(f.eats) for f in case.diet(s))
            own = "starved amid plenty" if kind == "amid plenty" else "too few births"
            found["predators too few" if hunts else own, s, s] += weight
        else:
            found[kind, s, s] += weight
    return found


def causes(case: Case, fall: Fall) -> dict[str, float]:
    """What a species fell by, as shares: "eaten: wolf", "scarce: grass", "amid plenty", "newborns starve", "poisoned", "unreplaced", …"""
    s, first, last = fall.species, fall.first, fall.last
    span = slice(first, last + 1)
    dead = {kind: float(case.died(s, kind)[span].sum()) for kind in ("eaten", "starved", "old", "poisoned", "removed", "surroundings")}
    total = sum(dead.values()) or 1.0
    out: dict[str, float] = defaultdict(float)
    for eater in case.eaters(s):
        out[f"eaten: {eater}"] += float(case.eaten(s, eater)[span].sum()) / total
    poison = poisoned_share(case, s, first, last + 1)
    starved = dead["starved"] / total
    out["poisoned"] = dead["poisoned"] / total + starved * poison
    starved *= 1 - poison
    young = newborn(case, fall)
    out["newborns starve"] = starved * young["of_hunger"]
    starved *= 1 - young["of_hunger"]
    out["amid plenty"] = starved
    for food in supply(case, fall):
        out[f"scarce: {food['eats']}"] = starved * food["scarce"]
        out["amid plenty"] -= starved * food["scarce"]
    heirs = min(1.0, young["births"] / max(float(case.died(s, "old")[: last + 1].sum()), 1.0))
    out["newborns starve"] += dead["old"] / total * young["of_births"] * heirs
    out["unreplaced"] = dead["old"] / total * (1 - young["of_births"] * heirs)
    out["removed"], out["surroundings"] = dead["removed"] / total, dead["surroundings"] / total
    barren = 1 - _ramp(offspring(case, s), *HEIRS)
    for what in [w for w in out if not w.startswith(("eaten", "poisoned", "removed", "surroundings", "unreplaced"))]:
        out["unreplaced"] += out[what] * barren
        out[what] *= 1 - barren
    return dict(out)


def offspring(case: Case, species: str) -> float:
    """Young that one which lacks nothing bears in its span of life, by the world file; ∞ where the file sets no rate or no span."""
    way = case.of(species).get("reproduction") or {}
    span = min((x["max"] for x in case.of(species).get("lethal") or () if x["property"] == "age" and x.get("max") is not None), default=np.inf)
    if not way:
        return 0.0
    return float(way["rate"] * way.get("litter", 1) * max(span - way.get("age_min", 0.0), 0.0)) if "rate" in way and span < np.inf else np.inf


def supply(case: Case, fall: Fall) -> list[dict[str, Any]]:
    """What each food was to the fallen: how much was left when they starved, and whether its full number would have fed them.

    `left` is the food while they starved as a share of its greatest number until the end of the fall; `feeds` is the intake at that number over
    what they burnt, at the rate at which they found and caught it; `scarce` the share of their hunger that its fall explains.
    """
    s, span = fall.species, slice(0, fall.last + 1)
    n = case.series.of(s)[span]
    hungry = case.died(s, "starved")[fall.first : fall.last + 1]
    burnt = float(case.flow(s, "burnt")[span].sum() / max(n.sum(), 1.0))
    out = []
    for f in case.diet(s):
        if f.gain <= 0 or f.deadly or f.eats not in case.species:
            continue
        food = case.series.of(f.eats)
        full = float(food[span].max(initial=0.0)) if case.is_animal(f.eats) else float(food.max(initial=0.0))
        now = food[fall.first : fall.last + 1]
        left = float(np.average(now, weights=hungry) if hungry.sum() else now.mean()) / max(full, 1.0)
        caught = float(case.eaten(f.eats, s)[span].sum() / max((n * food[span]).sum(), 1.0))  # by one, of one, in a tick
        out.append({"eats": f.eats, "left": left, "caught": caught, "intake": caught * full * f.gain, "full": full})
    intake = sum(f["intake"] for f in out)
    feeds = intake / burnt if burnt else np.inf
    for f in out:
        f["feeds"] = feeds
        part = f["intake"] / intake if intake else 1 / len(out)
        f["scarce"] = part * _ramp(f["left"], *LEFT) * max(_ramp(feeds, *FEEDS), _ramp(f["left"], *GONE))
    return out


def _ramp(x: float, low: float, high: float) -> float:
    """0 at `low`, 1 at `high`, even between."""
    return float(np.clip((x - low) / (high - low), 0, 1))


def newborn(case: Case, fall: Fall) -> dict[str, float]:
    """How newborn fared until the end of a fall.

    `births`; `starved_young`, the share of them that starved before they could have had more than one meal; how long a newborn `lasts` on
    what it was given, and `meal_every` how many ticks a meal came when food was at its most. `of_births` and `of_hunger`: what share of
    the births came to nothing, and of those who starved in the fall were newborn, because they could not last until a first meal.
    """
    s, span = fall.species, slice(0, fall.last + 1)
    births, found = float(case.flow(s, "births")[span].sum()), case.deaths.get(s)
    given = float((case.of(s).get("reproduction") or {}).get("energy_given", 0.0))
    burnt = float(case.flow(s, "burnt")[span].sum() / max(case.series.of(s)[span].sum(), 1))
    out = {"births": births, "starved_young": 0.0, "lasts": np.nan, "meal_every": np.nan, "of_births": 0.0, "of_hunger": 0.0}
    if not births or not burnt or not given or found is None:
        return out
    dt, foods = case.series.dt, supply(case, fall)
    limit = 1.5 * (given + max((f.gain for f in case.diet(s)), default=0.0)) / burnt * dt
    hungry = np.isin(found["cause"], [c for c in case.series.causes if case.kind(s, c) == "starved"])
    young = hungry & (found["tick"] - found["age"] / dt > case.series.ticks[0]) & (found["age"] <= limit)
    late = found["tick"] >= case.series.ticks[fall.first]
    meals = sum(f["caught"] * f["full"] for f in foods)
    doomed = _ramp(float(np.exp(-given / burnt * meals)), *HUNGRY) * _ramp(max((f["feeds"] for f in foods), default=0.0), *GROWN)
    out |= {"starved_young": float(young.sum() / births), "lasts": given / burnt, "meal_every": 1 / meals if meals else np.inf}
    out["of_births"] = out["starved_young"] * doomed
    out["of_hunger"] = float((young & late).sum() / max((hungry & late).sum(), 1)) * doomed
    return out


def _taken(case: Case, found: Scores, eater: str, prey: str, weight: float, fall: Fall, told: dict[str, Fall]) -> None:
    """An eater took too many: a grazer, or a predator."""
    if case.is_animal(prey):
        found["predators too good", eater, prey] += weight
        return
    kept = idle(case, eater, fall, told)
    found["predators too few", kept or eater, eater if kept else prey] += weight if kept else 0.0
    found["overgrazing", eater, prey] += 0.0 if kept else weight


def idle(case: Case, grazer: str, fall: Fall, told: dict[str, Fall]) -> str | None:
    """A predator of the grazer that was gone, or nearly, before the plants were: grazers throve for want of it."""
    for p in case.eaters(grazer):
        n = case.series.of(p)
        if n.max(initial=0) >= 1 and n[min(fall.first, len(n) - 1)] <= 0.3 * n.max() and p in told and told[p].first < fall.first:
            return p
    return None


def _scarce(case: Case, found: Scores, food: str, weight: float, fall: Fall, told: dict[str, Fall], seen: frozenset[str]) -> None:
    """Food was gone: who ate it, or what else befell it."""
    if food in told and food not in seen and case.is_animal(food):
        for key, w in blame(case, told[food], told, seen).items():
            found[key] += weight * w
        return
    if case.is_animal(food):  # it fell and lives on: what took most of it while the eater starved
        lost = losses(case, food, 0, fall.last + 1)
        if lost["predators"] < 0.3 * sum(lost.values()):
            found["overgrazing" if lost["food"] else "too few births", food, food] += weight
            return
    eaten = {e: float(case.eaten(food, e)[: fall.last + 1].sum()) for e in case.eaters(food)}
    total = sum(eaten.values()) or 1.0
    for eater, k in eaten.items():
        _taken(case, found, eater, food, weight * k / total, fall, told)


def _told(case: Case, fall: Fall, told: dict[str, Fall]) -> dict[str, Any]:
    ticks, n = case.series.ticks, case.series.of(fall.species)
    at = min(fall.last, len(ticks) - 1)
    return {"species": fall.species, "extinct": fall.extinct, "tick": int(ticks[at]), "since": int(ticks[fall.first]), "from": int(n[fall.first]),
            "peak": int(n.max()), "causes": dict(sorted(causes(case, fall).items(), key=lambda x: -x[1])),
            "deaths": int(case.flow(fall.species, "deaths")[fall.first : fall.last + 1].sum()),
            "births": int(case.flow(fall.species, "births")[fall.first : fall.last + 1].sum()),
            "food": supply(case, fall), "newborn": newborn(case, fall),
            "offspring": heirs if (heirs := offspring(case, fall.species)) < np.inf else None}  # fmt: skip


def _safety(case: Case) -> float:
    """How far from extinction everybody stayed: 1 where the least number of each was a tenth of its mean or more."""
    n = case.series.n[:, case.series.present]
    if not n.size:
        return 0.0
    return float(np.clip((n.min(0) / np.maximum(n.mean(0), 1e-9)).min() / 0.1, 0.5, 1))
