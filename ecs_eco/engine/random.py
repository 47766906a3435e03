"""Counter-based random numbers: a draw is a hash of (seed, tick, identity, purpose), so no draw depends on
another.

An identity is a u64 that distinguishes draws within a tick: the uid of an organism, a site, or a number
derived from them. The hash is the finalizer of splitmix64 (Steele, Lea & Flood 2014), applied once per part
of the key, which takes 2 ns per draw.
"""

import functools

import numpy as np

from ecs_eco.compiled.jit import njit

_MASK = (1 << 64) - 1

# the purpose of a draw; an organism can draw one number per purpose, salt and tick
(PLACE, SEX, DECIDE, FEED, BIRTH, SPREAD, WANDER, USER, MATE, GENES, BRAIN, CULL, MIGRATE, LOT) = range(1, 15)


@njit
def mix(z):
    """Return a well-mixed u64 hash of a u64."""
    z = np.uint64(z) + np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit
def bits(key, identity, purpose):
    """Return 64 random bits, always the same for the same arguments; `draw` uses the upper 24 bits."""
    return mix(mix(np.uint64(key) ^ np.uint64(identity)) + np.uint64(purpose) * np.uint64(0xD1342543DE82EF95))


@njit
def draw(key, identity, purpose):
    """Return a uniform random number in [0, 1), always the same for the same arguments.

    Parameters
    ----------
    key : uint64
        Key of a tick, `world.key`.
    identity : uint64
        Distinguishes draws within a tick: an organism's uid, a site, or a number derived from them.
    purpose : int
        Distinguishes uses of the number; in your own systems, use `ecs_eco.engine.random.USER`.

    Returns
    -------
    float32
        A multiple of 2**-24, so it is below p with a probability of p rounded up to such a multiple.

    Notes
    -----
    A draw is a hash of its arguments (the finalizer of splitmix64: Steele, Lea & Flood 2014), so draws do not
    depend on each other or on the order of rows. Kernels compiled by `njit` can call it.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco import World, draw
    >>> from ecs_eco.engine.random import USER
    >>> world = World(seed=1)
    >>> number = draw(world.key, np.uint64(7), USER)
    >>> 0.0 <= number < 1.0, number == draw(world.key, np.uint64(7), USER)
    (True, True)
    """
    return np.float32(bits(key, identity, purpose) >> np.uint64(40)) * np.float32(5.9604645e-08)


@njit
def by_lot(key, identity, purpose):
    """Return a random permutation i64[n] of distinct identities u64[n]. It does not depend on their original
    order, because `bits` of distinct identities are never equal."""
    return np.argsort(bits_of(key, identity, purpose))


@njit
def bits_of(key, identity, purpose):
    """Return the `bits` of each identity: u64[n]."""
    out = np.empty(identity.size, np.uint64)
    for i in range(identity.size):
        out[i] = bits(key, identity[i], purpose)
    return out


@functools.lru_cache(maxsize=64)
def mix_int(z: int) -> int:
    """Return `mix` of a Python integer."""
    z = (z + 0x9E3779B97F4A7C15) & _MASK
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & _MASK
    return z ^ (z >> 31)


@functools.lru_cache(maxsize=64)
def tick_key(seed: int, tick: int) -> np.uint64:
    """Return the key for all draws in one tick of a world with this seed."""
    return np.uint64(mix_int(mix_int(seed & _MASK) + tick))


def draw_many(key: int | np.uint64, identity: np.ndarray, purpose: int) -> np.ndarray:
    """Return one `draw` for each entry of an array of identities.

    Parameters
    ----------
    key : int or uint64
        Key of a tick, `world.key`.
    identity : array of uint64, shape (n,)
        For example `table.uid[rows]`.
    purpose : int
        In your own systems, use `ecs_eco.engine.random.USER`.

    Returns
    -------
    array of float32, shape (n,)
        In [0, 1).

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco import World
    >>> from ecs_eco.engine.random import USER, draw_many
    >>> draw_many(World(seed=1).key, np.arange(1, 4), USER).shape
    (3,)
    """
    out = np.empty(len(identity), np.float32)
    _draw_many(np.uint64(key), identity.astype(np.uint64, copy=False), purpose, out)
    return out


@njit
def _draw_many(key, identity, purpose, out):
    for i in range(identity.size):
        out[i] = draw(key, identity[i], purpose)


@njit
def lot(key, uid, item):
    """Return the random number u64 that ranks a competitor for an item among equals, lowest first."""
    return bits(key, mix(uid) ^ np.uint64(item), LOT)


@njit
def lots(key, uid, item):
    """Return the `lot` of each competitor: u64[n]."""
    out = np.empty(uid.size, np.uint64)
    for i in range(uid.size):
        out[i] = lot(key, uid[i], item[i])
    return out
