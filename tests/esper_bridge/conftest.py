"""The world that tests of esper's functions begin with."""

import pytest

from ecs_eco import World
from tests.esper_bridge.populations import populated


@pytest.fixture
def world():
    """Hares 1 to 3 and the fox 4, on a plane of 10 m by 10 m."""
    return populated(World((10, 10)))
