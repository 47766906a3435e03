"""Randomly corrupted inputs for the study `fuzz`: starting points (`sources`), changes (`mutations`), trials
(`guard`) and outcomes (`worlds`, `files`)."""
