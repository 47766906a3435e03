"""Individual weights of reflex and happiness networks, encoded in genes."""

from ecs_eco.engine.schema import component, f32


@component
class Instincts:
    """All weights of one organism's reflex network and happiness network, in one vector each; they do not
    change during life."""

    reflex: f32["reflex_weights"].heavy = 0.0
    happiness: f32["happiness_weights"].heavy = 0.0
