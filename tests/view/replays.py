"""Runs of a menagerie that replays are made of."""

import time

from ecs_eco.record import run_to_folder

TICKS = 48
GENES = {"genes": [{"name": "pace", "trait": "locomotion.pace", "low": 0.5, "high": 2.0, "letters": 2}]}
MADE = {"species": {"ram": {"genome": GENES}}, "sun": {"day": 24.0, "start": 0.25}}


def record(config, out, ticks=TICKS, **options):
    """Record a run whose animals learn."""
    options = {
        "seed": 7,
        "policies": "untrained",
        "learn": True,
        "report": False,
        "snapshot_every": 6,
        **options,
    }
    return run_to_folder(config, ticks=ticks, out=out, **options)


def answered(replay, seconds=60.0):
    """Wait for what a replay computes beside; return its messages."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if messages := replay.news():
            return messages
        time.sleep(0.02)
    raise AssertionError("no answer came")
