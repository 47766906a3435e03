"""The debug mode, and a wrong system in it."""

import pytest

from ecs_eco.debug import DebugError
from tests.debug.wrong import deer, does


@pytest.fixture
def debug(monkeypatch):
    monkeypatch.setenv("ECS_ECO_DEBUG", "1")


@pytest.fixture
def caught(debug, meadow):
    """A function that lets a wrong system act on the two deer in the debug mode and returns the message.
    Its attribute `uids` holds the uids that the deer of this world began with, in the order of their rows."""

    def catch(work, *, setup=None, world=None, options=None, **changes):
        wrong = does(work)
        it = meadow(world=world, options={"systems": [wrong], **(options or {})}, **changes)
        catch.uids = deer(it)
        if setup is not None:
            setup(it)
        with pytest.raises(DebugError) as error:
            it.run(5)
        assert it.tick == 2
        assert str(error.value).startswith("after Wrong, tick 2, ") or "field" in str(error.value)
        return str(error.value).removeprefix("after Wrong, tick 2, ")

    return catch
