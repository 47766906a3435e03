"""Weights of an organism's reflex and happiness networks, where genes code for them."""

from ecs_eco.engine.schema import component, f32


@component
class Instincts:
    """All weights of one organism's reflex network, and of its happiness network, in one vector each;
    nothing in life changes them."""

    reflex: f32["reflex_weights"].heavy = 0.0
    happiness: f32["happiness_weights"].heavy = 0.0
