"""Kernels that process many strings of variable length: u8[n, longest], letters up to the first blank.

The blank is the number after the last letter's. Genes are found by their promoters: `words` i16[size ** k]
contains the gene whose promoter begins each word of k letters, and `spans` i64[genes] the number of letters
in a copy, including its promoter. A change that would make a string empty or longer than `longest` is skipped
and counted in `at_limit` i64[5]: crossings, duplications, losses, insertions, deletions. Draws work as in
`kernels`.
"""

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.engine.random import draw, mix
from ecs_eco.genomes.kernels import LETTER, MUTATE, POINT_1, SALT, change

# purpose codes for the random draws at birth, continuing the codes in `kernels`
DUPLICATE, REARRANGE, GAP, INDEL, INSERT, SLIP = range(9, 15)
CROSSING, DUPLICATION, LOSS, INSERTION, DELETION = range(5)  # entries of at_limit
NEVER = 1 << 40  # larger than the number of letters in any string


@njit
def end_of(string, blank):
    """Return how many letters a string has."""
    for i in range(string.size):
        if string[i] == blank:
            return i
    return string.size


@njit
def gap(u, chance):
    """Return how many trials with this success probability fail before the next success, given a draw u in
    [0, 1)."""
    if chance <= 0:
        return NEVER
    return np.int64(np.log1p(-np.float64(u)) / np.log1p(-chance)) if chance < 1 else np.int64(0)


@njit
def parse(string, n, words, k, size, spans, at, gene):
    """Find the genes in the first n letters: write the start of each copy's promoter and the number of its
    gene; return the number of copies."""
    top = np.int64(1)
    for _ in range(k - 1):
        top *= size
    i, m, word, anew = 0, 0, np.int64(0), True
    while i < n:
        if anew:  # words that extend beyond the end are padded with zeros, because no gene fits there
            word = np.int64(0)
            for j in range(i, i + k):
                word = word * size + (np.int64(string[j]) if j < n else 0)
        found = words[word]
        anew = found >= 0 and i + spans[found] <= n
        if anew:
            at[m], gene[m] = i, found
            m += 1
            i += spans[found]
        else:
            word = (word - np.int64(string[i]) * top) * size + (np.int64(string[i + k]) if i + k < n else 0)
            i += 1
    return m


@njit
def count_copies(strings, blank, words, k, size, spans, out):
    """Fill `out` i64[n] with the number of copies of all genes in each string."""
    at, gene = np.empty(strings.shape[1], np.int64), np.empty(strings.shape[1], np.int64)
    for s in range(out.size):
        out[s] = parse(strings[s], end_of(strings[s], blank), words, k, size, spans, at, gene)


@njit
def find_copies(strings, blank, words, k, size, spans, string, at, gene):
    """List all copies in all strings, in order: string, start of the promoter and gene; i64 each."""
    places, genes = np.empty(strings.shape[1], np.int64), np.empty(strings.shape[1], np.int64)
    c = 0
    for s in range(strings.shape[0]):
        m = parse(strings[s], end_of(strings[s], blank), words, k, size, spans, places, genes)
        for i in range(m):
            string[c], at[c], gene[c] = s, places[i], genes[i]
            c += 1


@njit
def join_strings(strings, blank, ploidy, out):
    """Fill `out` u8[n, …] with the letters of each genome's strings, separated by blank + 1, then blanks."""
    for row in range(out.shape[0]):
        to = 0
        for s in range(row * ploidy, (row + 1) * ploidy):
            if to or s > row * ploidy:
                out[row, to] = blank + 1
                to += 1
            n = end_of(strings[s], blank)
            out[row, to : to + n] = strings[s, :n]
            to += n
        out[row, to:] = blank


@njit
def partner_of(pick, copies, gene_1, m_1, gene_2, m_2):
    """Return the `pick`-th copy in string 1 that has a counterpart of its rank in string 2, and the
    counterpart; (−1, number of such copies) if there are fewer."""
    n = 0
    for c in range(m_1):
        rank = 0
        for b in range(c):
            rank += gene_1[b] == gene_1[c]
        if rank >= copies[gene_1[c]]:
            continue
        if n == pick:
            for d in range(m_2):
                if gene_2[d] == gene_1[c]:
                    if rank == 0:
                        return c, d
                    rank -= 1
        n += 1
    return -1, n


@njit
def slipped_of(pick, copies, gene_1, m_1, gene_2, m_2):
    """Return the `pick`-th pair of copies of the same gene, from string 1 and from string 2; (−1, number of
    pairs) if there are fewer."""
    n = 0
    for c in range(m_1):
        if pick < n + copies[gene_1[c]]:
            for d in range(m_2):
                if gene_2[d] == gene_1[c]:
                    if n == pick:
                        return c, d
                    n += 1
        n += copies[gene_1[c]]
    return -1, n


@njit
def cross_unequal(
    first, second, swapped, crossed, keys, salt, slip, blank, words, k, size, spans, at_limit, out
):
    """Copy `first` u8[n, longest] up to the promoter of one of its genes, then `second` starting at the
    counterpart's promoter; `swapped` rows exchange the two.

    The counterpart is the copy of the same gene with the same rank or, with probability `slip`, any copy of
    the gene. All pairs of counterparts are equally likely.
    """
    longest = first.shape[1]
    at_1, gene_1 = np.empty(longest, np.int64), np.empty(longest, np.int64)
    at_2, gene_2 = np.empty(longest, np.int64), np.empty(longest, np.int64)
    copies = np.zeros(spans.size, np.int64)
    for birth in range(keys.size):
        key = mix(keys[birth])
        here, there = (second[birth], first[birth]) if swapped[birth] else (first[birth], second[birth])
        n = end_of(here, blank)
        cut, start, stop = n, 0, 0
        if crossed[birth]:
            n_2 = end_of(there, blank)
            m_1 = parse(here, n, words, k, size, spans, at_1, gene_1)
            m_2 = parse(there, n_2, words, k, size, spans, at_2, gene_2)
            for d in range(m_2):
                copies[gene_2[d]] += 1
            u = np.float64(draw(key, 0, POINT_1 + SALT * salt))
            if draw(key, 0, SLIP + SALT * salt) < slip:
                _, pairs = slipped_of(m_1 * m_2, copies, gene_1, m_1, gene_2, m_2)
                c, d = slipped_of(np.int64(u * pairs), copies, gene_1, m_1, gene_2, m_2)
            else:
                _, pairs = partner_of(m_1, copies, gene_1, m_1, gene_2, m_2)
                c, d = partner_of(np.int64(u * pairs), copies, gene_1, m_1, gene_2, m_2)
            for e in range(m_2):
                copies[gene_2[e]] = 0
            if pairs > 0 and 0 < at_1[c] + n_2 - at_2[d] <= longest:
                cut, start, stop = at_1[c], at_2[d], n_2
            elif pairs > 0:
                at_limit[CROSSING] += 1
        for i in range(cut):
            out[birth, i] = here[i]
        for i in range(start, stop):
            out[birth, cut + i - start] = there[i]
        for i in range(cut + stop - start, longest):
            out[birth, i] = blank


@njit
def rearrange(strings, keys, salt, duplication, loss, blank, words, k, size, spans, at_limit):
    """Duplicate each copy of a gene with probability `duplication`, inserting the new copy right after it, or
    remove it with probability `loss`."""
    longest, total, least = strings.shape[1], duplication + loss, spans.min()
    at, gene = np.empty(longest, np.int64), np.empty(longest, np.int64)
    times, old = np.empty(longest, np.int64), np.empty(longest, np.uint8)
    for birth in range(keys.size):
        key, string = mix(keys[birth]), strings[birth]
        c = gap(draw(key, 0, DUPLICATE + SALT * salt), total)
        if c * least >= longest:  # beyond all possible copies
            continue
        n = end_of(string, blank)
        m = parse(string, n, words, k, size, spans, at, gene)
        times[:m] = 1
        new, event = n, 0
        while c < m:
            span = spans[gene[c]]
            if np.float64(draw(key, event, REARRANGE + SALT * salt)) * total < duplication:
                if new + span <= longest:
                    times[c], new = 2, new + span
                else:
                    at_limit[DUPLICATION] += 1
            elif new > span:
                times[c], new = 0, new - span
            else:
                at_limit[LOSS] += 1
            event += 1
            c += 1 + gap(draw(key, event, DUPLICATE + SALT * salt), total)
        if event == 0:
            continue
        old[:n] = string[:n]
        to, begin = 0, 0
        for c in range(m + 1):  # the letters before each copy, then the copy zero, one or two times
            stop = at[c] if c < m else n
            for i in range(begin, stop):
                string[to] = old[i]
                to += 1
            begin = stop
            for _ in range(times[c] if c < m else 0):
                for i in range(stop, stop + spans[gene[c]]):
                    string[to] = old[i]
                    to += 1
            begin += spans[gene[c]] if c < m else 0
        for i in range(to, n):
            string[i] = blank


@njit
def insert_and_delete(strings, keys, salt, insertion, deletion, blank, size, at_limit):
    """Insert a random letter before each letter with probability `insertion`, or delete the letter with
    probability `deletion`."""
    longest, total = strings.shape[1], insertion + deletion
    old = np.empty(longest, np.uint8)
    for birth in range(keys.size):
        key, string = mix(keys[birth]), strings[birth]
        n = end_of(string, blank)
        at = gap(draw(key, 0, GAP + SALT * salt), total)
        if at >= n:
            continue
        old[:n] = string[:n]
        new, to, begin, event = n, at, at, 0
        while at < n:
            for i in range(begin, at):
                string[to] = old[i]
                to += 1
            begin = at
            if np.float64(draw(key, event, INDEL + SALT * salt)) * total < insertion:
                if new < longest:
                    string[to] = np.int64(np.float64(draw(key, event, INSERT + SALT * salt)) * size)
                    to, new = to + 1, new + 1
                else:
                    at_limit[INSERTION] += 1
            elif new > 1:
                begin, new = at + 1, new - 1
            else:
                at_limit[DELETION] += 1
            event += 1
            at += 1 + gap(draw(key, event, GAP + SALT * salt), total)
        for i in range(begin, n):
            string[to] = old[i]
            to += 1
        for i in range(to, n):
            string[i] = blank


@njit
def mutate_letters(strings, keys, salt, way, chance, low, up, blank):
    """Mutate each letter with the same probability, like `kernels.mutate`."""
    for birth in range(keys.size):
        key, string = mix(keys[birth]), strings[birth]
        n = end_of(string, blank)
        i = gap(draw(key, 0, MUTATE + SALT * salt), chance)
        while i < n:
            change(string, n, i, way, np.float64(draw(key, i, LETTER + SALT * salt)), low, up)
            i += 1 + gap(draw(key, i + 1, MUTATE + SALT * salt), chance)


@njit
def mutate_by_gene(strings, keys, salt, way, chance, own, low, up, blank, words, k, size, spans, skipped):
    """Mutate like `mutate_letters`, except that a copy's letters after its promoter, which has `skipped`
    i64[genes] letters, mutate with the gene's own probability `own` f64[genes]."""
    longest = strings.shape[1]
    at, gene = np.empty(longest, np.int64), np.empty(longest, np.int64)
    rates = np.empty(longest, np.float64)
    for birth in range(keys.size):
        key, string = mix(keys[birth]), strings[birth]
        n = end_of(string, blank)
        rates[:n] = chance
        for c in range(parse(string, n, words, k, size, spans, at, gene)):
            rates[at[c] + skipped[gene[c]] : at[c] + spans[gene[c]]] = own[gene[c]]
        for i in range(n):
            if draw(key, i, MUTATE + SALT * salt) < rates[i]:
                change(string, n, i, way, np.float64(draw(key, i, LETTER + SALT * salt)), low, up)
