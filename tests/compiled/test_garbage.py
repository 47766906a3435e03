"""When Python looks for circles: not while figures are drawn or modules loaded, and as usual afterwards."""

import gc
import subprocess
import sys

from ecs_eco.compiled.garbage import uncollected

COMMAND = """
import gc
from ecs_eco.compiled.garbage import loaded, of_a_command

usual = gc.get_threshold()
with of_a_command():
    during = gc.get_threshold()
    gc.disable()
    loaded()
    after, on, kept = gc.get_threshold(), gc.isenabled(), gc.get_freeze_count()
    more = [[] for _ in range(1000)]
print(usual == after, during[0] > usual[0], on, kept > 1000, gc.get_freeze_count() > kept)
"""


def test_python_looks_for_no_circles_within_and_does_so_afterwards():
    for collecting in (True, False):
        (gc.enable if collecting else gc.disable)()
        try:
            with uncollected():
                assert not gc.isenabled()
            assert gc.isenabled() == collecting
        finally:
            gc.enable()


def test_a_command_begins_and_ends_without_looking_at_what_it_has_loaded():
    done = subprocess.run([sys.executable, "-c", COMMAND], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True"] * 5


def test_loading_changes_nothing_outside_of_a_command():
    from ecs_eco.compiled.garbage import loaded

    before = gc.get_threshold(), gc.get_freeze_count()
    loaded()
    assert (gc.get_threshold(), gc.get_freeze_count()) == before
