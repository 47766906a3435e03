"""The names that Gymnasium knows, and what is said where a package is missing."""

import subprocess
import sys

import pytest

from ecs_eco.rl.registration import ENVIRONMENTS, needed, register


def test_registering_twice_is_registering_once():
    registration = pytest.importorskip("gymnasium.envs.registration")
    register()
    before = len(registration.registry)
    register()
    assert len(registration.registry) == before
    assert {f"ecs_eco/{name}" for name in ENVIRONMENTS} <= set(registration.registry)


@pytest.mark.slow
def test_what_is_missing_says_how_to_install_it():
    assert 'pip install -e ".[rl]" in the source folder' in str(needed("pettingzoo"))
    script = (
        "import sys; sys.modules['pettingzoo'] = None\nimport ecs_eco.rl\n"
        "try:\n    ecs_eco.rl.parallel_env\nexcept ModuleNotFoundError as error:\n    print(error)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert 'pip install -e ".[rl]" in the source folder' in done.stdout
