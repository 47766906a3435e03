import numpy as np
import pytest

from ecs_eco.engine.uids import MOST_ISLANDS, first_uid, is_given, island_of, matched


def test_islands_count_from_numbers_that_none_of_them_reaches():
    assert [first_uid(0), first_uid(1), first_uid(2)] == [1, 2**48 + 1, 2 * 2**48 + 1]
    uids = np.array([1, 2**48 - 1, 2**48 + 1, 31 * 2**48 + 5], np.uint64)
    assert island_of(uids).tolist() == [0, 0, 1, 31]
    assert island_of(2**48 + 7) == 1


def test_all_uids_are_whole_numbers_that_a_float64_holds():
    assert first_uid(MOST_ISLANDS) - 1 == 2**53


@pytest.mark.parametrize(("uid", "given"), [(5, True), (9, False), (2**48 + 99, True)])
def test_a_uid_of_another_island_may_live_here_and_one_not_given_yet_may_not(uid, given):
    assert is_given(np.array([uid], np.uint64), 9).tolist() == [given]


@pytest.mark.parametrize("known", [[], [7], [2, 3, 5, 2**53 - 1]])
def test_uids_are_found_among_sorted_ones_as_in_a_list(known):
    wanted = np.array([0, 2, 4, 5, 7, 2**53 - 1, 2**53 - 2], np.uint64)
    at, there = matched(np.array(known, np.uint64), wanted)
    assert [at[i] if there[i] else None for i in range(wanted.size)] == [
        known.index(uid) if uid in known else None for uid in wanted.tolist()
    ]
    assert [len(found) for found in matched(np.array(known, np.uint64), wanted[:0])] == [0, 0]
