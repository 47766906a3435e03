"""Sums over the living of one species, as a tick of the record has them."""

from typing import NamedTuple

from ecs_eco.engine.jit import njit


class Totals(NamedTuple):
    """Sums over the living of one species, in float64; the flows are named as in the ledger."""

    energy: float
    taken_in: float
    burnt: float
    given: float
    happiness: float


@njit
def add_up(alive, energy, taken, burnt, given, happiness):
    """Return the Totals of the living."""
    e, t, b, g, h = 0.0, 0.0, 0.0, 0.0, 0.0
    feels = happiness.size > 0
    for row in range(alive.size):
        if alive[row]:
            e += energy[row]
            t += taken[row]
            b += burnt[row]
            g += given[row]
            if feels:
                h += happiness[row]
    return Totals(e, t, b, g, h)


@njit
def mean_depth(alive, z, top):
    """Return the mean distance of the living below the top of the space [m], in float64."""
    total, n = 0.0, 0
    for row in range(alive.size):
        if alive[row]:
            total += top - z[row]
            n += 1
    return total / max(n, 1)
