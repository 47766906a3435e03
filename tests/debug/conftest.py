"""The debug mode, and a wrong system in it."""

import pytest

from ecs_eco.debug import DebugError
from tests.debug.wrong import does


@pytest.fixture
def debug(monkeypatch):
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")


@pytest.fixture
def caught(debug, meadow):
    """A function that lets a wrong system act on the two deer (uids 3 and 4) in the debug mode,
    and returns what it is told."""

    def catch(work, *, setup=None, world=None, options=None, **deer):
        wrong = does(work)
        it = meadow(world=world, options={"systems": [wrong], **(options or {})}, **deer)
        if setup is not None:
            setup(it)
        with pytest.raises(DebugError) as error:
            it.run(5)
        assert it.tick == 2
        assert str(error.value).startswith("after Wrong, tick 2, ") or "field" in str(error.value)
        return str(error.value).removeprefix("after Wrong, tick 2, ")

    return catch
