"""Draws nervous systems, with contents from nervous_diagram.py, nervous_layout.py and nervous_pen.py."""

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.nervous_diagram import ActionNode, Diagram, SensorNode, diagram, nervous_species
from ecs_eco.analysis.nervous_layout import LINE, Layout, action_mark, cut, width
from ecs_eco.analysis.nervous_pen import (
    BLUE,
    GREY,
    HAPPINESS,
    HUES,
    INK,
    NIGHT,
    NODE,
    ORANGE,
    POLICY,
    SOFT,
    WEIGHTS,
    Pen,
    look,
    minus,
)
from ecs_eco.analysis.page import write_text
from ecs_eco.analysis.style import Figure, as_delivered, empty, save_as, svg_of
from ecs_eco.analysis.svg import themed
from ecs_eco.config import WorldConfig
from ecs_eco.engine.errors import ConfigError, Problem, UnknownName, unknown_name

VALUES = ("readings", "y", "probabilities", "decision", "happiness")
BUS = {"policy": 0.24, "function": 0.32, "happiness": 0.4}  # distance of bundled lines from the channels


def draw_nervous_system(config: WorldConfig, species: str, values: Mapping[str, Any] | None = None) -> Figure:
    """Draw the nervous system of a species.

    Parameters
    ----------
    config : WorldConfig
    species : str
    values : Mapping of str to array, optional
        State of one organism to show: readings f32[channels], reflex i8[actions], probability f32[actions],
        decision u8[actions] and happiness; see `ecs_eco.view.inspect.drawable`.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ConfigError
        If the species has neither sensors nor actions.
    UnknownName
        If the name of a value is unknown.
    ValueError
        If a value has the wrong length.

    Examples
    --------
    >>> from ecs_eco.analysis.nervous_figure import draw_nervous_system, save
    >>> from ecs_eco.config import load
    >>> save(draw_nervous_system(load("predator-prey"), "deer"), "deer.svg").name
    'deer.svg'
    """
    d = diagram(config, species)
    return _figure([_Drawing(d, _checked(values or {}, d))])


def draw_nervous_systems(config: WorldConfig, species: Sequence[str] = ()) -> Figure:
    """Draw the nervous systems of several species (default: all), one below the other."""
    names = list(species) or nervous_species(config)
    if not names:
        fault = "no species has sensors or actions"
        expected = "a world with a species that has a nervous system"
        raise ConfigError([Problem((), fault, config.name, expected, source="WORLD")])
    return _figure([_Drawing(diagram(config, name), {}) for name in names])


def save(figure: Figure, path: Path | str, dpi: int = 150) -> Path:
    """Write a figure as PNG, SVG or PDF, completely or not at all.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    path : str or Path
        The file extension determines the format.
    dpi : int, default 150
        Resolution of a PNG [dots per inch].

    Returns
    -------
    Path

    Notes
    -----
    The same figure always produces the same file. An SVG follows the light or dark theme of the system or page.

    Examples
    --------
    >>> from ecs_eco.analysis.nervous_figure import draw_nervous_system, save
    >>> from ecs_eco.config import load
    >>> save(draw_nervous_system(load("predator-prey"), "deer"), "deer.png").name
    'deer.png'
    """
    undated: dict[str, dict[str, Any]] = {"pdf": {"CreationDate": None}, "png": {"Software": None}}
    kind = Path(path).suffix[1:].lower()
    if kind == "svg":
        text = svg_of(figure)
        return write_text(Path(path), themed(text, text, NIGHT))
    return save_as(kind, figure, path, dpi, {"metadata": undated.get(kind)})


def _checked(values: Mapping[str, Any], d: Diagram) -> dict[str, np.ndarray]:
    """Return the values as arrays, after checking their names and lengths."""
    lengths = dict.fromkeys(VALUES, len(d.actions)) | {"readings": len(d.channels), "happiness": 1}
    arrays: dict[str, np.ndarray] = {}
    for name, value in values.items():
        if name not in lengths:
            raise UnknownName(unknown_name("draw_nervous_system", "value", name, VALUES))
        if value is None:
            continue
        arrays[name] = np.asarray(value, np.float64).reshape(-1)
        if len(arrays[name]) != lengths[name]:
            fault = f"values[{name!r}] of {d.species} has {len(arrays[name])} numbers"
            raise ValueError(f"{fault}; expected {lengths[name]}")
    return arrays


class _Drawing:
    """The drawing of one nervous system."""

    def __init__(self, d: Diagram, values: dict[str, np.ndarray]) -> None:
        self.d, self.values, self.at = d, values, Layout(d, values)

    def draw(self, pen: Pen) -> None:
        """Draw everything on axes in inches; y points down."""
        self.pen = pen
        self._titles()
        for sensor in self.d.sensors:
            self._sensor(sensor)
        self._networks()
        for i in range(len(self.d.reflexes)):
            self._reflex(i)
        for action in self.d.actions:
            self._action(action)
        self._groups()
        self._legend()

    def _titles(self) -> None:
        d, at = self.d, self.at
        self.pen.text(at.x_text, 0.3, d.species, 14, INK, bold=True)
        reflexes = len(d.reflexes) + bool(d.function)
        policy = {
            "none": "no policy network",
            "shared": "a shared policy network",
            "external": "decisions from outside",
            "function": "a function as policy",
        }.get(d.policy.kind, "one policy network per organism")
        counts = f"{_count(len(d.channels), 'channel')}, {_count(len(d.actions), 'action')}"
        self.pen.text(
            at.x_text, 0.54, f"{d.world}: {counts}, {_count(reflexes, 'reflex', 'es')}, {policy}", 8.5
        )
        for text, x, y in at.headings:
            self.pen.text(x, y, text, 8.5, bold=True)
        for y, n in at.dots:
            self.pen.text(at.x_name, y, f"… {n} more", style="italic")

    def _sensor(self, s: SensorNode) -> None:
        at, rows = self.at, [r for r in self.at.shown(s) if r >= 0]
        first, last = at.channel_y[rows[0]], at.channel_y[rows[-1]]
        lines, middle = at.sensor_lines[s.first], (first + last) / 2
        for i, line in enumerate(lines):
            self.pen.text(at.x_glyph - 0.24, middle + (i - (len(lines) - 1) / 2) * 0.15, line, ha="right")
        self.pen.body(at.x_glyph, middle, s)
        if len(rows) > 1:
            self.pen.bracket(at.x_bracket - 0.04, first - 0.08, last + 0.08, 0.05)
        for row in rows:
            y = at.channel_y[row]
            self.pen.text(at.x_name, y, cut(self.d.channels[row]), 9, INK)
            self.pen.circle(at.x_channel, y, NODE, "white", INK)
            if "readings" in self.values:
                self.pen.bar(at.x_reading, y, self.values["readings"][row], 0.5)

    def _action(self, a: ActionNode) -> None:
        at, y, x = self.at, self.at.action_y[a.row], self.at.x_action + 0.14
        continuous = a.range is not None
        on = not continuous and "decision" in self.values and bool(self.values["decision"][a.row] > 0)
        self.pen.circle(at.x_action, y, NODE * 1.2, BLUE if on else "white", INK)
        name = cut(a.name, 28)
        if continuous and "decision" in self.values:
            name += f" = {self.values['decision'][a.row]:.3g}".replace("-", "−")
        self.pen.text(x, y, name, 9, INK, bold=on)
        x += width(name, 9, on) + 0.09
        self.pen.text(x, y, action_mark(a), style="italic")
        if "y" in self.values and (sign := int(np.sign(self.values["y"][a.row]))):
            x += width(action_mark(a), 8) + (0.08 if continuous else 0.03) * bool(action_mark(a))
            worth = f"{self.values['y'][a.row] if continuous else sign:+.2g}".replace("-", "−")
            self.pen.text(x, y, worth, 8, HUES[sign], bold=True)
        if "probabilities" in self.values and np.isfinite(p := self.values["probabilities"][a.row]):
            self.pen.bar(at.x_probability, y, p, 0.0)

    def _groups(self) -> None:
        for group in dict.fromkeys(a.group for a in self.d.actions):
            ys = [self.at.action_y[a.row] for a in self.d.actions if a.group == group]
            if len(ys) > 1:
                self.pen.bracket(self.at.x_group, min(ys) - 0.08, max(ys) + 0.08, -0.05)
            self.pen.text(self.at.x_group + 0.1, (min(ys) + max(ys)) / 2, cut(group, 24))

    def _networks(self) -> None:
        """Draw the boxes of the networks and their lines."""
        for name, (y, height) in self.at.boxes.items():
            if name in ("policy", "function"):
                self._bus_in(name, y)
                self._bus_out(name, y, [a.row for a in self.d.actions if a.chosen or name == "function"])
            if name == "policy":
                self._policy(y, height)
            elif name == "function":
                self.pen.box(self.at.x_box, y, self.at.box, height, "white", GREY)
                self._say(y - 0.11, "reflex function", 9, INK, bold=True)
                self._say(y + 0.11, cut(self.d.function, 34))
            elif name == "happiness":
                self._happiness(y, height)

    def _say(self, y: float, text: str, size: float = 8, hue: str = GREY, **more: Any) -> None:
        """Draw text centered on the column of boxes."""
        self.pen.text(self.at.x_box + self.at.box / 2, y, text, size, hue, ha="center", **more)

    def _bus_in(self, name: str, y: float) -> None:
        """Draw lines from all channels, bundled before they enter a box."""
        x, at, ys = self.at.x_channel, self.at.x_channel + BUS[name], list(self.at.channel_y.values())
        for channel in ys:
            self.pen.line([x, at], [channel, channel], width=0.7)
        if ys:
            self.pen.line([at, at], [min(*ys, y), max(*ys, y)], width=1.2)
            self.pen.line([at, self.at.x_box - 0.06], [y, y], width=1.6)
            self.pen.head(self.at.x_box - 0.01, y, SOFT, 0.1)

    def _bus_out(self, name: str, y: float, rows: Iterable[int]) -> None:
        """Draw a line that leaves a box and branches to actions."""
        x, at = self.at.x_action - NODE - 0.02, self.at.x_action - BUS[name] - 0.16
        ys = [self.at.action_y[row] for row in rows]
        for action in ys:
            self.pen.line([at, x - 0.03], [action, action], width=0.7)
            self.pen.head(x, action, SOFT, 0.07)
        if ys:
            self.pen.line([at, at], [min(*ys, y), max(*ys, y)], width=1.2)
            self.pen.line([self.at.x_box + self.at.box, at], [y, y], width=1.6)

    def _policy(self, y: float, height: float) -> None:
        policy, middle = self.d.policy, self.at.x_box + self.at.box / 2
        self.pen.box(self.at.x_box, y, self.at.box, height, POLICY, BLUE)
        self._say(y - 0.41, "policy network", 9, INK, bold=True)
        n = len(policy.layers)
        xs = np.linspace(middle - 0.8, middle + 0.8, n).tolist()
        tall = [0.14 + 0.28 * min(1.0, math.log2(1 + units) / 8) for units in policy.layers]
        for i in range(n - 1):
            for a, b in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
                ends = [y - 0.05 + a * tall[i] / 2, y - 0.05 + b * tall[i + 1] / 2]
                self.pen.line(xs[i : i + 2], ends, WEIGHTS, 0.7, 5)
        for x, high in zip(xs, tall, strict=True):
            self.pen.block(x - 0.035, y - 0.05, 0.07, high, BLUE, 6)
        self._say(y + 0.27, policy.way, 8, INK)
        inherited = f", inherited: {policy.inherit}" * (policy.inherit != "none")
        self._say(y + 0.43, policy.kind + ", learns" * policy.learns + inherited)

    def _happiness(self, y: float, height: float) -> None:
        assert self.d.happiness is not None
        self.pen.box(self.at.x_box, y, self.at.box, height, HAPPINESS, ORANGE)
        top = y - height / 2 + 0.07 + LINE / 2
        self._say(top, "happiness", 9, INK, bold=True)
        for i, line in enumerate(self.at.happy, 1):
            now = "happiness" in self.values and i == len(self.at.happy)
            self._say(top + i * LINE, minus(line), 8, INK if now else GREY, bold=now)
        if not self.d.happiness.sources:
            self._bus_in("happiness", y)
        sources = self._from_the_top(self.d.happiness.sources)
        for (row, sign), inlet in zip(sources, _inlets(y, height - 0.12, len(sources)), strict=True):
            dotted = row in self.d.happiness.heritable
            start = self.at.x_channel + NODE, self.at.channel_y[row]
            self.pen.curve(start, (self.at.x_box - 0.07, inlet), sign, dotted, 1.2)
            self.pen.end(self.at.x_box - 0.01, inlet, sign, 0.075)

    def _reflex(self, i: int) -> None:
        """Draw the labeled box of a reflex, lines from its sensors, and a line to its action."""
        at, r, (y, height) = self.at, self.d.reflexes[i], self.at.hub_boxes[i]
        sources, lines, heritable = self._from_the_top(r.sources), at.hubs[i], bool(r.gene)
        for (row, sign), inlet in zip(sources, _inlets(y, height - 0.06, len(sources)), strict=True):
            self.pen.curve((at.x_channel + NODE, at.channel_y[row]), (at.x_box, inlet), sign, heritable)
        self.pen.box(at.x_box, y, at.box, height, "white", look(r.sign)["color"], ":" if heritable else "-")
        for k, line in enumerate(lines):
            where = y + (k - (len(lines) - 1) / 2) * LINE
            if heritable and k == len(lines) - 1:
                self._say(where, line, style="italic")
            else:
                self._say(where, minus(line), 8, INK)
        end = self._arrival(i)
        self.pen.curve((at.x_box + at.box, y), (at.x_action - NODE - 0.1, end), r.sign, heritable)
        self.pen.end(at.x_action - NODE - 0.02, end, r.sign)

    def _arrival(self, i: int) -> float:
        """Return the y at which a reflex's line reaches its action, with one y per sign."""
        r, boxes = self.d.reflexes[i], self.at.hub_boxes
        others = sorted(
            (k for k, o in enumerate(self.d.reflexes) if o.action == r.action), key=lambda k: boxes[k]
        )
        signs = list(dict.fromkeys(self.d.reflexes[k].sign for k in others))
        return _inlets(self.at.action_y[r.action], 0.1 * len(signs), len(signs))[signs.index(r.sign)]

    def _from_the_top(self, sources: Iterable[tuple[int, Any]]) -> list[tuple[int, Any]]:
        return sorted(sources, key=lambda source: self.at.channel_y[source[0]])

    def _legend(self) -> None:
        for x, y, sign, text in self.at.legend:
            if sign == "network":
                self.pen.line([x, x + 0.36], [y, y], width=1.6)
            elif isinstance(sign, str):
                self.pen.ax.plot([x, x + 0.36], [y, y], **look(None, True))
            else:
                self.pen.ax.plot([x, x + 0.28], [y, y], **look(sign))
                self.pen.end(x + 0.38, y, sign)
            self.pen.text(x + 0.46, y, text)


def _figure(drawings: list[_Drawing]) -> Figure:
    """Return a figure with several drawings, one below the other, each on axes of the right size."""
    with as_delivered({"text.parse_math": False}):
        wide, high = max(x.at.width for x in drawings), sum(x.at.height for x in drawings)
        figure = empty(wide, high)
        bottom = high
        for drawing in drawings:
            bottom -= drawing.at.height
            ax = figure.add_axes((0, bottom / high, 1, drawing.at.height / high))
            ax.set(xlim=(0, wide), ylim=(drawing.at.height, 0))
            ax.axis("off")
            drawing.draw(Pen(ax))
    return figure


def _count(n: int, word: str, plural: str = "s") -> str:
    return f"{n or 'no'} {word}{plural if n != 1 else ''}"


def _inlets(y: float, height: float, n: int) -> list[float]:
    """Return the y of n lines that enter a box, from top to bottom."""
    return [y + ((i + 0.5) / n - 0.5) * height for i in range(n)]
