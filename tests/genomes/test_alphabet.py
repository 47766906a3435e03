import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Genome
from ecs_eco.genomes import DNA, Alphabet


def test_a_text_becomes_a_row_of_numbers_and_back():
    row = DNA.encode("GATTACA")
    assert row.dtype == np.uint8
    assert row.tolist() == [2, 0, 3, 3, 0, 1, 0]
    assert DNA.decode(row) == "GATTACA"
    assert DNA.encode("").shape == (0,)
    assert DNA.decode(np.zeros(0, np.uint8)) == ""


def test_the_letters_are_the_users_choice():
    binary, greek = Alphabet("01"), Alphabet("αβγ")
    assert binary.encode("0110").tolist() == [0, 1, 1, 0]
    assert greek.decode(np.array([2, 1, 0])) == "γβα"
    assert (len(greek), repr(greek)) == (3, "Alphabet('αβγ')")
    assert len(Alphabet("".join(map(chr, range(1000, 1256))))) == 256


def test_every_text_of_the_alphabet_survives():
    rng = np.random.default_rng(0)
    for letters in ("ACGT", "ab", "ACDEFGHIKLMNPQRSTVWY"):
        alphabet = Alphabet(letters)
        row = rng.integers(0, len(letters), 200).astype(np.uint8)
        assert (alphabet.encode(alphabet.decode(row)) == row).all()


def test_errors_name_the_place_and_the_letter():
    with pytest.raises(ValueError, match="genome: 'U' at position 2 is not in the alphabet 'ACGT'"):
        DNA.encode("GAUACU")
    with pytest.raises(
        ValueError, match="genome: 4 at position 1 is not the number of a letter; expected 0 to 3"
    ):
        DNA.decode(np.array([0, 4, 9], np.uint8))
    with pytest.raises(ValueError, match="genome: -1 at position 0"):
        DNA.decode(np.array([-1]))
    with pytest.raises(
        ValueError,
        match=r"an array of float64 with shape \(2,\); "
        r"expected one row of whole numbers",
    ):
        DNA.decode(np.array([0.0, 1.0]))
    with pytest.raises(ValueError, match=r"with shape \(1, 2\)"):
        DNA.decode(np.zeros((1, 2), np.uint8))


@pytest.mark.parametrize(
    ("letters", "message"),
    [
        ("A", "has 1 letters; expected 2 to 256"),
        ("", "has 0 letters"),
        ("ACGA", "the letter 'A' occurs twice"),
    ],
)
def test_an_alphabet_that_cannot_be_is_refused(letters, message):
    with pytest.raises(ValueError, match=message):
        Alphabet(letters)


def test_a_genome_lives_in_a_column():
    world = World()
    table = world.add_table("bacterium", Genome, dims={"loci": 7})
    world.spawn("bacterium", Genome(loci=DNA.encode("GATTACA")), n=2)
    world.flush()
    table[Genome].loci[1, 0] = 1
    assert [DNA.decode(row) for row in table[Genome].loci[:2]] == ["GATTACA", "CATTACA"]
