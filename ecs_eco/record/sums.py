"""Sums over the living of one species, as a tick of the record has them."""

from ecs_eco.engine.jit import njit


@njit
def add_up(alive, energy, taken, burnt, given, happiness, totals):
    """Write the sums over the living to `totals` f64[5]: energy, then what was taken in, burnt and given in
    this tick, then happiness."""
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
    totals[0], totals[1], totals[2], totals[3], totals[4] = e, t, b, g, h


@njit
def mean_depth(alive, z, top):
    """Return the mean distance of the living below the top of the space [m], in float64."""
    total, n = 0.0, 0
    for row in range(alive.size):
        if alive[row]:
            total += top - z[row]
            n += 1
    return total / max(n, 1)
