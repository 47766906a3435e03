"""Nervous systems: senses, the reflex, policy and happiness networks over them, and the decision H(y + z).

What the networks are lives here; when they run is the business of `ecs_eco.systems`.
"""
