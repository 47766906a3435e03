"""Outlines of capsules and boxes in pictures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

ROUND = np.linspace(-np.pi / 2, np.pi / 2, 9)  # of the end of a capsule


def outlines(
    shape: str, places: np.ndarray, heading: np.ndarray, size: Sequence[np.ndarray], side: bool = False
) -> np.ndarray:
    """Return the corners of capsules or boxes f64[n, corners, 2] [m]: seen from above, or, with `side`, along
    the y axis. `places` f64[n, 2] are their centres, `size` length, width and height f64[n]."""
    length, width, height = (np.asarray(s, float)[:, None] / 2 for s in size)
    cos, sin = np.cos(heading)[:, None], np.sin(heading)[:, None]
    if side:  # what goes away from us looks short
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
