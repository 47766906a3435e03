"""The command line. Commands import what they need when they run, so that --help and list are quick.

What a command does belongs to the package; here is only what turns words into calls, and results into lines.
"""

from ecs_eco.cli.app import app, main

__all__ = ["app", "main"]
