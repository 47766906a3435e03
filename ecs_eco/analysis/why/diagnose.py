"""Traces an extinction back to its first cause. If a species starved because its food was gone, the search
continues with whatever ate the food. If it starved amid plenty, died of age without enough offspring, lost
its newborns or was poisoned, the chain of causes ends there. Each step has a weight from 0 to 1; the verdict
is the end of the chain with the greatest weight."""

from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np

from ecs_eco.analysis.why.case import KINDS, Case
from ecs_eco.analysis.why.limits import poisoned_share, unborn

# intake at the food's peak number / energy burned: below the first value, hunger amid plenty; above the
# second, lack of food
FEEDS = (0.9, 1.3)
# food left while they starved / its peak number: above the first value, no lack of food; below the second,
# certain lack
LEFT = (0.95, 0.6)
GONE = (0.5, 0.2)  # food left: below these values, lack of food, even if its peak number was too low as well
GROWN = (0.6, 0.9)  # intake at the food's peak number / energy burned: below these values, adults starve too
# probability that a newborn finds no meal in time: below the first value, normal; above the second, fatal
HUNGRY = (0.55, 0.8)


@dataclass(frozen=True)
class Fall:
    """A species' decline: rows of the series from when it last had half its peak number to its end."""

    species: str
    first: int
    last: int  # first row without the species, or the row after the last
    extinct: bool

    @property
    def after(self) -> slice:
        """The rows after the first, as in `extinction.Decline`, or the only row."""
        return slice(min(self.first + 1, self.last), self.last + 1)


def offspring(case: Case, species: str) -> float:
    """Return the lifetime offspring of a well-fed individual, or ∞ if the world sets no rate or lifespan."""
    way = case.of(species).get("reproduction") or {}
    if not way:
        return 0.0
    limits = case.of(species).get("lethal") or ()
    ages = [x["max"] for x in limits if x["property"] == "age" and x.get("max") is not None]
    span = min(ages, default=np.inf)
    if "rate" not in way or span == np.inf:
        return float(np.inf)
    return float(way["rate"] * way.get("litter", 1) * max(span - way.get("age_min", 0.0), 0.0))


def supply(case: Case, fall: Fall) -> list[dict[str, Any]]:
    """Return the supply of each food of a declining species. `left` is the amount of food during starvation as a
    fraction of its peak number (for prey: its peak before the end of the decline). `feeds` is the intake at the
    peak number, given the observed rate of finding and catching food, divided by the energy burned. `scarce` is
    the share of hunger explained by the lack of this food."""
    s, span = fall.species, slice(0, fall.last + 1)
    n = case.series.of(s)[span]
    hungry = case.died(s, "starved")[fall.first : fall.last + 1]
    burnt = float(case.flow(s, "burnt")[span].sum() / max(n.sum(), 1.0))
    out: list[dict[str, Any]] = []
    for f in case.diet(s):
        if f.gain <= 0 or f.deadly or f.eats not in case.species:
            continue
        food = case.series.of(f.eats)
        full = float(food[span].max(initial=0.0)) if case.is_animal(f.eats) else float(food.max(initial=0.0))
        now = food[fall.first : fall.last + 1]
        left = float(np.average(now, weights=hungry) if hungry.sum() else now.mean()) / max(full, 1.0)
        # rate at which one eater catches one item [1/tick]
        caught = float(case.eaten(f.eats, s)[span].sum() / max((n * food[span]).sum(), 1.0))
        line: dict[str, Any] = {"eats": f.eats, "left": left, "caught": caught}
        out.append(line | {"intake": caught * full * f.gain, "gain": f.gain, "full": full})
    intake = sum(f["intake"] for f in out)
    feeds = intake / burnt if burnt else np.inf
    for line in out:
        part = line["intake"] / intake if intake else 1 / len(out)
        gone = ramp(line["left"], *LEFT) * max(ramp(feeds, *FEEDS), ramp(line["left"], *GONE))
        line |= {"feeds": feeds, "scarce": part * gone}
    return out


def newborn(case: Case, fall: Fall) -> dict[str, float]:
    """Return the fate of newborns until the end of a decline: `births`; `starved_young`, the fraction of them that
    starved before they could have had more than one meal; `lasts`, the ticks for which a newborn's initial
    energy lasts; `meal_every`, the ticks between meals at the food's peak number. For newborns that could not
    survive until their first meal: their fractions `of_births` and `of_hunger` (deaths in the decline)."""
    s, span = fall.species, slice(0, fall.last + 1)
    births, dead = float(case.flow(s, "births")[span].sum()), case.deaths.get(s)
    given = float((case.of(s).get("reproduction") or {}).get("energy_given", 0.0))
    burnt = float(case.flow(s, "burnt")[span].sum() / max(case.series.of(s)[span].sum(), 1))
    out = {"births": births, "starved_young": 0.0, "lasts": np.nan, "meal_every": np.nan}
    out |= {"of_births": 0.0, "of_hunger": 0.0}
    if not births or not burnt or not given or dead is None:
        return out
    dt, foods = case.series.dt, supply(case, fall)
    limit = 1.5 * (given + max((f.gain for f in case.diet(s)), default=0.0)) / burnt * dt
    hungry = np.isin(dead["cause"], [c for c in case.series.causes if case.kind(s, c) == "starved"])
    young = hungry & (dead["tick"] - dead["age"] / dt > case.series.ticks[0]) & (dead["age"] <= limit)
    late = dead["tick"] >= case.series.ticks[fall.first]
    meals = sum(f["caught"] * f["full"] for f in foods)
    feeds = max((f["feeds"] for f in foods), default=0.0)
    doomed = ramp(float(np.exp(-given / burnt * meals)), *HUNGRY) * ramp(feeds, *GROWN)
    out["starved_young"], out["lasts"] = float(young.sum() / births), given / burnt
    out["meal_every"] = 1 / meals if meals else np.inf
    out["of_births"] = out["starved_young"] * doomed
    out["of_hunger"] = float((young & late).sum() / max((hungry & late).sum(), 1)) * doomed
    return out


def ramp(x: float, low: float, high: float) -> float:
    """Return 0 at `low`, 1 at `high`, and interpolate linearly in between."""
    return float(np.clip((x - low) / (high - low), 0, 1))


VERDICTS = {
    "healthy": "no species died out",
    "overgrazing": "plants were eaten faster than they grew",
    "predators too good": "prey was eaten faster than it bred",
    "predators too few": "predators could not maintain their numbers although there was prey",
    "newborns starve": "newborns starved before they could feed themselves",
    "poisoned": "food was poisonous",
    "starved amid plenty": "food was available but not found or not caught",
    "food failed": "there was too little food although nothing ate it",
    "energy ran out": "a species that eats no other species burned more energy than it gained",
    "too few births": "deaths were not replaced although there was enough food",
    "removed": "interventions removed too many organisms",
    "surroundings": "environmental conditions were deadly",
    "nobody": "no organism was alive at the end of any tick",
}
HEIRS = (0.5, 1.0)  # lifetime offspring of a well-fed individual below which population size falls
FALLEN = 0.05  # final number / peak number below which a species counts as nearly extinct
Scores = dict[tuple[str, str, str], float]  # (verdict, species responsible, victim): weight


def falls(case: Case) -> list[Fall]:
    """Return the declines of species that were extinct or nearly so at the end, in chronological order."""
    all_falls = []
    for i, s in enumerate(case.species):
        n = case.series.n[:, i]
        top = n.max(initial=0)
        gone = not np.isnan(case.series.extinct[i])
        if top < 1 or not (gone or n[-1] <= min(FALLEN * top, 10)):
            continue
        last = int(np.flatnonzero(n)[-1]) + 1
        high = np.flatnonzero(n[:last] >= 0.5 * top)
        all_falls.append(Fall(s, min(int(high[-1]), last - 1), last, gone))
    return sorted(all_falls, key=lambda f: (not f.extinct, f.last))


def diagnose(case: Case) -> dict[str, Any]:
    """Return the verdict on a run with its evidence, a confidence from 0 to 1, and the runner-up."""
    fallen = falls(case)
    if not fallen:
        verdict = "healthy" if case.series.n.any() else "nobody"
        nothing: dict[str, Any] = {"runner_up": None, "evidence": {"weights": {}}, "fell": []}
        return {"verdict": verdict, "species": None, "victim": None, "confidence": _safety(case), **nothing}
    by_species = {f.species: f for f in fallen}
    scores = blame(case, fallen[0], by_species, frozenset())
    total = sum(scores.values()) or 1.0
    ranked = sorted(scores.items(), key=lambda x: -x[1])
    by_verdict: dict[str, float] = defaultdict(float)
    for (verdict, _, _), weight in ranked:
        by_verdict[verdict] += weight / total
    weights = dict(sorted(by_verdict.items(), key=lambda x: -x[1]))
    best, *rest = weights.items()
    (_, species, victim), _ = next(r for r in ranked if r[0][0] == best[0])
    return {
        "verdict": best[0],
        "species": species,
        "victim": victim,
        "confidence": best[1],
        "runner_up": {"verdict": rest[0][0], "confidence": rest[0][1]} if rest else None,
        "evidence": {"weights": weights} | evidence(case, by_species.get(species, fallen[0])),
        "fell": [_fall_entry(case, f) for f in fallen],
    }


def evidence(case: Case, fall: Fall) -> dict[str, Any]:
    """Return the numbers behind a verdict: deaths by kind of cause, births, food and newborns in a decline."""
    dead = {f"deaths_{kind}": int(case.died(fall.species, kind)[fall.after].sum()) for kind in KINDS}
    food = {f["eats"]: {"left": f["left"], "feeds": f["feeds"]} for f in supply(case, fall)}
    young = {k: v for k, v in newborn(case, fall).items() if k in ("starved_young", "lasts", "meal_every")}
    return {
        "of": fall.species,
        **dead,
        "births": int(case.flow(fall.species, "births")[fall.after].sum()),
        "food": food,
        "newborn": young,
        "poison_share_of_hunger": poisoned_share(case, fall.species, fall.first, fall.last + 1),
    }


def blame(case: Case, fall: Fall, fall_of: dict[str, Fall], seen: frozenset[str]) -> Scores:
    """Return the root causes of a decline, with weights that sum to 1."""
    scores: Scores = defaultdict(float)
    s = fall.species
    for cause, weight in causes(case, fall).items():
        kind, _, other = cause.partition(": ")
        if weight <= 0:
            continue
        if kind == "eaten":
            _taken(case, scores, other, s, weight, fall, fall_of)
        elif kind == "scarce":
            _scarce(case, scores, other, weight, fall, fall_of, seen | {s})
        elif kind in ("amid plenty", "unreplaced"):
            hunts = any(case.is_animal(f.eats) for f in case.diet(s))
            own = "starved amid plenty" if kind == "amid plenty" else "too few births"
            scores["predators too few" if hunts else own, s, s] += weight
        else:
            scores[kind, s, s] += weight
    return scores


def causes(case: Case, fall: Fall) -> dict[str, float]:
    """Return the immediate causes of a decline with their shares: "eaten: wolf", "scarce: grass", "unreplaced", …,
    and "amid plenty" or, for a species without a diet, "energy ran out"."""
    s, first, last = fall.species, fall.first, fall.last
    span = slice(first, last + 1)
    dead = {kind: float(case.died(s, kind)[span].sum()) for kind in KINDS}
    unborn_hungry = unborn(case, s, first, last + 1)[0] * float(case.series.of(s)[span].sum())
    total = sum(dead.values()) + unborn_hungry or 1.0
    out: dict[str, float] = defaultdict(float)
    for eater in case.eaters(s):
        out[f"eaten: {eater}"] += float(case.eaten(s, eater)[span].sum()) / total
    poison = poisoned_share(case, s, first, last + 1)
    starved = dead["starved"] / total
    # births that failed due to lack of energy count as hunger, like deaths
    lean = unborn_hungry / total
    out["poisoned"] = dead["poisoned"] / total + (starved + lean) * poison
    young = newborn(case, fall)
    # offspring that were never born would not have survived either
    newborns = starved * young["of_hunger"] + lean * young["of_births"]
    out["newborns starve"] = newborns * (1 - poison)
    starved = (starved + lean - newborns) * (1 - poison)
    rest = "amid plenty" if case.diet(s) else "energy ran out"
    out[rest] = starved
    for food in supply(case, fall):
        out[f"scarce: {food['eats']}"] = starved * food["scarce"]
        out[rest] -= starved * food["scarce"]
    heirs = min(1.0, young["births"] / max(float(case.died(s, "old")[: last + 1].sum()), 1.0))
    out["newborns starve"] += dead["old"] / total * young["of_births"] * heirs
    out["unreplaced"] = dead["old"] / total * (1 - young["of_births"] * heirs)
    out["removed"], out["surroundings"] = dead["removed"] / total, dead["surroundings"] / total
    barren = 1 - ramp(offspring(case, s), *HEIRS)
    apart = ("eaten", "poisoned", "removed", "surroundings", "unreplaced")
    for cause in [w for w in out if not w.startswith(apart)]:
        out["unreplaced"] += out[cause] * barren
        out[cause] *= 1 - barren
    return dict(out)


def _taken(
    case: Case, scores: Scores, eater: str, prey: str, weight: float, fall: Fall, fall_of: dict[str, Fall]
) -> None:
    """Assign blame to an eater that ate too much: a grazer or a predator."""
    if case.is_animal(prey):
        scores["predators too good", eater, prey] += weight
        return
    kept = idle(case, eater, fall, fall_of)
    scores[("predators too few", kept, eater) if kept else ("overgrazing", eater, prey)] += weight


def idle(case: Case, grazer: str, fall: Fall, fall_of: dict[str, Fall]) -> str | None:
    """Return a predator that fell before the plants did, but not because prey was scarce, or None."""
    for p in case.eaters(grazer):
        own, n = fall_of.get(p), case.series.of(p)
        if own is None or own.first >= fall.first or n[min(fall.first, len(n) - 1)] > 0.3 * n.max():
            continue
        if sum(w for cause, w in causes(case, own).items() if cause.startswith("scarce")) < 0.5:
            return p
    return None


def decline(case: Case, species: str, until: int) -> Fall:
    """Return a surviving species' decline before a row: from half its peak number to its later minimum."""
    n = case.series.of(species)[: until + 1]
    low = int(n.argmax()) + int(n[int(n.argmax()) :].argmin())
    high = np.flatnonzero(n[: low + 1] >= 0.5 * n.max())
    return Fall(species, int(high[-1]), low, False)


def _scarce(
    case: Case,
    scores: Scores,
    food: str,
    weight: float,
    fall: Fall,
    fall_of: dict[str, Fall],
    seen: frozenset[str],
) -> None:
    """Assign blame for missing food to its eaters, or to any other causes of its decline."""
    if case.is_animal(food) and food not in seen:
        own = fall_of.get(food)
        before = own if own is not None and own.first <= fall.last else decline(case, food, fall.last)
        for key, w in blame(case, before, fall_of, seen).items():
            scores[key] += weight * w
        return
    eaten = {e: float(case.eaten(food, e)[: fall.last + 1].sum()) for e in case.eaters(food)}
    total = sum(eaten.values())
    if not total:
        scores["food failed", food, fall.species] += weight
        return
    for eater, k in eaten.items():
        _taken(case, scores, eater, food, weight * k / total, fall, fall_of)


def _fall_entry(case: Case, fall: Fall) -> dict[str, Any]:
    s, ticks, n = fall.species, case.series.ticks, case.series.of(fall.species)
    at = min(fall.last, len(ticks) - 1)
    after, lived = fall.after, slice(fall.first, at + 1)
    heads = max(n[lived].sum(), 1)
    return {
        "species": s,
        "extinct": fall.extinct,
        "tick": int(ticks[at]),
        "since": int(ticks[fall.first]),
        "from": int(n[fall.first]),
        "peak": int(n.max()),
        "causes": dict(sorted(causes(case, fall).items(), key=lambda x: -x[1])),
        "deaths": int(case.flow(s, "deaths")[after].sum()),
        "births": int(case.flow(s, "births")[after].sum()),
        "food": supply(case, fall),
        "newborn": newborn(case, fall),
        "budget": {flow: float(case.flow(s, flow)[lived].sum() / heads) for flow in ("taken_in", "burnt")},
        "offspring": heirs if (heirs := offspring(case, s)) < np.inf else None,
    }


def _safety(case: Case) -> float:
    """Return the confidence in "healthy": 1 if the minimum of each species is at least a tenth of its mean."""
    n = case.series.n[:, case.series.present]
    if not n.size:
        return 0.0
    return float(np.clip((n.min(0) / np.maximum(n.mean(0), 1e-9)).min() / 0.1, 0.5, 1))
