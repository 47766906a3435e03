"""The finite alphabet of a genome (the paper's Definition 3): letters outside, numbers u8 in columns."""

import numpy as np


class Alphabet:
    """Letters in an order of the user's choice; a locus of a genome holds the number of one of them, from 0."""

    def __init__(self, letters: str = "ACGT") -> None:
        if not 2 <= len(letters) <= 256:
            raise ValueError(f"alphabet {letters!r} has {len(letters)} letters; allowed are 2 to 256")
        twice = [c for i, c in enumerate(letters) if c in letters[:i]]
        if twice:
            raise ValueError(f"alphabet {letters!r}: the letter {twice[0]!r} occurs twice")
        self.letters = letters
        self._number = {letter: i for i, letter in enumerate(letters)}

    def __len__(self) -> int:
        return len(self.letters)

    def __repr__(self) -> str:
        return f"Alphabet({self.letters!r})"

    def encode(self, text: str) -> np.ndarray:
        """Return the numbers of a text's letters: u8[loci].

        Raises ValueError that names the place and the letter.
        """
        try:
            return np.array([self._number[letter] for letter in text], np.uint8)
        except KeyError:
            at = next(i for i, letter in enumerate(text) if letter not in self._number)
            raise ValueError(
                f"genome: {text[at]!r} at place {at} is no letter of the alphabet {self.letters!r}"
            ) from None

    def decode(self, loci: np.ndarray) -> str:
        """Return the text of a row u8[loci]. Raises ValueError that names the place and the number."""
        row = np.asarray(loci)
        if row.ndim != 1 or row.dtype.kind not in "ui":
            raise ValueError(
                f"genome: an array of {row.dtype} with the shape {row.shape}; "
                "allowed is one row of whole numbers"
            )
        wrong = np.flatnonzero((row < 0) | (row >= len(self)))
        if wrong.size:
            raise ValueError(
                f"genome: {row[wrong[0]]} at place {wrong[0]} is no letter's number; "
                f"allowed are 0 to {len(self) - 1}"
            )
        return "".join(self.letters[i] for i in row.tolist())


DNA = Alphabet()
