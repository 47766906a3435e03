"""Promoters: the words that mark genes in strings of variable length.

A string is read from its first letter. A promoter followed by the letters that its gene needs is a copy of
the gene, and reading continues after it; any other letter is neutral.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ecs_eco.engine.errors import Problem
from ecs_eco.genomes.models import Gene, GenomeSection
from ecs_eco.genomes.problems import n_codons
from ecs_eco.genomes.traits import Shapes, Trait

MOST_WORDS = 2**16  # maximum number of words as long as the longest promoter
LONGEST = 1_000_000  # maximum number of letters in a string of variable length
RARE = 64  # with default promoters, a gene begins about once in this many random letters
MOST_LETTERS = 254  # letters in an alphabet; two more numbers mark string ends and, in texts, separators
ONLY = {"promoter": None, "copies": 1, "copy_rule": None}  # keys of a gene that require variable length


def default_promoters(n: int, letters: str) -> list[str]:
    """Return words of equal length for n genes, evenly spaced in alphabetical order."""
    size, length = len(letters), 1
    while size**length < RARE * n and size ** (length + 1) <= MOST_WORDS:
        length += 1
    numbers = (int((i + 0.5) * size**length / n) for i in range(n))
    digits = (np.unravel_index(number, (size,) * length) for number in numbers)
    return ["".join(letters[digit] for digit in word) for word in digits]


def promoters_of(genes: Sequence[Gene], letters: str) -> list[str]:
    """Return each gene's promoter, whether given or the default."""
    given = default_promoters(len(genes), letters)
    return [gene.promoter or word for gene, word in zip(genes, given, strict=True)]


def word_table(promoters: Sequence[str], letters: str) -> np.ndarray:
    """Return, for each word, the gene whose promoter begins it, or −1: i16[size ** length]."""
    size, length = len(letters), max(map(len, promoters))
    table = np.full(size**length, -1, np.int16)
    for gene, word in enumerate(promoters):
        first = sum(letters.index(letter) * size ** (length - 1 - i) for i, letter in enumerate(word))
        table[first : first + size ** (length - len(word))] = gene
    return table


def copies_in(
    string: str, promoters: Mapping[str, str], spans: Mapping[str, int]
) -> Iterator[tuple[str, int]]:
    """Yield the genes in a string, given as text: the name of each copy and the start of its promoter.

    `promoters` and `spans` (letters per copy, including its promoter) are keyed by gene name.
    """
    at = 0
    while at < len(string):
        here = next(
            (
                name
                for name, word in promoters.items()
                if string.startswith(word, at) and at + spans[name] <= len(string)
            ),
            None,
        )
        if here is not None:
            yield here, at
        at += 1 if here is None else spans[here]


def problems_of_variable(
    section: GenomeSection, traits: Mapping[str, Trait] | None, shapes: Mapping[str, Shapes]
) -> Iterator[Problem]:
    """Yield the problems in a genome section that concern strings of variable length."""
    if section.max_length is None:
        fixed = "strings of this genome have a fixed length"
        for key in ("insertion", "base_deletion", "duplication", "gene_deletion"):
            if value := getattr(section, key):
                yield Problem((key,), fixed, value, "max_length = …, or remove this key")
        for i, gene in enumerate(section.genes):
            for key, default in ONLY.items():
                if (value := getattr(gene, key)) != default:
                    yield Problem(
                        ("genes", i, key), fixed, value, "genome.max_length = …, or remove this key"
                    )
        return
    if len(letters := section.alphabet) > MOST_LETTERS:
        what = "too many letters for strings of variable length"
        yield Problem(("alphabet",), what, letters, f"at most {MOST_LETTERS}")
    for first, second in (("insertion", "base_deletion"), ("duplication", "gene_deletion")):
        a, b = getattr(section, first), getattr(section, second)
        if a + b > 1:
            yield Problem((second,), f"sum with {first} exceeds 1", b, f"at most {1 - a:g}")
    for i, gene in enumerate(section.genes):
        if gene.at is not None:
            what = "genes have no fixed positions in strings of variable length"
            yield Problem(("genes", i, "at"), what, gene.at, "promoter = …, or remove this key")
    yield from _of_words(section.genes, letters)
    yield from _of_lengths(section, traits or {}, shapes)


def _of_words(genes: Sequence[Gene], letters: str) -> Iterator[Problem]:
    """Yield a problem if a promoter is not a word over the alphabet, or if it begins with another promoter."""
    most = max(k for k in range(1, 17) if len(letters) ** k <= MOST_WORDS)
    words = promoters_of(genes, letters)
    for i, word in enumerate(words):
        key = ("genes", i, "promoter")
        if wrong := [letter for letter in word if letter not in letters]:
            yield Problem(key, f"{wrong[0]!r} is not in the alphabet", word, f"letters of {letters!r}")
        elif len(word) > most:
            yield Problem(key, f"too long with {len(letters)} letters", word, f"at most {most} letters")
        for j, other in enumerate(words[:i]):
            if word.startswith(other) or other.startswith(word):
                what = f"one begins with the other: the promoter of {genes[j].name} is {other!r}"
                yield Problem(key, what, word, "words that do not begin with one another")
                break


def _of_lengths(
    section: GenomeSection, traits: Mapping[str, Trait], shapes: Mapping[str, Shapes]
) -> Iterator[Problem]:
    """Yield a problem if a founder's genes do not fit into its string, or its string is too long."""
    longest = section.max_length or 0
    if longest > LONGEST:
        yield Problem(("max_length",), "too many letters", longest, f"at most {LONGEST}")
    words = promoters_of(section.genes, section.alphabet)
    needed = sum(
        gene.copies * (len(word) + (n_codons(gene, traits.get(gene.trait or ""), shapes) or 0) * gene.letters)
        for gene, word in zip(section.genes, words, strict=True)
    )
    if section.loci is not None and section.loci < needed:
        what = f"string is too short: a founder's genes need {needed} letters"
        yield Problem(("loci",), what, section.loci, f"at least {needed}")
    if needed == 0 and section.loci is None:
        what = "founders have neither genes nor other letters"
        yield Problem(("genes",), what, allowed="copies = 1 for a gene, or loci = …")
    if longest < (least := max(needed, section.loci or 0)):
        yield Problem(("max_length",), "founders have more letters", longest, f"at least {least}")
