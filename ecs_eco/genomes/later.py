"""Kernels for genomes, which load numba lazily, so that layouts can be checked without it."""

from typing import TYPE_CHECKING

from ecs_eco._lazy import Later

if TYPE_CHECKING:
    from ecs_eco.genomes import kernels as kernels, variable_kernels as variable_kernels
else:
    kernels = Later("ecs_eco.genomes.kernels")
    variable_kernels = Later("ecs_eco.genomes.variable_kernels")
