"""Pictures of a recorded run without a browser: the world and its population sizes."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.analysis.land import draw_land
from ecs_eco.analysis.palette import safe
from ecs_eco.analysis.relief import LAND, Relief, draw_relief
from ecs_eco.analysis.style import as_delivered
from ecs_eco.engine import files
from ecs_eco.view.film import Scene
from ecs_eco.view.interpolate import Organisms
from ecs_eco.view.replay import Replay

ROUND = np.linspace(-np.pi / 2, np.pi / 2, 9)  # angles along the rounded end of a capsule


def outlines(
    shape: str, places: np.ndarray, heading: np.ndarray, size: Sequence[np.ndarray], side: bool = False
) -> np.ndarray:
    """Return the corners of capsules or boxes f64[n, corners, 2] [m], seen from above or, with `side`, along
    the y axis. `places` f64[n, 2] are their centers; `size` has lengths, widths, heights f64[n]."""
    length, width, height = (np.asarray(s, float)[:, None] / 2 for s in size)
    cos, sin = np.cos(heading)[:, None], np.sin(heading)[:, None]
    if side:  # bodies that face toward or away from the viewer look shorter
        inner = width if shape == "capsule" else np.zeros_like(width)
        length = abs(cos) * (length - inner) + abs(sin) * (width - inner) + inner
        width, cos, sin = height, np.ones_like(cos), np.zeros_like(sin)
    if shape == "capsule":
        cap = np.maximum(length - width, 0)
        x = np.concatenate([cap + width * np.cos(ROUND), -cap - width * np.cos(ROUND)], axis=1)
        y = np.concatenate([width * np.sin(ROUND), width * np.sin(-ROUND)], axis=1)
    else:
        x, y = length * np.array([[1, -1, -1, 1]]), width * np.array([[1, 1, -1, -1]])
    return places[:, None] + np.stack([x * cos - y * sin, x * sin + y * cos], axis=2)


INK, SOFT, PAPER = "#22282e", "#7a838c", "#ffffff"
NIGHT = (0.05, 0.07, 0.16)
DEEP, BRIGHT = (0.03, 0.06, 0.15), (0.72, 0.87, 0.95)  # color of the sea in darkness and in full light
# arrow of unit length along the heading, as the page draws moving organisms
DART = np.array([[1.0, 0.0], [-0.75, 0.58], [-0.4, 0.0], [-0.75, -0.58]])
LEAST = {"moves": 5.5, "stays": 1.5}  # [px] minimum size of a body in a picture 720 px high
LEVELS = 128  # number of depths at which light is drawn


class Painter:
    """Paints ticks of a recorded run as pictures.

    Parameters
    ----------
    replay : Replay
    size : tuple of int, default (1280, 720)
        Width and height [px].
    scenes : sequence of film.Scene
        Scenes whose captions are written into the pictures.

    Examples
    --------
    >>> from pathlib import Path
    >>> from ecs_eco.runs.run import run_to_folder
    >>> from ecs_eco.view.paint import Painter
    >>> from ecs_eco.view.replay import Replay
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=5, out="my-run", report=False)
    >>> painter = Painter(Replay("my-run"), (320, 180))
    >>> painter.paint(3).shape, painter.save(3, Path("tick.png")).name
    ((180, 320, 3), 'tick.png')
    """

    def __init__(
        self, replay: Replay, size: tuple[int, int] = (1280, 720), scenes: Sequence[Scene] = ()
    ) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.replay, self.size, self.scenes = replay, size, scenes
        hello = replay.hello()
        self.kinds: list[dict[str, Any]] = hello["species"]
        species, things = (
            {kind["name"]: str(kind["color"]) for kind in kinds} for kinds in (self.kinds, hello["objects"])
        )
        self.hues = safe(species, things)
        self.rims = rims(self.kinds, self.hues)
        self.volume = len(replay.recording.size) == 3
        self.extent = (replay.recording.size[0], replay.recording.size[2 if self.volume else 1])
        self.unit = size[1] / 720
        with as_delivered({"font.size": 10.0, "text.parse_math": False, "path.simplify_threshold": 0.5}):
            self.figure = Figure(
                figsize=(size[0] / 100 / self.unit, size[1] / 100 / self.unit),
                dpi=100 * self.unit,
                facecolor=PAPER,
            )
            self.canvas = FigureCanvasAgg(self.figure)
            self._lay_out(hello)
            self.moving = [artist for artist in self._moving() if artist is not None]
            for artist in self.moving:
                artist.set_animated(True)
            self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(self.figure.bbox)

    def paint(self, tick: int) -> np.ndarray:
        """Return the picture of a tick.

        Parameters
        ----------
        tick : int

        Returns
        -------
        array of uint8, shape (height, width, 3)
        """
        self.replay.handle({"kind": "seek", "tick": tick})
        light, _ = self.replay.sky()
        self._light(tick, light)
        for kind in self.kinds:
            self._organisms(kind, self.replay.organisms(kind["name"]))
        self._land(tick)
        self._strips(tick)
        self._words(tick)
        self.canvas.restore_region(self.still)
        for artist in (*self.land, *self.moving):
            (artist.axes or self.figure).draw_artist(artist)
        return np.asarray(self.canvas.buffer_rgba())[..., :3].copy()

    def save(self, tick: int, path: Path) -> Path:
        """Write the picture of a tick as a PNG.

        Parameters
        ----------
        tick : int
        path : Path

        Returns
        -------
        Path
        """
        from PIL import Image

        path.parent.mkdir(parents=True, exist_ok=True)
        with files.writing(path) as beside:
            Image.fromarray(self.paint(tick)).save(beside, format="png")
        return path

    def _lay_out(self, hello: dict[str, Any]) -> None:
        """Create the axes: the world, and a strip for each species to its right or, in a wide world, below."""
        wide, high = self.size[0] / self.unit / 100, self.size[1] / self.unit / 100  # inches
        beside = self.extent[0] / self.extent[1] < 1.6
        room = (
            (0.55, 0.45, 0.56 * wide - 0.55, high - 0.95)
            if beside
            else (0.55, 0.3 * high + 0.5, wide - 0.8, 0.7 * high - 1.1)
        )
        scale = min(room[2] / self.extent[0], room[3] / self.extent[1])
        w, h = scale * self.extent[0], scale * self.extent[1]
        left, bottom = room[0] + (0 if beside else (room[2] - w) / 2), room[1] + (room[3] - h) / 2
        self.ax = self.figure.add_axes((left / wide, bottom / high, w / wide, h / high))
        self.scale = scale * 100  # px per meter in a picture 720 px high
        self._world()
        self.figure.text(
            0.35 / wide, 1 - 0.27 / high, hello["title"], size=13, weight="bold", color=INK, va="center"
        )
        k = len(self.kinds)
        if beside:
            x, top, each = (left + w + 0.5) / wide, 1 - 0.7 / high, (high - 1.25) / high / max(k, 2)
            places = [
                (x, top - (i + 1) * each + 0.12 / high, 1 - x - 0.25 / wide, each - 0.5 / high)
                for i in range(k)
            ]
        else:
            each = (wide - 0.5) / wide / max(k, 2)
            places = [
                (0.55 / wide + i * each, 0.42 / high, each - 0.45 / wide, 0.3 * high / high - 0.75 / high)
                for i in range(k)
            ]
        curves = self.replay.recording.curves
        # line of the past, cursor, count, ticks and numbers of each species
        self.strips: list[tuple[Any, Any, Any, np.ndarray, np.ndarray]] = []
        for i, (kind, place) in enumerate(zip(self.kinds, places, strict=True)):
            last = not beside or i == k - 1
            self._strip(kind, place, curves["tick"], curves["n"][kind["name"]], last)
        for i, (name, places_of) in enumerate(self.replay.recording.objects.items()):
            x = (left + w + 0.5 if beside else 0.55) / wide + i * 1.2 / wide
            self.figure.text(
                x, 0.1 / high, f"● {len(places_of)} {name}", size=8.5, color=self.hues[name], va="center"
            )
        self.clock = self.figure.text(
            1 - 0.25 / wide, 1 - 0.27 / high, "", size=11, color=INK, ha="right", va="center"
        )
        self.width = round(w * 100 / 8)  # of a caption [letters]
        box: dict[str, Any] = {"facecolor": PAPER, "edgecolor": "none", "alpha": 0.85, "pad": 5}
        middle: dict[str, Any] = {"ha": "center", "va": "bottom", "transform": self.ax.transAxes, "zorder": 9}
        self.caption = self.ax.text(0.5, 0.02, "", size=10.5, color=INK, bbox=box, **middle)
        self.hint = self.figure.text(
            1 - 0.25 / wide, 0.1 / high, "", size=7.5, color=SOFT, ha="right", va="center"
        )

    def _world(self) -> None:
        ax, (w, h) = self.ax, self.extent
        ax.set(xlim=(0, w), ylim=(0, h), facecolor=LAND)
        ax.tick_params(labelsize=8, colors=SOFT, length=3)
        for spine in ax.spines.values():
            spine.set_color(SOFT)
        ax.set_xlabel("x [m]", size=8, color=SOFT, labelpad=1)
        ax.set_ylabel("depth [m]" if self.volume else "y [m]", size=8, color=SOFT, labelpad=1)
        if self.volume:
            at = [t for t in ax.get_yticks() if 0 <= t <= h]
            ax.set_yticks([h - t for t in at], [f"{t:g}" for t in at])
        elif (terrain := getattr(self.replay.recording.scene, "terrain", None)) is not None:
            draw_relief(ax, Relief.of(terrain), self.extent)
        for name, lying in self.replay.recording.objects.items():
            kind = next(kind for kind in self.replay.hello()["objects"] if kind["name"] == name)
            centres, (heading, *sides) = lying[:, [0, 2 if self.volume else 1]], lying[:, 3:].T
            if kind.get("shape"):
                corners = outlines(kind["shape"], centres, heading, sides, self.volume)
                ax.add_collection(self._shapes(corners, self.hues[name], linewidth=0, alpha=0.8))
                continue
            size = max(kind["radius"] * self.scale, LEAST["moves"])
            self._discs(centres[:, 0], centres[:, 1], size, self.hues[name], 0.6)

    def _strip(
        self, kind: dict[str, Any], place: tuple[float, ...], ticks: np.ndarray, n: np.ndarray, labelled: bool
    ) -> None:
        """Draw a species' population over time, with the future faded, and its marker and name above."""
        name, hue = kind["name"], self.hues[kind["name"]]
        left, bottom, width, height = place
        ax = self.figure.add_axes((left, bottom, width, height))
        ax.plot(ticks, n, color=hue, lw=1.0, alpha=0.35)
        past = ax.plot([], [], color=hue, lw=1.6)[0]
        ax.set(xlim=(ticks[0], max(ticks[-1], ticks[0] + 1)), ylim=(0, max(n.max(initial=0) * 1.08, 1)))
        ax.tick_params(labelsize=8, colors=SOFT, length=2.5)
        from matplotlib import ticker

        ax.yaxis.set_major_locator(ticker.MaxNLocator(3, integer=True))
        ax.xaxis.set_major_locator(ticker.MaxNLocator(5, integer=True))
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_formatter(lambda v, _: f"{v:,.0f}")
        for side, spine in ax.spines.items():
            spine.set_visible(side in ("left", "bottom"))
            spine.set_color(SOFT)
        if labelled:
            ax.set_xlabel("tick", size=8, color=SOFT, labelpad=1)
        else:
            ax.tick_params(labelbottom=False)
        cursor = ax.axvline(ticks[0], color=INK, lw=0.9)
        y = bottom + height + 0.17 / (self.size[1] / self.unit / 100)
        wide, high = self.size[0] / self.unit, self.size[1] / self.unit  # in units of a picture 720 px high
        sign = self.figure.add_axes((left, y - 8 / high, 16 / wide, 16 / high))
        sign.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3))
        sign.axis("off")
        around = np.linspace(0, 2 * np.pi, 32)
        shape = DART.T if kind["moves"] else 0.6 * np.array([np.cos(around), np.sin(around)])
        sign.fill(*shape, facecolor=hue, **self.rims[name])
        self.figure.text(left + 22 / wide, y, name, size=10.5, color=INK, va="center")
        count = self.figure.text(left + width, y, "", size=10.5, color=INK, va="center", ha="right")
        self.strips.append((past, cursor, count, ticks, n))

    def _moving(self) -> list[Any]:
        self.land: list[Any] = []
        self.ground: Any = None
        self.shade = self.light = None
        (w, h), none = self.extent, np.zeros(0)
        if self.volume:
            dark = np.zeros((LEVELS, 1, 3))
            self.light = self.ax.imshow(
                dark, extent=(0, w, 0, h), origin="lower", aspect="auto", interpolation="bilinear"
            )
        elif self.replay.hello()["day"] is not None:
            self.shade = self.ax.imshow(np.zeros((1, 1, 4)), extent=(0, w, 0, h), aspect="auto", zorder=1.5)
        self.bodies: dict[str, Any] = {}
        for kind in sorted(self.kinds, key=lambda kind: kind["moves"]):
            hue = self.hues[kind["name"]]
            if kind["moves"] or kind.get("shape"):
                self.bodies[kind["name"]] = self._shapes([], hue, **self.rims[kind["name"]])
                self.ax.add_collection(self.bodies[kind["name"]])
            else:
                radius = max(kind["radius"] * self.scale, LEAST["stays"])
                self.bodies[kind["name"]] = self._discs(
                    none, none, radius, hue, 0.9, **self.rims[kind["name"]]
                )
        return [
            self.light,
            self.shade,
            *self.bodies.values(),
            *self.ax.spines.values(),
            *(artist for strip in self.strips for artist in strip[:3]),
            self.clock,
            self.hint,
            self.caption,
        ]

    def _discs(self, x: np.ndarray, y: np.ndarray, radius: float, hue: str, alpha: float, **rim: Any) -> Any:
        return self.ax.scatter(
            x,
            y,
            s=(2 * radius * 0.72) ** 2,
            facecolor=hue,
            alpha=alpha,
            marker="o",
            **(rim or {"linewidth": 0}),
        )

    def _shapes(self, corners: Any, hue: str, **rim: Any) -> Any:
        from matplotlib.collections import PolyCollection

        return PolyCollection(corners, facecolor=hue, clip_on=True, **rim)

    def _land(self, tick: int) -> None:
        """Redraw roads, fences and areas if they have changed."""
        land = self.replay.recording.land(tick)
        if self.volume or land == self.ground:
            return
        for artist in self.land:
            artist.remove()
        self.land, self.ground = draw_land(self.ax, land), land

    def _organisms(self, kind: dict[str, Any], organisms: Organisms) -> None:
        places = np.stack([organisms.x, organisms.z if self.volume else organisms.y], axis=1).astype(float)
        body = self.bodies[kind["name"]]
        if kind.get("shape"):
            size = [np.full(len(places), side) for side in kind["size"]]
            body.set_verts(outlines(kind["shape"], places, organisms.heading, size, self.volume))
            return
        if not kind["moves"]:
            body.set_offsets(places)
            return
        size = max(kind["radius"] * self.scale, LEAST["moves"]) / self.scale
        cos, sin = np.cos(organisms.heading), np.sin(organisms.heading)
        ahead, aside = (cos, sin), (-sin, cos)
        if self.volume:  # seen from the side: bodies that face toward or away from the viewer look shorter
            ahead = np.where(np.abs(cos) < 0.35, np.copysign(0.35, cos), cos), 0 * cos
            aside = 0 * cos, np.ones_like(cos)
        x, y = (
            np.stack(axis, axis=1)[:, None] * DART[None, :, i, None] for i, axis in enumerate((ahead, aside))
        )
        body.set_verts(places[:, None] + size * (x + y))

    def _light(self, tick: int, light: float) -> None:
        if self.shade is not None:
            self.shade.set_data(np.array([[[*NIGHT, 0.5 * (1 - light)]]]))
        if self.light is not None:
            share = self._by_depth(tick)[:, None, None] ** 0.35  # the eye perceives ratios
            self.light.set_data(np.array(DEEP) + share * (np.array(BRIGHT) - np.array(DEEP)))

    def _by_depth(self, tick: int) -> np.ndarray:
        """Return the light (0 to 1) from the floor to the surface: f64[LEVELS]."""
        scene = self.replay.recording.scene
        if scene is None:
            return np.ones(LEVELS)
        scene.tick = tick
        z = ((np.arange(LEVELS) + 0.5) / LEVELS * self.extent[1]).astype(np.float32)
        middle = [np.full(LEVELS, s / 2, np.float32) for s in self.replay.recording.size[:2]]
        return np.clip(scene.surroundings("light", *middle, z), 0, 1).astype(float)

    def _strips(self, tick: int) -> None:
        numbers = self.replay.recording.numbers(tick)
        for kind, (line, cursor, count, ticks, n) in zip(self.kinds, self.strips, strict=True):
            cursor.set_xdata([tick, tick])
            so_far = ticks <= tick
            line.set_data(ticks[so_far], n[so_far])
            count.set_text(f"{numbers[kind['name']]:,}")

    def _words(self, tick: int) -> None:
        r = self.replay.recording
        self.clock.set_text(f"tick {tick:,}  ·  {clock(tick * r.dt, self.replay.hello()['day'])}")
        said = next((scene.caption for scene in reversed(self.scenes) if scene.first <= tick), "")
        self.caption.set_text(textwrap.fill(said, self.width))
        self.caption.set_visible(bool(said))
        between = tick % r.every != 0 and not all(
            r.details[kind["name"]].rows and r.manifest.get("record") == "full"
            for kind in self.kinds
            if kind["moves"]
        )
        self.hint.set_text(
            f"positions are interpolated between snapshots (every {r.every} ticks)" if between else ""
        )


def rims(kinds: Sequence[dict[str, Any]], hues: dict[str, str]) -> dict[str, dict[str, Any]]:
    """Return each kind's edge style: black for every second mover, so that kinds differ in more than hue."""
    styles: dict[str, dict[str, Any]] = {}
    movers = [kind["name"] for kind in kinds if kind["moves"]]
    for kind in kinds:
        hue = [int(hues[kind["name"]][i : i + 2], 16) / 255 for i in (1, 3, 5)]
        light = 0.3 * hue[0] + 0.59 * hue[1] + 0.11 * hue[2] > 0.7
        edge, width = tuple(0.62 * part for part in hue), 0.35 if kind["moves"] or light else 0.0
        if kind["moves"] and movers.index(kind["name"]) % 2:
            edge, width = (0.0, 0.0, 0.0), 1.0
        styles[kind["name"]] = {"edgecolor": edge, "linewidth": width}
    return styles


def clock(seconds: float, day: dict[str, float] | None = None) -> str:
    """Return a world's time as text: "1 h 5 min", or the day and hour if the world has a sun."""
    if day is not None:
        since = seconds / day["length"] + day.get("start", 0.0)
        return (
            f"day {math.floor(since) + 1}, "
            f"{math.floor(since % 1 * 24):02d}:{math.floor(since * 24 % 1 * 60):02d}"
        )
    parts = []
    for word, length in (("d", 86_400), ("h", 3600), ("min", 60)):
        if seconds >= length:
            parts.append(f"{math.floor(seconds / length)} {word}")
            seconds %= length
    return " ".join([*parts, f"{seconds:g} s"][:2])
