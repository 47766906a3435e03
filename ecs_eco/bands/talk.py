"""Joint actions of all processes between ticks: stop, assemble the whole world, collect records."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.bands.bands import mpi
from ecs_eco.bands.gather import gather
from ecs_eco.bands.records import collect

if TYPE_CHECKING:
    from ecs_eco.record.recorder import Recorder

STOP, GATHER, ASK, COLLECT, END = 1, 2, 4, 8, 16  # bits of a message


class Talk:
    """Process 0 sends requests, and the other processes serve them: before each tick, they receive a request
    or a message to continue.

    Processes that run the same script may all send the same request at once, and all get the same answer.
    """

    def __init__(self, bands: Any) -> None:
        self.bands, self.world = bands, bands.world
        self.wishes = False  # whether this process has been asked to stop
        self._answering = False

    def say(self, word: int) -> int:
        """Send a message (0: none); return the messages of all processes combined."""
        said = np.array([word | (STOP if self.wishes else 0)], np.int32)
        out = np.empty_like(said)
        self.bands.wire.comm.Allreduce(said, out, op=mpi().BOR)
        return int(out[0])

    def go_on(self) -> bool:
        """Serve requests until all processes continue, and return whether to stop."""
        return bool(self._answer(0, 0) & STOP)

    def serve(self) -> None:
        """Serve requests until process 0 announces the end of the run."""
        self._answer(0, END)

    def end(self) -> None:
        """Announce the end of the run."""
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
        """Return the whole world in process 0, and None in the other processes."""
        self.say(GATHER)
        return gather(self.bands)

    def ask(self, what: Callable[[Any], Any]) -> Any:
        """Apply a function to the whole world and return its value in every process that asks for it."""
        self.say(ASK)
        return self._all(what)

    def _all(self, what: Callable[[Any], Any] | None) -> Any:
        whole = gather(self.bands)
        return self.bands.wire.comm.bcast(what(whole) if what is not None and whole is not None else None)

    def collect(self, recorder: Recorder) -> None:
        """Send the records of all processes to process 0."""
        if not self._answering and not self.world.ticking:
            self.say(COLLECT)
        collect(self.bands, recorder)
