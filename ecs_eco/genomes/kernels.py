"""Kernels that process many genomes at once: u8[n, loci], one letter number per locus.

Draws depend only on the key of each birth. A `salt` distinguishes the draws of several crossings in one
birth. Keys are mixed first, because `draw` takes key ^ locus, which is the same for many pairs of small
numbers. A draw is a multiple of 2**-24, so any probability below 6e-8 has the effect of 6e-8.
"""

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.engine.random import draw, mix

# purposes of a birth's draws
ORDER, CROSS, POINT_1, POINT_2, SWAP, MUTATE, LETTER, FOUND = range(1, 9)
SALT = 16  # distance between purposes
UNIFORM, FLIP, SHUFFLE = range(3)  # mutation methods


@njit
def read_codons(loci, first, letters, size, gray, out):
    """Fill `out` i64[n, codons] with the numbers of codons of `letters` letters, starting at locus `first`."""
    for row in range(out.shape[0]):
        at = first
        for codon in range(out.shape[1]):
            number, digit = 0, 0
            for _ in range(letters):
                letter = np.int64(loci[row, at])
                digit = digit + letter if gray else letter
                if digit >= size:
                    digit -= size
                number = number * size + digit
                at += 1
            out[row, codon] = number


@njit
def write_codons(numbers, first, letters, size, gray, loci):
    """Write numbers i64[n, codons] as codons, starting at locus `first`: the inverse of `read_codons`."""
    for row in range(numbers.shape[0]):
        for codon in range(numbers.shape[1]):
            left = numbers[row, codon]
            start = first + codon * letters
            for place in range(start + letters - 1, start - 1, -1):
                digit = left % size
                left //= size
                loci[row, place] = (digit - left % size + size) % size if gray else digit


@njit
def combine(coefficients, basis, out):
    """Fill `out` f64[n, size] with coefficients f64[n, k] times basis f64[k, size], in a fixed order."""
    for row in range(out.shape[0]):
        for i in range(out.shape[1]):
            out[row, i] = 0.0
        for k in range(basis.shape[0]):
            c = coefficients[row, k]
            for i in range(out.shape[1]):
                out[row, i] += c * basis[k, i]


@njit
def toss(keys, salt, purpose, out):
    """Fill `out` f32[n] with a draw for each birth."""
    for birth in range(keys.size):
        key = mix(keys[birth])
        out[birth] = draw(key, 0, purpose + SALT * salt)


@njit
def letters_of(keys, size, out):
    """Fill `out` u8[n, loci] with letters drawn uniformly."""
    for birth in range(keys.size):
        key = mix(keys[birth])
        for locus in range(out.shape[1]):
            out[birth, locus] = np.int64(np.float64(draw(key, locus, FOUND)) * size)


@njit
def cross_points(first, second, swapped, crossed, keys, salt, points, out):
    """Copy `first` u8[n, loci], with `second` beyond one point or between two points; `swapped` rows exchange
    the two."""
    n = first.shape[1]
    for birth in range(keys.size):
        key = mix(keys[birth])
        here, there = (second[birth], first[birth]) if swapped[birth] else (first[birth], second[birth])
        low, high = n, n
        if crossed[birth]:
            u = np.float64(draw(key, 0, POINT_1 + SALT * salt))
            if points == 1:
                low = 1 + np.int64(u * (n - 1))
            else:
                low = 1 + np.int64(u * n)
                high = 1 + np.int64(np.float64(draw(key, 0, POINT_2 + SALT * salt)) * (n - 1))
                if high >= low:
                    high += 1
                else:
                    low, high = high, low
        for locus in range(n):
            out[birth, locus] = there[locus] if low <= locus < high else here[locus]


@njit
def cross_uniform(first, second, swapped, crossed, keys, salt, chance, out):
    """Copy `first` u8[n, loci], but take each locus from `second` with probability `chance`; `swapped` rows
    exchange the two."""
    for birth in range(keys.size):
        key = mix(keys[birth])
        here, there = (second[birth], first[birth]) if swapped[birth] else (first[birth], second[birth])
        for locus in range(first.shape[1]):
            swap = crossed[birth] and draw(key, locus, SWAP + SALT * salt) < chance
            out[birth, locus] = there[locus] if swap else here[locus]


@njit
def mutate(strings, keys, salt, way, rates, low, up):
    """Mutate each letter of u8[n, loci] with its locus' probability, by one of the three methods of
    `change`."""
    for birth in range(keys.size):
        key, string = mix(keys[birth]), strings[birth]
        for locus in range(string.size):
            if draw(key, locus, MUTATE + SALT * salt) < rates[locus]:
                u = np.float64(draw(key, locus, LETTER + SALT * salt))
                change(string, string.size, locus, way, u, low[locus], up[locus])


@njit
def change(string, n, i, way, u, low, up):
    """Change letter i of n using a draw u: replace it with one from low to up or with the other of two
    letters, or swap it with another letter."""
    if way == UNIFORM:
        string[i] = low + np.int64(u * (up - low + 1))
    elif way == FLIP:
        string[i] = 1 - string[i]
    elif n > 1:
        other = np.int64(u * (n - 1))
        other += other >= i
        string[i], string[other] = string[other], string[i]


@njit
def forward(x, sizes, weights, out):
    """Fill `out` f32[n, last] with the output of tanh layers for x f32[n, first] and weights f32[n, size], or
    f32[1, size] for all rows.

    Each layer's weights are its matrix (in, out) row by row, then its bias. A unit's inputs are summed in the
    same order in every row.
    """
    widest = 0
    for s in sizes:
        widest = max(widest, s)
    a, b = np.empty(widest, np.float32), np.empty(widest, np.float32)
    for row in range(x.shape[0]):
        w = weights[row if weights.shape[0] > 1 else 0]
        for i in range(sizes[0]):
            a[i] = x[row, i]
        at = 0
        for layer in range(sizes.size - 1):
            n_in, n_out = sizes[layer], sizes[layer + 1]
            for j in range(n_out):
                b[j] = w[at + n_in * n_out + j]
            for i in range(n_in):
                for j in range(n_out):
                    b[j] += a[i] * w[at + i * n_out + j]
            at += n_in * n_out + n_out
            for j in range(n_out):
                a[j] = np.tanh(b[j]) if layer < sizes.size - 2 else b[j]
        for j in range(sizes[sizes.size - 1]):
            out[row, j] = a[j]
