"""Going back in a live world, by rerunning it from the nearest checkpoint in memory."""

import json
import time
from collections import deque
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.record import freeze as frozen, parts
from ecs_eco.view.journal import Journal
from ecs_eco.view.story import Story

MEMORY = 96e6  # [bytes] maximum total size of checkpoints; beyond that, the oldest is dropped
SHARE = 1 / 120  # maximum share of run time spent on checkpoints
APART = 0.1  # [s] minimum run time between checkpoints; shorter stretches are quickly rerun


class Point(NamedTuple):
    """A checkpoint in memory, with the viewer's state at that tick."""

    tick: int
    meta: str  # JSON
    arrays: dict[str, Any]
    config: Any
    recording: Any
    journal: tuple[np.ndarray, ...]
    story: tuple[Any, ...]
    size: int  # [bytes]


class Ring:
    """Checkpoints made while a world runs, and interventions from pages, so that a rerun can repeat them. `why`
    is why this world cannot go back, "" if it can; runs recorded to files cannot."""

    def __init__(self, world: World, journal: Journal, story: Story) -> None:
        self.world, self.journal, self.story = world, journal, story
        self.points: deque[Point] = deque()
        self.acts: list[tuple[int, Any]] = []  # (tick, intervention), in order
        self.used = False  # whether checkpoints are made
        self.busy = False  # whether the world is rerunning ticks
        self.why = ""
        self._cost, self._since = 0.0, time.thread_time()
        if world.recorder is not None and not parts.can_go_back(world.recorder):
            self.why = "this run is being recorded, and its records cannot be undone"

    @property
    def first(self) -> int:
        """The earliest tick to which the world can go back, or the current tick."""
        return self.points[0].tick if self.points and not self.why else self.world.tick

    def look(self) -> None:
        """Make a checkpoint before a tick if one is due."""
        if self.why or (self.points and self.points[-1].tick >= self.world.tick):
            return
        begin = time.thread_time()
        if self.points and begin - self._since < max(APART, self._cost / SHARE):
            return
        try:
            self._keep()
        except (CheckpointError, TypeError, ValueError) as error:
            self.why = f"no checkpoint can be made of this world: {error}"
            self.points.clear()
        self._since = time.thread_time()
        if len(self.points) > 1:  # the first checkpoint is slow, because it loads modules
            spent = self._since - begin
            self._cost = min(spent, self._cost) if self._cost else spent

    def back(self, tick: int) -> int:
        """Take the world back to a tick, or to the earliest possible; return it. Raises ValueError if it cannot."""
        if self.why or not self.points:
            raise ValueError(f"seek: {self.why or 'there is no checkpoint yet'}")
        if tick > self.world.tick:
            raise ValueError(f"seek: tick = {tick}; expected at most {self.world.tick}, the current tick")
        tick = max(tick, self.points[0].tick)
        while self.points[-1].tick > tick:
            self.points.pop()
        self.acts = [act for act in self.acts if act[0] < tick]
        world, point = self.world, self.points[-1]
        self.busy = True
        try:
            if world.recorder is not None:
                parts.go_back(world.recorder, point.recording)
            if world.config is not point.config:
                world.reconfigure(point.config)
            frozen.load(world, json.loads(point.meta), point.arrays, f"tick {point.tick}")
            self.journal.go_back(point.tick, int(world.next_uid), point.journal)
            self.story.go_back(point.story)
            for when, what in [act for act in self.acts if act[0] >= world.tick]:
                world.run(when - world.tick)
                world.intervene(what)
            world.run(tick - world.tick)
        finally:
            self.busy = False
        self._since = time.thread_time()
        return tick

    def _keep(self) -> None:
        world, recorder = self.world, self.world.recorder
        meta, arrays = frozen.freeze(world, recording=False)
        arrays = {name: array.copy() for name, array in arrays.items()}
        recording = None if recorder is None else parts.mark(recorder)
        self.points.append(
            Point(
                world.tick,
                json.dumps(meta),
                arrays,
                world.config,
                recording,
                self.journal.mark(),
                self.story.mark(),
                sum(array.nbytes for array in arrays.values()),
            )
        )
        while len(self.points) > 2 and sum(point.size for point in self.points) > MEMORY:
            self.points.popleft()
