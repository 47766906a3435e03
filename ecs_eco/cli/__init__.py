"""The command line: converts arguments to function calls, and results to text.

The work itself is done by other packages, so Python code can call them directly. A command's module is imported
only when the command is called (`app.COMMANDS`), so --help and list are quick.
"""

from ecs_eco.cli.app import app, main

__all__ = ["app", "main"]
