"""Hunger of a species that fell: was food lacking or not caught, did newborn starve, had it offspring?"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ecs_eco.analysis.why.case import Case

# intake at the food's full number over energy burnt: below, hunger amid plenty; above, lack of food
FEEDS = (0.9, 1.3)
# food left while they starved, as a share of its full number: above, no lack of it; below, certainly
LEFT = (0.95, 0.6)
GONE = (0.5, 0.2)  # food left: below, lack of it, whatever its full number would have fed
GROWN = (0.6, 0.9)  # intake over burnt at the food's full number: below, adults starve too
HUNGRY = (0.55, 0.8)  # chance that a newborn finds no meal in time: below, normal; above, fatal


@dataclass(frozen=True)
class Fall:
    """A species' decline: rows of the series from when it last had half its greatest number, to its end."""

    species: str
    first: int
    last: int  # the first row without it, or the row after the last
    extinct: bool


def offspring(case: Case, species: str) -> float:
    """Offspring of one well-fed life, by the world file; ∞ if the file sets no rate or no lifespan."""
    way = case.of(species).get("reproduction") or {}
    if not way:
        return 0.0
    limits = case.of(species).get("lethal") or ()
    span = min(
        (x["max"] for x in limits if x["property"] == "age" and x.get("max") is not None), default=np.inf
    )
    if "rate" not in way or span == np.inf:
        return float(np.inf)
    return float(way["rate"] * way.get("litter", 1) * max(span - way.get("age_min", 0.0), 0.0))


def supply(case: Case, fall: Fall) -> list[dict[str, Any]]:
    """The food supply of a fallen species: how much of each food was left when it starved, and whether the
    full number would have fed it.

    `left` is the food while they starved as a share of its greatest number (of prey: until the end of the
    fall); `feeds` is the intake at that number over what they burnt, at the rate at which they found and
    caught it; `scarce` the share of their hunger that its fall explains.
    """
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
        # by one eater, of one item, in a tick
        caught = float(case.eaten(f.eats, s)[span].sum() / max((n * food[span]).sum(), 1.0))
        out.append(
            {
                "eats": f.eats,
                "left": left,
                "caught": caught,
                "intake": caught * full * f.gain,
                "gain": f.gain,
                "full": full,
            }
        )
    intake = sum(f["intake"] for f in out)
    feeds = intake / burnt if burnt else np.inf
    for line in out:
        part = line["intake"] / intake if intake else 1 / len(out)
        gone = ramp(line["left"], *LEFT) * max(ramp(feeds, *FEEDS), ramp(line["left"], *GONE))
        line |= {"feeds": feeds, "scarce": part * gone}
    return out


def newborn(case: Case, fall: Fall) -> dict[str, float]:
    """The fate of newborn until the end of a fall.

    `births`; `starved_young`, the share of them that starved before they could have had more than one meal;
    how many ticks a newborn `lasts` on its initial energy, and the ticks between meals at the food's greatest
    number, `meal_every`. Of newborn that could not last until a first meal: `of_births`, their share of the
    births, and `of_hunger`, their share of those that starved in the fall.
    """
    s, span = fall.species, slice(0, fall.last + 1)
    births, dead = float(case.flow(s, "births")[span].sum()), case.deaths.get(s)
    given = float((case.of(s).get("reproduction") or {}).get("energy_given", 0.0))
    burnt = float(case.flow(s, "burnt")[span].sum() / max(case.series.of(s)[span].sum(), 1))
    out = {
        "births": births,
        "starved_young": 0.0,
        "lasts": np.nan,
        "meal_every": np.nan,
        "of_births": 0.0,
        "of_hunger": 0.0,
    }
    if not births or not burnt or not given or dead is None:
        return out
    dt, foods = case.series.dt, supply(case, fall)
    limit = 1.5 * (given + max((f.gain for f in case.diet(s)), default=0.0)) / burnt * dt
    hungry = np.isin(dead["cause"], [c for c in case.series.causes if case.kind(s, c) == "starved"])
    young = hungry & (dead["tick"] - dead["age"] / dt > case.series.ticks[0]) & (dead["age"] <= limit)
    late = dead["tick"] >= case.series.ticks[fall.first]
    meals = sum(f["caught"] * f["full"] for f in foods)
    doomed = ramp(float(np.exp(-given / burnt * meals)), *HUNGRY) * ramp(
        max((f["feeds"] for f in foods), default=0.0), *GROWN
    )
    out |= {
        "starved_young": float(young.sum() / births),
        "lasts": given / burnt,
        "meal_every": 1 / meals if meals else np.inf,
    }
    out["of_births"] = out["starved_young"] * doomed
    out["of_hunger"] = float((young & late).sum() / max((hungry & late).sum(), 1)) * doomed
    return out


def ramp(x: float, low: float, high: float) -> float:
    """0 at `low`, 1 at `high`, linear between."""
    return float(np.clip((x - low) / (high - low), 0, 1))
