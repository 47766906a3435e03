"""The command line: turns arguments into calls, and results into lines of text.

The work of a command belongs to the package, where Python can call it too. The module of a
command is imported when the command is called (`app.COMMANDS`), so that --help and list are quick.
"""

from ecs_eco.cli.app import app, main

__all__ = ["app", "main"]
