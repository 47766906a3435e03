"""Energy flows between species in a run: means per tick, and an SVG drawing for light and dark pages."""

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.page import number, table, write_text
from ecs_eco.analysis.palette import safe
from ecs_eco.analysis.runs import DIED, Series
from ecs_eco.analysis.style import colors, own_colors
from ecs_eco.config.models.reporters import EATEN

WIDE, BAR, TOP, GAP, STUB, TALL = 760, 9, 20, 26, 44, 130  # sizes in the drawing [px]
THIN = 1.2  # narrowest band [px]
BY = "eaten by "
INK, SOFT = ("#1b1f23", "#e6eaee"), ("#57606a", "#98a5aa")  # colors on light and on dark backgrounds
LIGHT, HARM = ("#e3b505", "#f0cf57"), ("#c04a00", "#ff8a4c")

_CAPTION = (
    "The width of a band from food to eater shows the energy gained per tick. Bars on the left show "
    "energy from light; bars on the right show energy burned (faint) and left over at death (solid): what dead "
    "organisms still had, minus what eaters gained from them. Dashed bands mark food that harms its eater."
)
_SHARED = (
    " The energy from each food was not recorded, so an eater's intake is divided among its foods by number."
)


@dataclass(frozen=True)
class Meal:
    """The energy that an eater gains from a food per tick, and the number of items eaten per tick."""

    food: str
    eater: str
    energy: float
    number: float


@dataclass(frozen=True)
class Budget:
    """The other energy flows of a species per tick."""

    light: float
    other: float  # inflow from parents and reactions
    burnt: float
    dead: float  # left over at death: what dead organisms still had, minus what eaters gained from them


@dataclass(frozen=True)
class Flows:
    """The food web of a run, as means per tick."""

    meals: tuple[Meal, ...]
    budgets: Mapping[str, Budget]
    shared: bool  # the energy from each food was not recorded: an eater's intake is divided by number


def flows(series: Series) -> Flows | None:
    """Return the flows in a run, or None if nothing was eaten or the run has no energy ledger."""
    if not len(series.ticks) or "taken_in" not in series.columns:
        return None
    mean = {name: values.mean(axis=0) for name, values in series.columns.items()}
    shared = not any(name.startswith(EATEN) for name in mean)
    meals = [
        Meal(food, cause.removeprefix(BY), 0.0, float(mean[DIED + cause][f]))
        for cause in series.causes
        if cause.startswith(BY) and cause.removeprefix(BY) in series.species
        for f, food in enumerate(series.species)
        if mean[DIED + cause][f]
    ]
    total = {eater: sum(m.number for m in meals if m.eater == eater) for eater in series.species}
    meals = [Meal(m.food, m.eater, _energy(series, mean, m, shared, total[m.eater]), m.number) for m in meals]
    if not meals:
        return None
    budgets, config = {}, (series.manifest.get("config") or {}).get("species") or {}
    for s, name in enumerate(series.species):
        ate = [m.energy for m in meals if m.eater == name]
        passed = sum(max(m.energy, 0.0) for m in meals if m.food == name)
        rest = max(0.0, float(mean["taken_in"][s]) - sum(ate))
        rest = rest if rest > 1e-6 * max(float(mean["taken_in"][s]), 1e-9) else 0.0
        light, other = (0.0, rest) if ate or config.get(name, {}).get("diet") else (rest, 0.0)
        dead = max(0.0, float(mean["lost"][s]) - passed)
        budgets[name] = Budget(light, other, float(mean["burnt"][s]), dead)
    return Flows(tuple(meals), budgets, shared)


def _energy(series: Series, mean: Mapping[str, np.ndarray], meal: Meal, shared: bool, total: float) -> float:
    eater = series.index(meal.eater)
    if shared:
        return float(mean["taken_in"][eater]) * meal.number / total
    return float(mean[EATEN + meal.food][eater]) if EATEN + meal.food in mean else 0.0


def levels(found: Flows) -> dict[str, int]:
    """Return the trophic level of each species, with 0 for species that eat no other species."""
    names = list(dict.fromkeys(name for m in found.meals for name in (m.food, m.eater)))
    level = dict.fromkeys(names, 0)
    for _ in names:
        for name in names:
            below = [level[m.food] for m in found.meals if m.eater == name and m.food != name]
            level[name] = min(len(names) - 1, 1 + max(below)) if below else 0
    order = sorted(set(level.values()))
    return {name: order.index(height) for name, height in level.items()}


def draw(series: Series, found: Flows) -> str:
    """Return the drawing as SVG, with a band from each food to its eater, as wide as the energy gained."""
    level = levels(found)
    names = sorted(level, key=lambda name: series.species.index(name))
    through = {name: _through(found, name) for name in names}
    columns = [[n for n in names if level[n] == k] for k in range(max(level.values()) + 1)]
    scale = TALL / max(1e-12, *(sum(through[n] for n in column) for column in columns))
    left = STUB if any(found.budgets[n].light + found.budgets[n].other for n in names) else 2
    step = (WIDE - left - STUB - BAR) / max(1, len(columns) - 1)
    at: dict[str, list[float]] = {}  # x, y, height, and the y reached so far by inflows and by outflows
    for k, column in enumerate(columns):
        y = float(TOP)
        for n in column:
            high = max(3.0, scale * through[n])
            at[n] = [left + k * step, y, high, y, y]
            y += high + GAP
    high = max(y + h for _, y, h, *_ in at.values()) + 8
    parts = [part for n in names for part in _enters(n, found.budgets[n], at[n], scale)]
    meals = sorted(found.meals, key=lambda m: (names.index(m.eater), names.index(m.food)))
    parts += [_band(m, at[m.food], at[m.eater], names.index(m.food), scale) for m in meals]
    for i, n in enumerate(names):
        parts += _node(n, i, found.budgets[n], at[n], scale, level[n] == len(columns) - 1 > 0)
    words = "; ".join(
        f"{m.eater} eats {number(m.number)} {m.food} per tick and gains {number(m.energy)}"
        for m in found.meals
    )
    return (
        f'<svg class="flows" viewBox="0 0 {WIDE} {high:.0f}" role="img" '
        f'aria-label="{escape(words, quote=True)}" font-family="system-ui, sans-serif" font-size="13">'
        f"<style>{_style(series, names)}</style>{''.join(parts)}</svg>"
    )


def _through(found: Flows, name: str) -> float:
    """Return the larger of the inflow and the outflow of a species."""
    b = found.budgets[name]
    return max(
        b.light + b.other + sum(abs(m.energy) for m in found.meals if m.eater == name),
        b.burnt + b.dead + sum(abs(m.energy) for m in found.meals if m.food == name),
    )


def _style(series: Series, names: list[str]) -> str:
    """Return the colors of bars and bands, on light and on dark backgrounds."""
    rules = []
    chosen: Any = series.manifest.get("colors")
    for dark in (False, True):
        hue = colors(series.species, chosen) | safe(own_colors(chosen), dark=dark)
        lines = [f".flows .s{i}{{fill:{hue[n]}}}.flows .b{i}{{stroke:{hue[n]}}}" for i, n in enumerate(names)]
        lines.append(f".flows text{{fill:{INK[dark]}}}.flows .soft{{fill:{SOFT[dark]}}}")
        lines.append(f".flows .light{{fill:{LIGHT[dark]}}}.flows .harm{{stroke:{HARM[dark]}}}")
        rules.append("".join(lines))
    return f"{rules[0]}@media (prefers-color-scheme:dark){{{rules[1]}}}"


def _enters(name: str, budget: Budget, at: list[float], scale: float) -> list[str]:
    given = budget.light + budget.other
    if not given:
        return []
    x, y = at[0], at[3]
    at[3] += given * scale
    source = "light" if budget.light else "parents and reactions"
    words = f"{name} from {source}: {number(given)}"
    return [_rect("light", x - STUB + 2, y, STUB - 2, given * scale, 0.8, words)]


def _band(meal: Meal, food: list[float], eater: list[float], number_of: int, scale: float) -> str:
    size = abs(meal.energy) * scale
    wide = max(size, THIN)
    x0, y0, x1, y1 = food[0] + BAR, food[4] + wide / 2, eater[0], eater[3] + wide / 2
    food[4] += size
    eater[3] += size
    reach = max(24.0, abs(x1 - x0) / 2)
    harms = meal.energy < 0
    curve = (
        f"M{x0:.1f},{y0:.1f}c30,-26 {-BAR - 60},-26 {-BAR},0"
        if food is eater
        else f"M{x0:.1f},{y0:.1f}C{x0 + reach:.1f},{y0:.1f} {x1 - reach:.1f},{y1:.1f} {x1:.1f},{y1:.1f}"
    )
    dash = ' stroke-dasharray="3 3"' if harms else ' stroke-dasharray="1 4"' if not size else ""
    words = f"{meal.eater} eats {number(meal.number)} {meal.food} per tick: {number(meal.energy)} energy"
    text = (
        f'<text x="{(x0 + x1) / 2:.1f}" y="{(y0 + y1) / 2 + 4:.1f}" text-anchor="middle">'
        f"{number(meal.number, 2)} eaten</text>"
        if wide > 15
        else ""
    )
    return (
        f'<path d="{curve}" fill="none" class="{"harm" if harms else f"b{number_of}"}" '
        f'stroke-width="{wide:.2f}" stroke-opacity=".5"{dash}><title>{escape(words)}</title></path>'
        f"{text}"
    )


def _node(name: str, i: int, budget: Budget, at: list[float], scale: float, last: bool) -> list[str]:
    """Return a species' bar with its name and inflow, and bars for energy burned and left over at death."""
    x, y, high, into, out = at
    parts = []
    for value, what, opacity in ((budget.burnt, "burned", 0.35), (budget.dead, "left over at death", 0.9)):
        high_of, words = value * scale, f"{name}, {what}: {number(value)}"
        parts += [_rect("soft", x + BAR, out, STUB - 4, high_of, opacity, words)] * bool(value)
        out += high_of
    given = f" {number((into - y) / scale, 2)}" if into - y > 0.01 else ""
    where, anchor = (x + BAR, "end") if last else (x, "start")
    return [
        *parts,
        f'<rect class="s{i}" x="{x:.1f}" y="{y:.1f}" width="{BAR}" height="{high:.1f}" rx="2"/>',
        f'<text x="{where:.1f}" y="{y - 5:.1f}" text-anchor="{anchor}" font-weight="600">'
        f"{escape(name)}{given}</text>",
    ]


def _rect(kind: str, x: float, y: float, wide: float, high: float, opacity: float, words: str) -> str:
    return (
        f'<rect class="{kind}" x="{x:.1f}" y="{y:.1f}" width="{wide:.1f}" height="{max(THIN, high):.1f}" '
        f'opacity="{opacity}"><title>{escape(words)}</title></rect>'
    )


def blocks(series: Series, place: Path) -> list[str]:
    """Return the section on flows, empty if nothing was eaten, and write figures/flows.svg in `place`."""
    found = flows(series)
    if found is None:
        return []
    drawn = draw(series, found)
    alone = drawn.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)
    write_text(place / "figures" / "flows.svg", alone)
    rows = []
    for m in found.meals:
        each = number(m.energy / m.number) if m.number else "–"
        rows.append([f"{m.food} → {m.eater}", number(m.energy), number(m.number), each])
    caption = escape(_CAPTION + _SHARED * found.shared)
    return [
        "<h2>Energy flows</h2>",
        f"<figure><div class='wide' tabindex='0'>{drawn}</div><figcaption>{caption}</figcaption></figure>",
        table(["food → eater", "energy per tick", "number per tick", "energy of each"], rows),
    ]
