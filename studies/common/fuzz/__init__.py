"""Inputs that nobody would write, for the study `fuzz`: what they start from (`sources`), how they are made
(`mutations`), how they are tried (`guard`), and what becomes of them."""
