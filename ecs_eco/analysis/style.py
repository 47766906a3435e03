"""Shared style of all figures: colors, lines, empty axes, and output to files."""

import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial, wraps
from io import BytesIO, StringIO
from itertools import cycle
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any, ParamSpec, TypeAlias

import numpy as np

from ecs_eco.analysis.palette import AXIS, GRID, INK, SAFE, SOFT, safe
from ecs_eco.analysis.runs import Series
from ecs_eco.analysis.svg import themed
from ecs_eco.engine import files

if TYPE_CHECKING:
    import matplotlib.axes
    import matplotlib.figure

P = ParamSpec("P")
Figure: TypeAlias = "matplotlib.figure.Figure"  # matplotlib is imported only for drawing
Axes: TypeAlias = "matplotlib.axes.Axes"

PALETTE = (*(SAFE[i][0] for i in (0, 1, 6, 2, 4, 3)), INK, SAFE[5][0])
"""Colors of species on a light background, in the order of Okabe and Ito, and the color of text."""
HUE = re.compile("#[0-9a-fA-F]{6}")  # the format that worlds allow; a manifest can contain anything
DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (6, 1.5, 1.5, 1.5)))
STYLE: dict[Any, Any] = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "axes.edgecolor": AXIS,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": AXIS,
    "ytick.color": AXIS,
    "xtick.labelcolor": SOFT,
    "ytick.labelcolor": SOFT,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "path.simplify_threshold": 0.5,
    "text.parse_math": False,  # a $ in a name or cause is not the start of a formula
}

HATCHES = ("", "////", "\\\\\\\\", "xx", "++", "||", "--", "//\\\\")

RASTER = 110  # dots per inch of images: relief and color maps

WIDEST = 9.9  # [inches] width of a report's page on a screen, on which text of 9 pt is 12 px high

_bare = False  # whether `as_delivered` has set matplotlib's defaults


def empty(width: float, height: float, **more: Any) -> Figure:
    """Return an empty figure of this size [inches], which notebooks can display."""
    import matplotlib.figure
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure: Any = matplotlib.figure.Figure(figsize=(width, height), **more)
    FigureCanvasAgg(figure)
    figure._repr_png_ = partial(_png, figure)  # matplotlib's method needs pyplot and its global state
    return figure


def _png(figure: Figure) -> bytes:
    file = BytesIO()
    with as_delivered({"text.parse_math": False}):
        figure.savefig(file, format="png", dpi=90, facecolor="white")
    return file.getvalue()


def panels(rows: int, columns: int, width: float, height: float, **more: Any) -> tuple[Figure, np.ndarray]:
    """Return a figure of this size [inches] with rows × columns of axes; five columns fit on a report's page."""
    width = min(width, max(WIDEST, WIDEST / 5 * columns))
    figure = empty(width, height, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **more)


def over_ticks(n: int, each: float, edge: float) -> tuple[Figure, list[Axes]]:
    """Return a figure with n rows of axes over the same ticks, each row `each` [inches] high, and a margin."""
    figure, axes = panels(n, 1, 9, each * n + edge, sharex=True)
    axes[-1, 0].set_xlabel("tick")
    return figure, list(axes[:, 0])


def fills(series: Series) -> dict[str, tuple[str, str]]:
    """Return the color and hatching of each cause of death: the eater's color, or one that no species has."""
    hue = colors_of(series)
    rest = cycle([colour for colour in PALETTE if colour not in hue.values()] or PALETTE)
    return {
        cause: (hue.get(cause.removeprefix("eaten by ")) or next(rest), HATCHES[i % len(HATCHES)])
        for i, cause in enumerate(series.causes)
    }


def several(
    n: int, most: int, each: tuple[float, float], edge: tuple[float, float], **more: Any
) -> tuple[Figure, np.ndarray]:
    """Return a figure with n axes of size `each` [inches] and a margin, with at most `most` per row."""
    columns = min(most, n)
    rows = -(-n // columns)
    figure, axes = panels(rows, columns, each[0] * columns + edge[0], each[1] * rows + edge[1], **more)
    for ax in axes.flat[n:]:
        ax.set_visible(False)
    return figure, axes


def grid_of_arms(
    runs: Mapping[str, Sequence[Any]],
    labels: Sequence[str],
    each: tuple[float, float],
    edge: float,
    time: str = "tick",
    **more: Any,
) -> tuple[Figure, np.ndarray]:
    """Return a figure with axes of size `each` [inches] over time for each arm (columns) and each label (rows)."""
    wide, high = each[0] * len(runs) + 1, each[1] * len(labels) + edge
    figure, axes = panels(len(labels), len(runs), wide, high, sharex=True, **more)
    for ax, (arm, members) in zip(axes[0], runs.items(), strict=True):
        ax.set_title(fill(f"{arm} (n = {len(members)})", max(12, int(9 * figure.get_figwidth() / len(runs)))))
    for ax, label in zip(axes[:, 0], labels, strict=True):
        ax.set_ylabel(label)
    for ax in axes[-1]:
        ax.set_xlabel(time)
    return figure, axes


def many_and_one(ax: Axes, x: np.ndarray, many: np.ndarray, one: np.ndarray, hue: str, **more: Any) -> None:
    """Plot a thin curve for each run [runs, x], and a thick curve that summarizes them."""
    ax.plot(x, np.transpose(many), color=hue, lw=0.6, alpha=0.5)
    ax.plot(x, one, color=hue, **{"lw": 2, **more})


def mean_and_sd(ax: Axes, x: np.ndarray, mean: np.ndarray, sd: np.ndarray) -> None:
    """Plot a mean, and lines one standard deviation above and below it."""
    ax.plot(x, mean, color=INK, lw=1.6, label="mean")
    for sign, label in ((-1, None), (1, "± 1 standard deviation")):
        ax.plot(x, mean + sign * sd, color=INK, lw=0.9, ls=(0, (4, 2)), label=label)


@contextmanager
def as_delivered(chosen: Mapping[Any, Any]) -> Iterator[None]:
    """Use matplotlib's defaults with our settings; restore the user's settings afterwards. A `matplotlibrc` in the
    working folder, perhaps from a downloaded world, could otherwise make TeX set all text. Characters missing
    from the font become boxes, without a warning. Within `as_delivered({})`, the defaults are not set again,
    because that is slow."""
    global _bare
    import matplotlib

    before = _bare
    with matplotlib.rc_context(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from", UserWarning)
        if not before:
            matplotlib.rcdefaults()
        matplotlib.rcParams.update(chosen)
        _bare = not chosen
        try:
            yield
        finally:
            _bare = before


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Draw in our style, regardless of the user's settings."""

    @wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure:
        from matplotlib.ticker import LogFormatter

        with as_delivered(STYLE):
            figure = draw(*args, **kwargs)
        for ax in figure.axes:
            for axis in (ax.xaxis, ax.yaxis):
                if isinstance(axis.get_major_formatter(), LogFormatter):
                    axis.set_major_formatter(_power)
                elif axis.get_scale() == "linear" and max(map(abs, axis.get_view_interval())) >= 1000:
                    axis.set_major_formatter("{x:,.0f}")
        return figure

    return drawn


def _power(x: float, _place: float = 0) -> str:
    """Return a tick label for a log axis; matplotlib's labels would require text parsing."""
    power = round(float(np.log10(x)))
    return "10" + str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def save(figure: Figure, path: Path | str, dpi: int = 110) -> Path:
    """Write a figure as PNG, completely or not at all.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    path : str or Path
    dpi : int, default 110
        Resolution [dots per inch].

    Returns
    -------
    Path

    Examples
    --------
    >>> from ecs_eco.analysis import figures
    >>> from ecs_eco.analysis.runs import load_series
    >>> figure = figures.populations(load_series({"hare": [10, 12, 9]}))
    >>> figures.save(figure, "numbers.png").name
    'numbers.png'
    """
    more: dict[str, Any] = {"metadata": {"Software": None}, "pil_kwargs": {"compress_level": 4}}
    return save_as("png", figure, path, dpi, more)


def save_as(kind: str, figure: Figure, path: Path | str, dpi: int, more: Mapping[str, Any]) -> Path:
    """Write a figure in one of matplotlib's formats, completely or not at all."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    # some texts are created only here
    with files.writing(path) as beside, as_delivered({"text.parse_math": False}):
        _lay_out(figure, dpi)
        figure.savefig(beside, dpi=dpi, facecolor="white", format=kind, **more)
    return Path(path)


def _lay_out(figure: Figure, dpi: int) -> None:
    """Compute the layout without drawing the whole figure twice, as matplotlib would."""
    if (engine := figure.get_layout_engine()) is not None:
        figure.set_dpi(dpi)
        axes: list[Any] = figure.axes  # Any, because `_autotitlepos` is private to matplotlib
        for ax in filter(_nothing_above, axes):
            ax._autotitlepos = False  # otherwise all ticks are created and measured again to place titles
        engine.execute(figure)
        figure.set_layout_engine(None)


def _nothing_above(ax: "matplotlib.axes.Axes") -> bool:
    """Return whether no tick labels, other axes or common factor of numbers can move the title of the axes."""
    low, high = sorted(ax.get_ylim())
    plain = ax.get_yscale() == "linear" and low <= 0 <= high and 1e-2 < max(-low, high) < 1e5
    alone = not ax.child_axes and "outline" not in ax.spines
    below = ax.xaxis.get_label_position() == "bottom" and not ax.xaxis.get_tick_params().get("labeltop")
    twins = any(other is not ax and other.bbox.bounds == ax.bbox.bounds for other in ax.figure.axes)
    return bool(plain and alone and below and not twins)


def save_svg(figure: Figure, path: Path | str) -> Path:
    """Write an SVG for light and dark pages, completely or not at all; its bytes depend only on the figure.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    path : str or Path

    Returns
    -------
    Path

    Examples
    --------
    >>> from ecs_eco.analysis import figures
    >>> from ecs_eco.analysis.runs import load_series
    >>> figure = figures.populations(load_series({"hare": [10, 12, 9]}))
    >>> figures.save_svg(figure, "numbers.svg").name
    'numbers.svg'
    """
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    return files.write(Path(path), themed(svg_of(figure), Path(path).stem))


def svg_of(figure: Figure) -> str:
    """Return matplotlib's SVG, with text kept as text; the same figure always produces the same SVG."""
    drawn, more = StringIO(), {"Date": None, "Creator": None}
    with as_delivered({"text.parse_math": False, "svg.hashsalt": "ecs-eco", "svg.fonttype": "none"}):
        _lay_out(figure, 72)
        figure.savefig(drawn, transparent=True, format="svg", metadata=more, dpi=RASTER)
    return drawn.getvalue()


def colors(species: Sequence[str], chosen: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return a color for each species, as in the viewer: the palette color nearest to its #rrggbb, if any."""
    own = safe(own_colors(chosen))
    return {s: own.get(s, PALETTE[i % len(PALETTE)]) for i, s in enumerate(species)}


def own_colors(chosen: object) -> dict[str, str]:
    """Return the valid colors in a manifest, which can contain anything."""
    pairs = chosen.items() if isinstance(chosen, Mapping) else ()
    return {s: hue for s, hue in pairs if isinstance(hue, str) and HUE.fullmatch(hue)}


def colors_of(series: Series) -> dict[str, str]:
    """Return a color for each species of a run."""
    return colors(series.species, series.manifest.get("colors"))
