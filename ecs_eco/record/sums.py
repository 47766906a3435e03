"""Sums over the living of one species, as a tick of the record has them."""

from ecs_eco.engine.jit import njit
from ecs_eco.record.ledger import FLOWS, LEDGER

FLOW = LEDGER.index(next(iter(FLOWS)))  # the place of the first flow in the ledger; "lost" follows the last
AFTER = LEDGER.index("stock_after")


@njit
def add_up(alive, n, energy, taken, burnt, given, happiness, s, stock, page, means, moods):
    """Write what the n living of species s hold and feel to its row of this tick: page f64[species, …] of the
    ledger, where what was endowed, lost, and flowed in the dead stands already, means f32[species, …] of
    energy and happiness, and moods f64[species], the sums of happiness. `stock` f64[species] is what they
    held before, then what they hold."""
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
    page[s, 0] = stock[s]
    page[s, FLOW] += t
    page[s, FLOW + 1] += b
    page[s, FLOW + 2] += g
    page[s, AFTER] = stock[s] = e
    n = max(n, 1)
    means[s, 0], means[s, 1], moods[s] = e / n, h / n, h


@njit
def mean_depth(alive, z, top):
    """Return the mean distance of the living below the top of the space [m], in float64."""
    total, n = 0.0, 0
    for row in range(alive.size):
        if alive[row]:
            total += top - z[row]
            n += 1
    return total / max(n, 1)
