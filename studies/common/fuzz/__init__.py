"""Randomly broken inputs for the study `fuzz`: their starting points (`sources`), the changes
(`mutations`), the trials (`guard`) and their outcomes (`worlds`, `files`)."""
