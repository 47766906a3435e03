"""What processes do together between two ticks: stop, look at the whole world, collect records."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.bands.bands import mpi
from ecs_eco.bands.gather import gather
from ecs_eco.bands.records import collect

if TYPE_CHECKING:
    from ecs_eco.record.recorder import Recorder

STOP, GATHER, ASK, COLLECT, END = 1, 2, 4, 8, 16  # bits of what a process says


class Talk:
    """Process 0 asks, the others answer: before each tick they hear whether to go on, or what to do first.

    Where all processes run the same script, all may ask at once, and get the same answer.
    """

    def __init__(self, bands: Any) -> None:
        self.bands, self.world = bands, bands.world
        self.wishes = False  # whether this process has been told to stop
        self._answering = False

    def say(self, word: int) -> int:
        """Say something, or 0; return all that is said."""
        said = np.array([word | (STOP if self.wishes else 0)], np.int32)
        out = np.empty_like(said)
        self.bands.wire.comm.Allreduce(said, out, op=mpi().BOR)
        return int(out[0])

    def go_on(self) -> bool:
        """Answer until all are to go on; return whether to stop."""
        return bool(self._answer(0, 0) & STOP)

    def serve(self) -> None:
        """Answer until process 0 says that it is the end."""
        self._answer(0, END)

    def end(self) -> None:
        """Say that it is the end."""
        self.say(END)

    def _answer(self, word: int, until: int) -> int:
        while True:
            said = self.say(word)
            if said & GATHER:
                gather(self.bands)
            elif said & ASK:
                self._all(None)
            elif said & COLLECT:
                self._answering = True
                try:
                    self.world.recorder.flush()
                finally:
                    self._answering = False
            elif said & until or not until:
                if said & STOP:
                    self.wishes = False
                return said

    def undivided(self) -> Any:
        """Return the whole world in process 0, None in the others."""
        self.say(GATHER)
        return gather(self.bands)

    def ask(self, what: Callable[[Any], Any]) -> Any:
        """Return what a function says of the whole world, in all processes that ask."""
        self.say(ASK)
        return self._all(what)

    def _all(self, what: Callable[[Any], Any] | None) -> Any:
        whole = gather(self.bands)
        return self.bands.wire.comm.bcast(what(whole) if what is not None and whole is not None else None)

    def collect(self, recorder: Recorder) -> None:
        """Bring what all have recorded to process 0."""
        if not self._answering and not self.world.ticking:
            self.say(COLLECT)
        collect(self.bands, recorder)
