"""Nervous systems: senses, the reflex, policy and happiness networks over them, and the decision H(y + z).

When they run belongs to `ecs_eco.systems`, how a policy learns to `ecs_eco.learning`.
"""
