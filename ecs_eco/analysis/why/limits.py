"""The limiting factor of a species in each phase. Per capita per tick, the maximum birth rate minus actual
growth equals the births that failed due to lack of energy or space plus deaths by cause. The largest of these
losses is the limit. In a later decline, the limit is the loss that has increased most: grass that is short of
space declines because of grazing."""

from typing import Any

import numpy as np

from ecs_eco.analysis.spectrum import smooth
from ecs_eco.analysis.why.case import KINDS, Case

MOST = 8  # maximum number of phases reported per species


def losses(case: Case, species: str, first: int, last: int) -> dict[str, float]:
    """Return the loss of growth due to each limit in rows first … last − 1, per capita per tick."""
    span = slice(first, last)
    heads = max(case.series.of(species)[span].sum(), 1.0)
    dead = {kind: float(case.died(species, kind)[span].sum() / heads) for kind in KINDS}
    hunger, room = unborn(case, species, first, last)
    blamed = poisoned_share(case, species, first, last)
    return {
        "food": (dead["starved"] + hunger) * (1 - blamed),
        "predators": dead["eaten"],
        "poison": dead["poisoned"] + (dead["starved"] + hunger) * blamed,
        "age": dead["old"],
        "room": room,
        "removal": dead["removed"],
        "surroundings": dead["surroundings"],
    }


def unborn(case: Case, species: str, first: int, last: int) -> tuple[float, float]:
    """Return the failed births per capita per tick due to lack of energy, and due to lack of space or mates; 0
    and 0 if genes decide how much energy a birth needs."""
    if case.coded(species) & {
        "reproduction.energy_min",
        "reproduction.energy_given",
        "reproduction.father_share",
    }:
        return 0.0, 0.0
    rate = greatest_rate(case, species)
    span = slice(first, last)
    n = case.series.of(species)[span]
    born = float(case.flow(species, "births")[span].sum() / max(n.sum(), 1.0))
    ticks, share = case.able(species)
    if not len(ticks):
        return 0.0, max(0.0, rate - born)
    at = case.series.ticks[span]
    fed = float(np.average(np.interp(at, ticks, share), weights=np.maximum(n, 1e-9)))
    return rate * (1 - fed), max(0.0, rate * fed - born)


def greatest_rate(case: Case, species: str) -> float:
    """Return the unlimited birth rate per capita per tick: from the world file, or the highest in the run if the
    file has none or genes replace it."""
    way = case.of(species).get("reproduction") or {}
    if "rate" in way and not case.coded(species) & {"reproduction.rate", "reproduction.litter"}:
        return float(way["rate"] * case.series.dt * way.get("litter", 1))
    births, n = case.flow(species, "births"), case.series.of(species)
    window = max(1, len(n) // 30)
    rates = smooth(births, window) / np.maximum(smooth(n, window), 1.0)
    return float(np.quantile(rates, 0.95)) if len(n) and births.any() else 0.0


def poisoned_share(case: Case, species: str, first: int, last: int) -> float:
    """Return the share of hunger due to poison: the energy lost to poison divided by the energy deficit, at most 1.
    The deficit is taken to be at least 30% of the energy burned, because some individuals starve while other
    individuals are sated."""
    span = slice(first, last)
    toll, burnt = float(case.toll(species)[span].sum()), float(case.flow(species, "burnt")[span].sum())
    lacking = burnt - float(case.flow(species, "taken_in")[span].sum())
    return min(1.0, toll / max(lacking, 0.3 * burnt, 1e-12)) if toll > 0 else 0.0


def phases(case: Case, species: str) -> list[dict[str, Any]]:
    """Return the phases in which a species grew, fell or stayed constant. In each, `limit` is the largest loss and
    `share` its share of all losses. If `by` is "rise", `limit` is the loss that has increased most since the
    previous phase, and `share` its share of all increases."""
    n = case.series.of(species)
    gone = np.flatnonzero(n > 0)
    if not len(gone):
        return []
    end = min(int(gone[-1]) + 2, len(n))
    marks = turns(n[:end])
    out: list[dict[str, Any]] = []
    for first, last in zip(marks, marks[1:], strict=False):
        lost = losses(case, species, first, last)
        factor = (n[last - 1] + 1) / (n[first] + 1)
        trend = "grew" if factor > 1.25 else "fell" if factor < 0.8 else "held"
        by, limit, share = _limit(lost, out[-1]["losses"] if out and trend == "fell" else None)
        out.append(
            {
                "from": int(case.series.ticks[first]),
                "to": int(case.series.ticks[last - 1]),
                "n": [int(n[first]), int(n[last - 1])],
                "trend": trend,
                "limit": limit,
                "share": share,
                "by": by,
                "losses": lost,
                "births": float(case.flow(species, "births")[first:last].sum() / max(n[first:last].sum(), 1)),
            }
        )
    return out


def _limit(lost: dict[str, float], before: dict[str, float] | None) -> tuple[str, str | None, float]:
    """Return the basis of the limit ("rise" or "level"), the limit, and its share."""
    risen = {} if before is None else {k: max(0.0, loss - before[k]) for k, loss in lost.items()}
    by, sizes = ("rise", risen) if sum(risen.values()) > 0 else ("level", lost)
    total = sum(sizes.values())
    limit = max(sizes, key=lambda k: sizes[k]) if total > 0 else None
    return by, limit, sizes[limit] / total if limit else 0.0


def turns(n: np.ndarray, most: int = MOST) -> list[int]:
    """Return the rows at which a species' trend reverses, and both ends, for at most `most` phases."""
    if len(n) < 4:
        return [0, len(n)]
    level = np.log(smooth(n.astype(float), max(1, len(n) // 50)) + 1)
    swing = 0.35
    while len(marks := _zigzag(level, swing)) > most + 1:
        swing *= 1.3
    return marks


def _zigzag(level: np.ndarray, swing: float) -> list[int]:
    """Return the turning points of a series that differ in height by at least `swing`."""
    marks, high, low, way = [0], 0, 0, 0
    for i, v in enumerate(level):
        high = i if v > level[high] else high
        low = i if v < level[low] else low
        if way >= 0 and level[high] - v > swing:  # the trend has turned downward
            marks, low, way = _marked(marks, _left(level[high:i] - level[high], swing) + high), i, -1
        elif way <= 0 and v - level[low] > swing:
            marks, high, way = _marked(marks, _left(level[low] - level[low:i], swing) + low), i, 1
    return [*marks, len(level)]


def _left(below: np.ndarray, swing: float) -> int:
    """Return the last index at which a series is still near its turning point, where it may have lingered."""
    return int(np.flatnonzero(below >= -0.1 * swing)[-1])


def _marked(marks: list[int], at: int) -> list[int]:
    return marks if at - marks[-1] < 2 else [*marks, at]
