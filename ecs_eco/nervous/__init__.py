"""Nervous systems: senses; reflex, policy and happiness networks; and the decision H(y + z).

`ecs_eco.systems` runs them in each tick; `ecs_eco.learning` trains policies.
"""
