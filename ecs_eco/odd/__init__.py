"""The description of a world in the ODD protocol (Grimm et al. 2020), generated from its declarations.

Text is kept with the code that it describes: the fields of sections have descriptions and units, systems and
components have docstrings, and each `ecs_eco.engine.submodel.Submodel` has equations. This package only
arranges them.
"""

from ecs_eco._lazy import lazy

__getattr__ = lazy(__name__, {".document": "Document", ".protocol": "describe"})
