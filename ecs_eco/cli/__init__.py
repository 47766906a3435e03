"""The command line: turns arguments into calls, and results into lines of text.

The work of a command belongs to the package, where Python can call it too. Commands import what they need
when they run, so that --help and list are quick.
"""

from ecs_eco.cli.app import app, main

__all__ = ["app", "main"]
