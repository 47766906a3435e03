"""The command line: converts arguments to calls, and results to lines of text.

The work of a command belongs to the package, so that Python can call it too. A command's module is imported
when the command is called (`app.COMMANDS`), so that --help and list are quick.
"""

from ecs_eco.cli.app import app, main

__all__ = ["app", "main"]
