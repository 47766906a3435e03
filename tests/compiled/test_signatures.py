"""Types of arguments as text."""

import numpy as np
import pytest
from numba import typeof, types

from ecs_eco.compiled import signatures


def readonly(array):
    array.flags.writeable = False
    return array


@pytest.mark.parametrize(
    "value",
    [
        1,
        2.0,
        True,
        None,
        np.float32(1),
        np.uint64(3),
        np.zeros(3, np.float32),
        np.zeros((3, 2), np.int64),
        np.zeros((4, 4))[::2, ::2],
        np.asfortranarray(np.zeros((3, 2))),
        readonly(np.zeros(2)),
        np.zeros(3, bool),
        (1, 2),
        (1, 2.0, (3, 4.0)),
        (np.zeros(1), np.zeros((1, 1), np.uint8)),
    ],
    ids=repr,
)
def test_types_are_read_back_from_text(value):
    signature = (typeof(value), types.int64)
    assert signatures.read(signatures.text(signature)) == signature


def test_no_arguments_are_an_empty_text():
    assert signatures.read("") == ()


def test_what_cannot_be_read_back_has_no_text():
    assert signatures.text((types.unicode_type, types.int64)) == ""
    with pytest.raises(ValueError, match="'unicode_type' is not a number, an array or a tuple of them"):
        signatures.read("unicode_type")
