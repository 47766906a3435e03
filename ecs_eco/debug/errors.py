"""What a failed check raises."""


class DebugError(RuntimeError):
    """A check of the debug mode that failed: the system, the tick, the species, the column,
    the organism and the value."""


class StaleHandle(DebugError):
    """A handle that was kept past its owner's death."""
