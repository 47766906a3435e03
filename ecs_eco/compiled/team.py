"""The helper threads of one world, and the kernels whose parts they take."""

from __future__ import annotations

import time
from typing import Any, TypeGuard

import numpy as np

from ecs_eco.compiled import parts
from ecs_eco.compiled.helpers import AWAKE, Helper
from ecs_eco.compiled.kernel import Kernel, KernelOnViews
from ecs_eco.compiled.parts import alone, can_be_divided, divided
from ecs_eco.compiled.spinning import looks_of
from ecs_eco.compiled.views import fields_of

NAP = 50e-6  # [s] time between checks for a late thread, whose core is busy with other work


class Team:
    """Threads that take parts of one kernel at a time, in parallel with the thread that runs it."""

    def __init__(self, helpers: int) -> None:
        self.record, self.room = parts.record_of_a_team(), np.zeros(parts.ROOM, np.uint8)
        self._address = self.room.ctypes.data
        self.helpers = [Helper(self.record) for _ in range(helpers)]

    def divides(self, kernel: object) -> TypeGuard[Kernel | KernelOnViews]:
        """Return whether a kernel can be run in parts."""
        return can_be_divided(kernel)

    def run(
        self, kernel: Kernel | KernelOnViews, first: int, last: int, k: int, arguments: tuple[Any, ...]
    ) -> None:
        """Run `kernel(first, last, *arguments)` in k parts. Raises RuntimeError if it fails in any part."""
        if isinstance(kernel, KernelOnViews):
            kernel, arguments = kernel.on_fields, fields_of(arguments)
        whole = divided(kernel)
        for helper in self.helpers:
            helper.wake()
        done = False
        try:
            done = whole(self.record, self.room, self._address, first, last, k, looks_of(AWAKE), *arguments)
        finally:
            if not done:
                self._wait()
        if self.record[parts.FAILED]:
            raise RuntimeError(
                f"kernel {kernel.py_func.__name__}: it failed in one of {k} parts; run the world with one "
                "thread to see the error"
            )

    def _wait(self) -> None:
        """Wait until no helper uses a kernel's arrays, even if an exception was raised."""
        interrupted = None
        while True:
            try:
                while not alone(self.record, 1):
                    time.sleep(NAP)
                break
            except KeyboardInterrupt as error:
                interrupted = error
        if interrupted is not None:
            raise interrupted
