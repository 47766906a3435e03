"""What studies of goats measure in a lineage."""

from studies.common.goats import mean_generation
from tests.analysis.families import family


def test_the_mean_generation_is_that_of_the_living():
    generations = mean_generation(family(), "finch", 3)  # ticks 0, 3, 6, 9
    assert generations.tolist() == [0, (0 + 0 + 1 + 1) / 4, (0 + 1 + 2) / 3, (2 + 3 + 0 + 2.5 + 0) / 5]
