"""The finite alphabet of a genome (Definition 3 in the paper), written as letters in text and as u8 numbers
in columns."""

import numpy as np


class Alphabet:
    """The letters of a genome, in an order of your choice; each locus contains the number of a letter,
    counted from 0.

    Parameters
    ----------
    letters : str, default "ACGT"
        2 to 256 different letters.

    Raises
    ------
    ValueError
        If the number of letters is wrong, or a letter occurs twice.

    Notes
    -----
    Definition 3 in the paper; see docs/explanation/definitions.md.

    Examples
    --------
    >>> from ecs_eco.genomes import Alphabet
    >>> binary = Alphabet("01")
    >>> binary.encode("0110").tolist(), len(binary)
    ([0, 1, 1, 0], 2)
    """

    def __init__(self, letters: str = "ACGT") -> None:
        if not 2 <= len(letters) <= 256:
            raise ValueError(f"alphabet {letters!r} has {len(letters)} letters; expected 2 to 256")
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
        """Return the numbers of a text's letters.

        Parameters
        ----------
        text : str

        Returns
        -------
        array of uint8, shape (loci,)

        Raises
        ------
        ValueError
            If a letter is not in the alphabet; the message gives its position.

        Examples
        --------
        >>> from ecs_eco.genomes import DNA
        >>> DNA.encode("GATTACA").tolist()
        [2, 0, 3, 3, 0, 1, 0]
        """
        try:
            return np.array([self._number[letter] for letter in text], np.uint8)
        except KeyError:
            at = next(i for i, letter in enumerate(text) if letter not in self._number)
            raise ValueError(
                f"genome: {text[at]!r} at position {at} is not in the alphabet {self.letters!r}"
            ) from None

    def decode(self, loci: np.ndarray) -> str:
        """Return a row of numbers as text.

        Parameters
        ----------
        loci : array of int, shape (loci,)

        Returns
        -------
        str

        Raises
        ------
        ValueError
            If a number does not stand for a letter; the message gives its position.

        Examples
        --------
        >>> import numpy as np
        >>> from ecs_eco.genomes import DNA
        >>> DNA.decode(np.array([2, 0, 3], np.uint8))
        'GAT'
        """
        row = np.asarray(loci)
        if row.ndim != 1 or row.dtype.kind not in "ui":
            raise ValueError(
                f"genome: an array of {row.dtype} with shape {row.shape}; expected one row of whole numbers"
            )
        wrong = np.flatnonzero((row < 0) | (row >= len(self)))
        if wrong.size:
            raise ValueError(
                f"genome: {row[wrong[0]]} at position {wrong[0]} is not the number of a letter; expected 0 to "
                f"{len(self) - 1}"
            )
        return "".join(self.letters[i] for i in row.tolist())


DNA = Alphabet()
