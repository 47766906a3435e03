"""Colors of species and object types in pictures, reports and the viewer; its pages receive them from here.

The palette of Okabe and Ito (2008) is shifted as little as necessary for a contrast of 3:1 with the
background and a CIELAB distance of 20, also for people with deuteranopia (Machado et al. 2009)."""

import math
from collections.abc import Mapping

SAFE = (
    ("#069b6d", "#049662", 125),
    ("#6f3e00", "#e7a002", 38),
    ("#de640a", "#c85300", 2),
    ("#2992c2", "#60bef2", 198),
    ("#bd6fa5", "#cc79a7", 308),
    ("#888e3b", "#fffa5f", 58),
    ("#005396", "#0072b2", 225),
)
"""Colors on a light and on a dark background, and the hue [degrees] that they represent."""
GREY = "#7f888d"
UNSET = "#4477aa"
"""The default of `color` in world files."""
INK, SOFT, AXIS, BAND, GRID = "#1b1f23", "#57606a", "#7a838c", "#dfe3e8", "#e6eaee"
"""Colors on a light background: primary text, secondary text, axes, a band behind curves, and the grid."""
NIGHT, SUN = "#a9b4c2", "#b58900"
FLOWS = {"taken_in": SUN, "endowed": "#7d6200", "burnt": AXIS, "given": SOFT, "lost": INK}
"""Colors of energy flows, which no species has."""
CLEAR = {
    "red": ("#d7191c", "#f0605a"),
    "yellow": ("#a68500", "#e6b800"),
    "green": ("#1a9641", "#2fae57"),
    "blue": ("#0571b0", "#4aa3dc"),
    "white": ("#8a9197", "#dfe3e6"),
    "orange": ("#c8660a", "#f28c28"),
}
"""Colors of genes named after a color, on a light and on a dark background."""
ON_CELL = "#fefefe", "#010101"
"""Colors of text on a dark and on a light cell, the same in both themes."""


def safe(
    colours: Mapping[str, str], things: Mapping[str, str] | None = None, dark: bool = False
) -> dict[str, str]:
    """Return the safe color nearest to the hue of each species, then of each object type. Grays stay gray, and
    those with the default color take the remaining safe colors in order, green first."""
    own = {**colours, **(things or {})}
    out = {name: GREY for name, colour in own.items() if max(rgb(colour)) - min(rgb(colour)) < 24}
    choice = [(on_dark if dark else on_light, hue) for on_light, on_dark, hue in SAFE]
    offers = list(choice)
    for group in (colours, things or {}):
        while remaining := [name for name in group if name not in out]:
            if not offers:
                offers = [(_paler(colour, dark), hue) for colour, hue in choice]
            pairs = ((n, o) for n in remaining if own[n] != UNSET for o in offers)
            name, offer = min(
                pairs,
                key=lambda pair: abs((_hue(own[pair[0]]) - pair[1][1] + 180) % 360 - 180),
                default=(remaining[0], offers[0]),
            )
            out[name] = offer[0]
            offers.remove(offer)
    return {name: out[name] for name in own}


def rgb(colour: str) -> list[int]:
    """Return the components of #rrggbb, from 0 to 255."""
    return [int(colour[i : i + 2], 16) for i in (1, 3, 5)]


def _paler(colour: str, dark: bool) -> str:
    """Return a color for the eighth and later species or types, mixed with the theme's ink."""
    parts = [math.floor(0.6 * part + (102 if dark else 0) + 0.5) for part in rgb(colour)]
    return "#" + "".join(f"{part:02x}" for part in parts)


def _hue(colour: str) -> float:
    r, g, b = rgb(colour)
    return math.degrees(math.atan2(math.sqrt(3) * (g - b), 2 * r - g - b))


TIME = (
    "#440154",
    "#481467",
    "#482576",
    "#453581",
    "#404588",
    "#3a538b",
    "#34618d",
    "#2e6e8e",
    "#297a8e",
    "#24868e",
    "#20928c",
    "#1f9f88",
)
TIME_ON_DARK = (
    "#336b92",
    "#2a768e",
    "#25848e",
    "#20938c",
    "#1fa187",
    "#2ab07f",
    "#42be71",
    "#60ca60",
    "#86d549",
    "#addc30",
    "#d8e219",
    "#fde725",
)
"""Colors of curves from early to late: the parts of viridis visible on light and on dark backgrounds."""
ON_DARK: Mapping[str, str] = {
    **{light: dark for light, dark, _ in SAFE},
    **{_paler(light, dark=False): _paler(dark, dark=True) for light, dark, _ in SAFE},
    **dict(CLEAR.values()),
    NIGHT: "#3a4350",
    SUN: "#f0cf57",
    FLOWS["endowed"]: "#b39b3c",
    GRID: "#283136",
    BAND: "#2c363b",
    INK: "#e4eaea",
    SOFT: "#98a5aa",
    AXIS: "#7f8c92",
    "#000000": "#e4eaea",
    "#ffffff": "#12181b",
    "#d8ccb4": "#857a60",
    "#b2182b": "#ef6a6a",
    "#1b7837": "#4fb36a",
    "#222222": "#e4eaea",
    **dict(zip(TIME, TIME_ON_DARK, strict=True)),
}
"""The dark-background color of each light-background color in figures."""
