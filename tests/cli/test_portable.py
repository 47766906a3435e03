"""`ecs-eco --portable`, and what it says where the mode cannot be had."""

import os
import subprocess
import sys


def command(*words, **variables):
    code = "from ecs_eco.cli import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *words],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_the_mode_can_be_asked_for_before_any_command():
    done = command("--portable", "list")
    assert done.returncode == 0, done.stderr
    assert "predator-prey" in done.stdout


def test_a_wrong_word_is_refused_with_code_2():
    done = command("list", ECS_ECO_PORTABLE="yes")
    assert done.returncode == 2
    assert "ECS_ECO_PORTABLE=yes: expected 1" in done.stderr
    assert "Traceback" not in done.stderr
