"""Which versions of numba its private names (`ecs_eco.compiled.numba_private`) were tried with."""

TRIED = ("0.67", "0.68")  # minor versions


def summary() -> str:
    """Return which versions were tried, as `ecs-eco doctor` says it."""
    return f"tried with numba {' and '.join(TRIED)}"
