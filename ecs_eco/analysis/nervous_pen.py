"""The strokes of a nervous-system drawing, on axes in inches with y pointing down."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ecs_eco.analysis.formula_signs import Sign
from ecs_eco.analysis.nervous_diagram import SensorNode
from ecs_eco.analysis.nervous_layout import BAR
from ecs_eco.analysis.palette import ON_DARK
from ecs_eco.analysis.style import Axes

INK, GREY, SOFT, FAINT = "#1b1f23", "#5f6870", "#aab2ba", "#e6eaee"
GREEN, ORANGE, BLUE, RED = "#009E73", "#E69F00", "#0072B2", "#D55E00"
HUES = {1: GREEN, -1: RED}
POLICY, HAPPINESS, WEIGHTS, SECTOR = "#eaf3f9", "#fdf5e1", "#9cc4df", "#bcdcf0"
NIGHT = {
    **ON_DARK,
    GREY: "#98a5aa",
    SOFT: "#5f6c74",
    FAINT: "#283136",
    GREEN.lower(): "#2fc69b",
    ORANGE.lower(): "#e6a522",
    BLUE.lower(): "#4aa3dc",
    RED.lower(): "#ff8a4c",
    POLICY: "#15303f",
    HAPPINESS: "#352a0e",
    WEIGHTS: "#3f7599",
    SECTOR: "#2c5b7c",
}
"""Light-background colors of a drawing → their dark-background colors."""
NODE = 0.055  # radius
Point = tuple[float, float]


class Pen:
    """Draws on axes; overlapping elements are stacked in this order: lines, boxes, nodes, text."""

    def __init__(self, ax: Axes) -> None:
        self.ax = ax

    def patch(self, kind: str, *where: Any, **style: Any) -> None:
        """Draw a matplotlib patch."""
        from matplotlib import patches

        self.ax.add_patch(getattr(patches, kind)(*where, **style))

    def text(
        self, x: float, y: float, text: str, size: float = 8, hue: str = GREY, bold: bool = False, **more: Any
    ) -> None:
        """Draw text that is vertically centered on y."""
        font: Any = {"fontsize": size, "family": "DejaVu Sans", "weight": "bold" if bold else "normal"}
        self.ax.text(x, y, text, color=hue, va="center", zorder=10, **font, **more)

    def line(
        self, x: Sequence[float], y: Sequence[float], hue: str = SOFT, width: float = 1.0, zorder: float = 1
    ) -> None:
        """Draw a straight line or a polyline."""
        self.ax.plot(x, y, color=hue, lw=width, zorder=zorder, solid_capstyle="butt", solid_joinstyle="round")

    def block(self, x: float, y: float, wide: float, high: float, hue: str, zorder: float) -> None:
        """Draw a rectangle that starts at x and is vertically centered on y."""
        self.patch("Rectangle", (x, y - high / 2), wide, high, facecolor=hue, lw=0, zorder=zorder)

    def polygon(self, corners: Sequence[Point], hue: str, zorder: float) -> None:
        """Draw a filled polygon."""
        self.patch("Polygon", corners, facecolor=hue, lw=0, zorder=zorder)

    def circle(self, x: float, y: float, radius: float, face: str, edge: str = "none", **more: Any) -> None:
        """Draw a filled circle."""
        style = {"facecolor": face, "edgecolor": edge, "lw": 1.1, "zorder": 9, **more}
        self.patch("Circle", (x, y), radius, **style)

    def box(
        self, x: float, y: float, wide: float, high: float, face: str, edge: str, style: Any = "-"
    ) -> None:
        """Draw a box with rounded corners that starts at x and is vertically centered on y."""
        corners = f"round,pad=0,rounding_size={min(0.09, high / 3):.3f}"
        style = {
            "boxstyle": corners,
            "facecolor": face,
            "edgecolor": edge,
            "lw": 1.1,
            "ls": style,
            "zorder": 4,
        }
        self.patch("FancyBboxPatch", (x, y - high / 2), wide, high, **style)

    def curve(self, start: Point, end: Point, sign: Sign, dotted: bool = False, width: float = 1.6) -> None:
        """Draw a curved connection that is horizontal at both ends."""
        from matplotlib.path import Path

        (x, y), (to_x, to_y) = start, end
        bend = (to_x - x) / 2
        path = Path(
            [(x, y), (x + bend, y), (to_x - bend, to_y), (to_x, to_y)], [Path.MOVETO, *[Path.CURVE4] * 3]
        )
        self.patch("PathPatch", path, fill=False, zorder=3, capstyle="butt", **look(sign, dotted, width))

    def end(self, x: float, y: float, sign: Sign, size: float = 0.1) -> None:
        """Draw the end of a connection: an arrow if it forces, a bar if it blocks, both if it varies."""
        hue = look(sign)["color"]
        if sign == -1:
            self.line([x - size, x - 0.02], [y, y], hue, 1.6, 8)
        else:
            self.head(x, y, hue, size)
        if sign in (-1, None):
            self.line([x - 0.015] * 2, [y - size * 0.65, y + size * 0.65], hue, 2.2, 8)

    def head(self, x: float, y: float, hue: str, size: float) -> None:
        """Draw an arrowhead that points to the right."""
        self.polygon([(x, y), (x - size, y - size * 0.45), (x - size, y + size * 0.45)], hue, 8)

    def bracket(self, x: float, top: float, bottom: float, side: float) -> None:
        """Draw a bracket whose back is at x; its ends reach to x + `side`."""
        self.line([x + side, x, x, x + side], [top, top, bottom, bottom], SOFT, 1)

    def bar(self, x: float, y: float, value: float, zero: float) -> None:
        """Draw a number as digits and as a bar whose origin is at `zero`, a fraction of the width."""
        origin = x + zero * BAR
        self.block(x, y, BAR, 0.1, FAINT, 1)
        self.block(origin, y, float(np.clip(value, -1, 1)) * BAR * (1 - zero), 0.1, BLUE, 2)
        if zero:
            self.line([origin, origin], [y - 0.07, y + 0.07], GREY, 0.6, 3)
        self.text(x + BAR + 0.4, y, minus(f"{value:.2f}"), 7.5, INK, ha="right")

    def body(self, x: float, y: float, sensor: SensorNode) -> None:
        """Draw the body from above, facing up, with the position or the sector of a sensor."""
        r = 0.075
        if sensor.sector is not None:
            begin, end = sensor.sector
            angles = np.linspace(begin, end if end > begin else end + 2 * math.pi, 40)
            inner, outer = 0.0 if sensor.vision else r, 0.125
            ring = [(x - outer * math.sin(a), y - outer * math.cos(a)) for a in angles]
            back = [(x - inner * math.sin(a), y - inner * math.cos(a)) for a in angles[::-1]]
            self.polygon(ring + back, SECTOR if sensor.vision else ORANGE, 2)
        self.circle(x, y, r, "white", SOFT, lw=0.9, zorder=3)
        self.polygon([(x - 0.022, y - r + 0.012), (x + 0.022, y - r + 0.012), (x, y - r - 0.028)], SOFT, 3)
        if sensor.at is not None:
            forward, left = np.clip(sensor.at, -1.5, 1.5)
            self.circle(x - r * left, y - r * forward, 0.03, RED, "white", lw=0.5, zorder=4)
        elif sensor.kind == "interoception":
            self.circle(x, y, 0.03, RED, zorder=4)


def look(sign: Sign, dotted: bool = False, width: float = 1.6) -> dict[str, Any]:
    """Return a line's style: green if it forces, dashed red if it blocks, gray if not sure, dotted if heritable."""
    style: Any = (0, (1, 1.2)) if dotted else (0, (4, 1.6)) if sign == -1 else "-"
    return {"color": SOFT if sign == 0 else HUES.get(sign or 0, GREY), "lw": width, "ls": style}


def minus(text: str) -> str:
    """Replace the hyphens in a number or formula with minus signs."""
    return text.replace("-", "−")
