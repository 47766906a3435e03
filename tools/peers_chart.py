"""A chart that compares ecs-eco with its peers: animal-steps per second on a log scale, as SVG."""

import math
from typing import Any

NAMES = {"bare loop": "compiled loop", "ecs-eco": "ecs-eco", "mesa-frames": "mesa-frames", "Mesa": "Mesa"}
NAMES |= {"AgentPy": "AgentPy"}
WIDTH, LEFT, RIGHT, TOP, BAR, GAP = 720, 130, 150, 56, 26, 14
AXIS = {2: "100", 3: "1,000", 4: "10,000", 5: "100,000", 6: "1 million", 7: "10 million"}  # by power of ten
LOWEST, HIGHEST = min(AXIS), max(AXIS)
OWN, OTHER, INK, PALE = "#0072b2", "#8a8a8a", "#222222", "#dddddd"


def chart(rows: list[dict[str, Any]], animals: int) -> str:
    """Return an SVG of the peers that ran the common task with this number of animals, slowest last."""
    alike = {row["peer"]: row for row in rows if row["animals"] == animals and row["task"] == "common"}
    order = sorted(NAMES, key=lambda peer: -(alike[peer]["k organism-steps/s"] or 0))
    bottom = TOP + len(order) * (BAR + GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {bottom + 44}" font-family="sans-serif" '
        f'font-size="14" fill="{INK}">',
        f'<rect width="{WIDTH}" height="{bottom + 44}" fill="#ffffff"/>',
        f'<text x="12" y="28" font-size="16" font-weight="bold">Animal-steps per second, {animals:,} animals, '
        "one core (log scale)</text>",
    ]
    for power, text in AXIS.items():
        x = at(10.0**power)
        parts.append(f'<path d="M{x:.1f} {TOP - 8}V{bottom}" stroke="{PALE}"/>')
        parts.append(f'<text x="{x:.1f}" y="{bottom + 22}" text-anchor="middle" font-size="12">{text}</text>')
    for i, peer in enumerate(order):
        parts += bar(NAMES[peer], alike[peer], TOP + i * (BAR + GAP), OWN if peer == "ecs-eco" else OTHER)
    return "\n".join([*parts, "</svg>"]) + "\n"


def bar(name: str, row: dict[str, Any], y: int, color: str) -> list[str]:
    """Return a peer's bar, or the reason for its absence."""
    weight = ' font-weight="bold"' if color == OWN else ""
    middle = y + BAR - 8
    parts = [f'<text x="{LEFT - 12}" y="{middle}" text-anchor="end"{weight}>{name}</text>']
    speed = row["k organism-steps/s"]
    if speed is None:
        return [*parts, f'<text x="{LEFT + 8}" y="{middle}" fill="#666666">{row["note"]}</text>']
    end = at(1e3 * speed)
    number = f"{1e3 * speed:,.0f}" if speed < 10 else f"{float(f'{1e3 * speed:.3g}'):,.0f}"
    parts.append(f'<rect x="{LEFT}" y="{y}" width="{end - LEFT:.1f}" height="{BAR}" fill="{color}"/>')
    return [*parts, f'<text x="{end + 8:.1f}" y="{middle}"{weight}>{number}</text>']


def at(speed: float) -> float:
    """Return a speed's position on the axis."""
    share = (math.log10(speed) - LOWEST) / (HIGHEST - LOWEST)
    return LEFT + share * (WIDTH - LEFT - RIGHT)
