"""The description of a world by the ODD protocol (Grimm et al. 2020), made from its declarations.

Texts belong next to what they describe: descriptions and units to the fields of sections, sentences to the
docstrings of systems and components, equations to `ecs_eco.engine.submodel.Submodel`. Here they are put in order.
"""

from ecs_eco._lazy import lazy

__all__ = ["Document", "describe"]
__getattr__ = lazy(__name__, {"Document": "ecs_eco.odd.document", "describe": "ecs_eco.odd.protocol"})
