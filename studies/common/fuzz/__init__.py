"""Randomly corrupted inputs for the `fuzz` study: starting points (`sources`), changes (`mutations`), trials
(`guard`) and outcomes (`worlds`, `files`)."""
