"""The command line: what turns words into calls, and results into lines.

What a command does belongs to the package, where Python can call it too. Commands import what they need when
they run, so that --help and list are quick.
"""

from ecs_eco.cli.app import app, main

__all__ = ["app", "main"]
