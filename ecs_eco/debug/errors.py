"""Errors of failed checks."""


class DebugError(RuntimeError):
    """Raised by a failed check of the debug mode, with the system, tick, species, column, organism and
    value."""


class StaleHandle(DebugError):
    """Raised for a handle that was used after its owner's death."""
