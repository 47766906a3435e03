"""The description of a world in the ODD protocol (Grimm et al. 2020), generated from its declarations.

Text is kept with the code that it describes: descriptions and units of fields, docstrings, and the equations of
each `ecs_eco.engine.submodel.Submodel`. This package only arranges it.
"""

from ecs_eco._lazy import lazy

__getattr__ = lazy(__name__, {".document": "Document", ".protocol": "describe"})
