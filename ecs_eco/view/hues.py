"""Colours of kinds that colour-blind readers can distinguish: the same in pictures as on the viewer's page.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

SAFE = {"#009E73": 125, "#E69F00": 38, "#D55E00": 2, "#56B4E9": 198, "#CC79A7": 308, "#F0E442": 58,
        "#0072B2": 225}
"""Okabe and Ito's colours (2008) and the hue [degrees] that each represents."""
GREY = "#9aa3a8"


def safe(colours: Mapping[str, str]) -> dict[str, str]:
    """Return for each name the safe colour nearest to the hue of its own, the best pairs first;
    greys stay grey."""
    safe_of = {name: GREY for name, colour in colours.items() if max(_rgb(colour)) - min(_rgb(colour)) < 24}
    offers: list[tuple[str, float]] = list(SAFE.items())
    while remaining := [name for name in colours if name not in safe_of]:
        if not offers:
            offers = [(_lighter(colour), hue) for colour, hue in SAFE.items()]
        name, offer = min(((n, o) for n in remaining for o in offers),
                          key=lambda pair: _gap(_hue(colours[pair[0]]), pair[1][1]))
        safe_of[name] = offer[0]
        offers.remove(offer)
    return {name: safe_of[name] for name in colours}


def _rgb(colour: str) -> list[int]:
    return [int(colour[i : i + 2], 16) for i in (1, 3, 5)]


def _lighter(colour: str) -> str:
    return "#" + "".join(f"{round(0.5 * part + 110):02x}" for part in _rgb(colour))


def _hue(colour: str) -> float:
    r, g, b = _rgb(colour)
    return math.degrees(math.atan2(math.sqrt(3) * (g - b), 2 * r - g - b))


def _gap(a: float, b: float) -> float:
    return abs((a - b + 180) % 360 - 180)
