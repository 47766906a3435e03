"""Inputs that nobody would write, for the study `fuzz`: how they are made (`mutations`),
and what becomes of them."""
