"""Frames: all organisms at a tick in one binary message, 12 bytes each (docs/reference/viewer_protocol.md).

If a uid needs more than 32 bits, as on all islands but the first, the header sets a flag and the upper halves
of all uids follow, adding 4 bytes per organism; so do genes that show in the bodies of a volume.
"""

import math
import struct
import sys
from collections.abc import Sequence

import numpy as np

from ecs_eco.compiled.jit import njit

MAGIC = 0x31434545  # "EEC1"
HEADER = struct.Struct("<IIIIffI")
WORDS = 3  # u32 per organism: x and y; z, heading and value; uid


class Encoder:
    """Collects the parts of a frame; `size` [m] of the world, `kinds`: the number of species and object types."""

    def __init__(self, size: Sequence[float], kinds: int) -> None:
        lengths = [*size, 0.0][:3]
        self._share = np.array([65535.0 / s if s > 0 else 0.0 for s in lengths], np.float32)
        self._kinds = kinds

    def begin(self, number: int, tick: int, light: float = 1.0, sun: float = math.pi / 2) -> None:
        """Begin a frame with its number, its tick, the surface light (0 to 1) and the sun's elevation [rad]."""
        self._about = number & 0xFFFFFFFF, tick & 0xFFFFFFFF, light, sun
        self._parts: list[np.ndarray] = []
        self._rows: list[tuple[np.ndarray, ...]] = []  # uids, genes and mask of live rows of each kind
        self._wide = False  # whether a uid in this frame needs more than 32 bits
        self._shows = False  # whether genes follow

    def add(
        self,
        x: np.ndarray,
        y: np.ndarray,
        z: np.ndarray,
        heading: np.ndarray,
        value: np.ndarray,
        uid: np.ndarray,
        alive: np.ndarray | None = None,
        genes: np.ndarray | None = None,
    ) -> None:
        """Add the next kind: x, y, z f32[n] [m], heading f32[n] [rad], value u8[n], uid u64[n]. Only `alive`
        rows bool[n] are written. `genes` u16[n] show in bodies; in a plane, they take the place of z."""
        alive = np.ones(x.size, np.bool_) if alive is None else alive
        share = self._share
        if genes is not None and not share[2]:
            z, share, genes = genes.astype(np.float32), np.append(share[:2], np.float32(1)), None
        words = np.empty(WORDS * x.size, np.uint32)
        end, upper = pack(alive, x, y, z, heading, value, uid, share, words)
        self._parts.append(words[:end])
        self._shows |= genes is not None
        self._rows.append((uid, np.zeros(uid.size, np.uint16) if genes is None else genes, alive))
        self._wide |= bool(upper)

    def bytes(self) -> bytes:
        """Return the frame."""
        number, tick, light, sun = self._about
        counts = np.zeros(self._kinds, np.uint32)
        counts[: len(self._parts)] = [part.size // WORDS for part in self._parts]
        more = [uid[alive] >> np.uint64(32) for uid, _, alive in self._rows if self._wide]
        more += [genes[alive] for _, genes, alive in self._rows if self._shows]
        words = np.concatenate([counts, *self._parts, *(column.astype(np.uint32) for column in more)])
        head = HEADER.pack(MAGIC, number, tick, self._wide + 2 * self._shows, light, sun, self._kinds)
        return head + (words if sys.byteorder == "little" else words.byteswap()).tobytes()


@njit
def pack(alive, x, y, z, heading, value, uid, share, words):
    """Write living organisms to `words`, three words each; return the end and the bitwise OR of the upper
    halves of all uids."""
    top, turn = np.float32(65535.0), np.float32(256.0 / (2.0 * math.pi))
    half = np.float32(0.5)
    at, upper = 0, np.uint64(0)
    for row in range(alive.size):
        if not alive[row]:
            continue
        px = np.uint32(min(max(x[row] * share[0], np.float32(0.0)), top) + half)
        py = np.uint32(min(max(y[row] * share[1], np.float32(0.0)), top) + half)
        pz = np.uint32(min(max(z[row] * share[2], np.float32(0.0)), top) + half)
        angle = np.uint32(np.int32(np.floor(heading[row] * turn + half)) & 255)
        words[at] = px | (py << np.uint32(16))
        words[at + 1] = pz | (angle << np.uint32(16)) | (np.uint32(value[row]) << np.uint32(24))
        words[at + 2] = np.uint32(uid[row])
        upper |= uid[row] >> np.uint64(32)
        at += 3
    return at, upper


@njit
def grade(alive, column, low, high, out):
    """Write the values of living organisms, scaled from [low, high] to 1 … 255, with 0 for NaN."""
    span = np.float32(254.0) / (high - low) if high > low else np.float32(0.0)
    for row in range(alive.size):
        if alive[row]:
            v = (column[row] - low) * span
            out[row] = (
                np.uint8(0)
                if np.isnan(v)
                else np.uint8(min(max(v, np.float32(0.0)), np.float32(254.0)) + np.float32(1.5))
            )


@njit
def extent(alive, column):
    """Return the minimum and maximum over living organisms, or infinities if there are none."""
    low, high = np.float32(np.inf), np.float32(-np.inf)
    for row in range(alive.size):
        if alive[row]:
            low, high = min(low, column[row]), max(high, column[row])
    return low, high
