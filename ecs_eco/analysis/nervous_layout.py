"""The layout of a nervous-system drawing in columns, in inches with y pointing down; text widths are measured."""

import textwrap
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from scipy.optimize import isotonic_regression

from ecs_eco.analysis.formula_signs import Sign
from ecs_eco.analysis.nervous_diagram import ActionNode, Diagram, SensorNode

ROW, HEADING, GAP, BAR = 0.25, 0.32, 0.09, 0.5
LINE, BETWEEN = 0.165, 0.1  # height of a line of text in a box; gap between reflex boxes
POLICY, FUNCTION, APART = 1.1, 0.6, 0.28  # heights of boxes; gap between networks
LEAST = 2.2  # width of a box
# sensors with more channels show only the outermost channels and those that a network names
MANY = 12
MEANINGS: dict[Sign, tuple[str, str]] = {  # in the reflex network and in the happiness network
    1: ("forces the action", "raises happiness"),
    -1: ("blocks the action", "lowers happiness"),
    None: ("forces or blocks the action", "raises or lowers happiness"),
    0: ("has no weight", "has no effect on happiness"),
}


@cache
def width(text: str, size: float, bold: bool = False) -> float:
    """Return the width of a text [inches] at a font size [points]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font = FontProperties(family="DejaVu Sans", size=size, weight="bold" if bold else "normal")
    return text_to_path.get_text_width_height_descent(text, font, False)[0] / 72


def cut(text: str, most: int = 36) -> str:
    """Shorten a text to at most `most` characters by leaving out its middle."""
    return text if len(text) <= most else f"{text[: most // 2]}…{text[-(most - most // 2 - 1) :]}"


def wrapped(text: str, most: int, lines: int) -> list[str]:
    """Wrap a text into lines of at most `most` characters; text beyond the last line is cut off."""
    folded = textwrap.wrap(text, most) or [""]
    return folded if len(folded) <= lines else [*folded[: lines - 1], folded[lines - 1][: most - 2] + " …"]


def spread(wanted: Sequence[float], heights: Sequence[float], low: float, high: float) -> list[float]:
    """Return the ordered, non-overlapping box centers that are closest to the wanted ones (least squares)."""
    offsets = [0.0]
    for a, b in zip(heights, heights[1:], strict=False):
        offsets.append(offsets[-1] + (a + b) / 2 + BETWEEN)
    shifted = [at - offset for at, offset in zip(wanted, offsets, strict=True)]
    middles = isotonic_regression(shifted).x.tolist()
    least, most = low + heights[0] / 2, high - heights[-1] / 2 - offsets[-1]
    return [max(least, min(m, most)) + offset for m, offset in zip(middles, offsets, strict=True)]


def _genes(names: str) -> str:
    return f"gene{'s' * (',' in names)} {names}"


def action_mark(a: ActionNode) -> str:
    """Return the note next to an action's name."""
    if a.range is not None:
        return f"[{a.range[0]:g}, {a.range[1]:g}]".replace("-", "−")
    return "automatic" if a.automatic else "if none" if a.neutral else ""


def legend(d: Diagram) -> list[tuple[Sign | str, str]]:
    """Return the legend: each kind of line in a drawing (a sign, "heritable" or "network") and its meaning."""
    reflex = {sign for r in d.reflexes for sign in (r.sign, *(s for _, s in r.sources))}
    happy = {sign for _, sign in d.happiness.sources} if d.happiness else set()
    entries: list[tuple[Sign | str, str]] = []
    for sign, (of_reflex, of_happiness) in MEANINGS.items():
        meanings = [of_reflex] * (sign in reflex) + [of_happiness] * (sign in happy)
        entries += [(sign, ", ".join(meanings))] * bool(meanings)
    heritable = any(r.gene for r in d.reflexes) or bool(d.happiness and d.happiness.genes)
    entries += [("heritable", "heritable: set by a gene")] * heritable
    if d.policy.layers:
        entries.append(("network", "policy: from all channels to one action in each group"))
    elif d.function:
        entries.append(("network", "function: from all channels to all actions"))
    return entries


class Layout:
    """The x of columns, the y of rows and boxes, and the size of a drawing."""

    def __init__(self, d: Diagram, values: Mapping[str, Any]) -> None:
        self.d = d
        self._texts(values)
        self._columns(values)
        self._rows()
        self._boxes()

    def _texts(self, values: Mapping[str, Any]) -> None:
        d = self.d
        self.sensor_lines = {s.first: wrapped(s.text, 44, 2 if len(s.channels) > 1 else 1) for s in d.sensors}
        self.hubs = [wrapped(r.label, 38, 3) + [cut(_genes(r.gene), 38)] * bool(r.gene) for r in d.reflexes]
        self.happy = wrapped(d.happiness.label, 38, 4) if d.happiness else []
        if d.happiness and d.happiness.genes:
            self.happy += wrapped(_genes(", ".join(d.happiness.genes)), 38, 2)
        if self.happy and "happiness" in values:
            self.happy = [*self.happy, f"now {values['happiness'][0]:.3g}"]

    def _columns(self, values: Mapping[str, Any]) -> None:
        d, bar = self.d, BAR + 0.5
        text = max((width(line, 8) for lines in self.sensor_lines.values() for line in lines), default=0.0)
        self.x_text = 0.3
        self.x_glyph = self.x_text + max(text, 0.8) + 0.24
        self.x_bracket = self.x_glyph + 0.33
        self.x_name = self.x_bracket + 0.08
        self.x_reading = self.x_name + max((width(cut(c), 9) for c in d.channels), default=0.0) + 0.14
        self.x_channel = self.x_reading + bar * ("readings" in values) + 0.06
        lines = [line for box in (*self.hubs, self.happy) for line in box]
        self.box = max(LEAST, *(width(line, 8) + 0.24 for line in lines)) if lines else LEAST
        self.x_box = self.x_channel + 1.15
        self.x_action = self.x_box + self.box + 0.85
        names = (width(cut(a.name, 28), 9, True) + width(action_mark(a), 8) for a in d.actions)
        acts = max(names, default=0.0)
        self.x_probability = self.x_action + 0.14 + acts + 0.2 + 0.22 * ("y" in values)
        self.x_group = self.x_probability + bar * ("probabilities" in values) + 0.06
        groups = max((width(cut(a.group, 24), 8) for a in d.actions), default=0.0)
        heading = max((width(a.section, 8.5, True) for a in d.actions), default=0.0)
        self.width = max(self.x_group + 0.2 + groups, self.x_action + heading, 6.5) + 0.3

    def shown(self, sensor: SensorNode) -> list[int]:
        """Return the rows of a sensor's channels to draw; −1 stands for omitted rows."""
        rows = list(range(sensor.first, sensor.first + len(sensor.channels)))
        if len(rows) <= MANY:
            return rows
        happy = self.d.happiness.sources if self.d.happiness else ()
        named = {row for sources in (*(r.sources for r in self.d.reflexes), happy) for row, _ in sources}
        kept = sorted({*rows[:2], rows[-1], *(named & set(rows))})
        after = zip(kept, [*kept[1:], kept[-1] + 1], strict=True)
        return [r for a, b in after for r in ([a] if b == a + 1 else [a, -1])]

    def _rows(self) -> None:
        """Compute the y of channels, actions and headings; both columns are centered vertically."""
        channels, left_heads, dots, left = self._left()
        actions, right_heads, right = self._right()
        hubs = sum(len(lines) * LINE + 0.1 + BETWEEN for lines in self.hubs)
        happy = (len(self.happy) + 1) * LINE + 0.14
        self.stack = [("policy", POLICY)] * bool(self.d.policy.layers)
        self.stack += [("function", FUNCTION)] * bool(self.d.function)
        self.stack += [("hubs", hubs)] * bool(self.hubs) + [("happiness", happy)] * bool(self.happy)
        self.top = 0.85
        self.body = max(left, right, sum(h + APART for _, h in self.stack) + APART, 0.6)
        self._legend(self.top + self.body + 0.42)
        a, b = (self.top + (self.body - length) / 2 for length in (left, right))
        self.channel_y = {row: y + a for row, y in channels.items()}
        self.action_y = {row: y + b for row, y in actions.items()}
        self.dots = [(y + a, n) for y, n in dots]
        self.headings = [(text, self.x_text, y + a) for text, y in left_heads]
        self.headings += [(text, self.x_action - 0.07, y + b) for text, y in right_heads]

    def _legend(self, y: float) -> None:
        """Place the legend entries on as many lines as they need, and set the height of the drawing."""
        self.legend: list[tuple[float, float, Sign | str, str]] = []
        x = self.x_text
        for sign, text in legend(self.d):
            long = 0.46 + width(text, 8)
            if x + long > self.width - 0.2 and x > self.x_text:
                x, y = self.x_text, y + 0.24
            self.legend.append((x, y, sign, text))
            x += long + 0.35
        self.height = y + 0.28

    def _left(self) -> tuple[dict[int, float], list[tuple[str, float]], list[tuple[float, int]], float]:
        rows: dict[int, float] = {}
        headings, dots = [], []
        y, kind = 0.0, ""
        for s in self.d.sensors:
            y += GAP if kind == s.kind else 0.12 * bool(kind)
            if s.kind != kind:
                headings.append((s.kind, y + HEADING / 2 - 0.02))
                y, kind = y + HEADING, s.kind
            shown = self.shown(s)
            for before, row, after in zip([0, *shown], shown, [*shown[1:], 0], strict=False):
                if row < 0:
                    dots.append((y + ROW / 2, after - before - 1))
                else:
                    rows[row] = y + ROW / 2
                y += ROW
        return rows, headings, dots, y

    def _right(self) -> tuple[dict[int, float], list[tuple[str, float]], float]:
        rows: dict[int, float] = {}
        headings = []
        y, section, group = 0.0, "", ""
        for a in self.d.actions:
            if a.section != section:
                y += 0.22 * bool(section)
                headings.append((a.section, y + HEADING / 2 - 0.02))
                y, section, group = y + HEADING, a.section, a.group
            y += GAP if a.group != group else 0
            rows[a.row], group = y + ROW / 2, a.group
            y += ROW + 0.02
        return rows, headings, y

    def _boxes(self) -> None:
        """Compute each box's center and height: networks are evenly spaced, reflexes close to their actions."""
        free = (self.body - sum(h for _, h in self.stack)) / (len(self.stack) + 1)
        self.boxes: dict[str, tuple[float, float]] = {}
        y = self.top
        for name, height in self.stack:
            self.boxes[name] = (y + free + height / 2, height)
            y += free + height
        self.hub_boxes = self._hubs() if self.hubs else {}

    def _hubs(self) -> dict[int, tuple[float, float]]:
        keys = [  # y of a reflex's action, then of its sensors, to reduce line crossings
            (self.action_y[r.action], float(np.mean([self.channel_y[row] for row, _ in r.sources] or [0])))
            for r in self.d.reflexes
        ]
        order = sorted(range(len(self.hubs)), key=lambda i: keys[i])
        heights = [len(self.hubs[i]) * LINE + 0.1 for i in order]
        wanted = [self.action_y[self.d.reflexes[i].action] for i in order]
        names = list(self.boxes)
        before, after = names[: names.index("hubs")], names[names.index("hubs") + 1 :]
        low, high = self.top, self.top + self.body
        if before:
            low = sum(self.boxes[before[-1]]) - self.boxes[before[-1]][1] / 2 + APART
        if after:
            high = self.boxes[after[0]][0] - self.boxes[after[0]][1] / 2 - APART
        return dict(zip(order, zip(spread(wanted, heights, low, high), heights, strict=True), strict=True))
