"""The former name of `ecs_eco.analysis.seed_grid`, which version 0.1 documents."""

from ecs_eco.analysis.seed_grid import Grid, crossed, effective_runs, share_interval, variance_shares

__all__ = ["Grid", "crossed", "effective_runs", "share_interval", "variance_shares"]
