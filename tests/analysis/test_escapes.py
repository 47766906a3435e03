"""An escape by hand."""

from dataclasses import replace

import numpy as np
import pytest

from ecs_eco.analysis.escapes import escapes
from ecs_eco.analysis.tracks import Tracks


def test_an_escape_by_hand():
    distance = np.full((14, 1), 5.0)
    distance[7:] = 1.0
    speed = np.full((14, 1), 0.5)
    speed[8] = 2.0
    away = np.zeros((14, 1))
    away[8] = 1.0
    tracks = Tracks(
        np.zeros(1, np.uint64), np.ones((14, 1)), speed, distance, away, np.zeros((14, 1)), np.zeros(14)
    )
    response = escapes(tracks)
    assert (response.n, response.gain, response.latency) == (1, 4.0, 1)
    assert response.u == pytest.approx(2**0.5)
    assert escapes(replace(tracks, distance=np.full((14, 1), 5.0))) is None
