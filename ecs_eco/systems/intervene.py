"""Interventions: cull, add organisms, put up fences, lay roads, dose, set values, and switch reproduction or
learning on or off."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from ecs_eco.components import Biology, Body, Metabolism, Position
from ecs_eco.config.checks.interventions import learns
from ecs_eco.config.loading import changed, intervention
from ecs_eco.config.models.interventions import AnyIntervention
from ecs_eco.engine import random
from ecs_eco.engine.errors import unknown_name
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life.births import room
from ecs_eco.life.doses import dose_bodies, dose_field
from ecs_eco.life.founders import future, newcomers
from ecs_eco.space.gate import newborn
from ecs_eco.space.region import Region
from ecs_eco.space.terrain import Terrain

if TYPE_CHECKING:
    from ecs_eco.config.models.interventions import Add, Cull, Dose, Fence, Intervention, Road, Set, Switch
    from ecs_eco.engine.table import Table
    from ecs_eco.space.geometry import Space
    from ecs_eco.space.world import SpatialWorld

TIE = random.CULL + (1 << 23)  # purpose of the draws that break ties
CELL = 1.0  # [m] cell side of fences in a world without ground; smaller in a small world


class Intervene(System):
    """Carries out interventions from the world file and from `World.intervene` at the start of their tick.

    Culled organisms die at the end of the `die` phase of this tick, newcomers are alive from the end of the
    phase `reproduce` on, and everything else takes effect at once. `world.intervened` lists the interventions
    carried out so far.
    """

    phase = "environment"
    divisible = True
    submodel = Submodel("Interventions", where=("interventions",))
    world: Any  # an `ecosystem.World`, which can be reconfigured

    def __init__(self) -> None:
        self.requests: list[Any] = []  # requested with World.intervene for the next tick
        self.made_ground = False  # whether the world's ground was created for a fence

    def process(self, *_: object) -> None:
        """Carry out the interventions due in this tick, in file order, then the pending requests."""
        world = self.world
        plan = () if world.config is None else world.config.interventions
        planned = [x for x in plan if x.due(world.tick)] if plan else []
        pending, self.requests = self.requests, []
        for order in (*planned, *pending):
            getattr(self, order.kind)(world, order)
            world.intervened.append((world.tick, order.once(world.tick)))

    def ask(self, intervention: dict[str, Any] | Intervention) -> None:
        """Request an intervention, a dict or a model, for the next tick. Raises a ConfigError if a world file
        containing this intervention would be invalid."""
        self.requests.append(checked(self.world, intervention, [x.once(x.at) for x in self.requests]))

    def cull(self, world: SpatialWorld, order: Cull) -> None:
        """Mark members of a species for death."""
        table = world.table(order.species)
        rows = table.by_uid()
        rows = rows[table.cause[rows] == 0]
        if order.region is not None:
            p = table[Position]
            rows = rows[Region(world.space, order.region).has(p.x[rows], p.y[rows])]
        if order.uids is not None:
            rows = rows[np.isin(table.uid[rows], np.array(order.uids, np.uint64))]
            table.cause[rows] = world.cause(order.cause)
            return
        wanted = order.count if order.share is None else math.floor(order.share * rows.size + 0.5)
        rows = rows[random.by_lot(world.key, table.uid[rows], TIE)]
        first = np.argsort(_rank(table, rows, order.which, world.key), kind="stable")
        table.cause[rows[first[:wanted]]] = world.cause(order.cause)

    def add(self, world: SpatialWorld, order: Add) -> None:
        """Request newcomers."""
        table = world.table(order.species)
        count = room(table, world, order.count)
        if count == 0:
            return
        within = None if order.region is None else Region(world.space, order.region)
        values = newcomers(
            table, world, table.species.section, future(world, table, count), within, order.at_place
        )
        values = newborn(world, table, values, f"intervene: add {order.species!r}")
        table.request(np.zeros(values[Position, "x"].size, np.uint64), values)

    def fence(self, world: SpatialWorld, order: Fence) -> None:
        """Put up a fence, or remove one."""
        corners = None
        if order.line is not None:
            corners = np.array(order.line, float)
        elif order.region is not None:
            corners = Region(world.space, order.region).border()
        if world.terrain is None:
            if order.remove:
                return
            world.terrain, self.made_ground = flat_ground(world.space), True
        if order.remove:
            world.terrain.unfence(corners)
        elif corners is not None:
            world.terrain.fence(corners)

    def road(self, world: SpatialWorld, order: Road) -> None:
        """Lay a road, or remove one."""
        corners = None if order.line is None else np.array(order.line, float)
        if world.terrain is None:
            if order.remove:
                return
            world.terrain, self.made_ground = flat_ground(world.space), True
        if order.remove:
            world.terrain.unpave(corners)
        elif corners is not None:
            world.terrain.pave(corners, order.width, order.pace, order.cost)

    def dose(self, world: SpatialWorld, order: Dose) -> None:
        """Add a substance to a field or to bodies, or remove it."""
        region = None if order.region is None else Region(world.space, order.region)
        if order.field is not None:
            dose_field(world, order.field, order.amount, region)
        else:
            dose_bodies(world, world.table(order.species or ""), order.substance or "", order.amount, region)

    def set(self, world: Any, order: Set) -> None:
        """Change values in the world's configuration."""
        world.reconfigure(changed(world.config, order.set))

    def switch(self, world: Any, order: Switch) -> None:
        """Stop or restart births or learning."""
        names = (
            [order.species]
            if order.species
            else [n for n, t in world.tables.items() if not t.species.is_object]
        )
        if order.reproduction is not None:
            for name in names:
                world.table(name).species.barren = not order.reproduction
        if order.learning is not None:
            can = [n for n in names if learns(world.config.species[n])]
            world.reconfigure(
                changed(world.config, {f"species.{n}.policy.learn": order.learning for n in can}),
                learners=can,
            )

    def state(self) -> dict[str, np.ndarray]:
        """Return the state that is stored nowhere else: species that do not reproduce, requests, and
        ground created for fences."""
        tables = self.world.tables.values()
        # requests made within a tick wait for the next one
        text = json.dumps([x.once(self.world.tick) for x in self.requests]).encode()
        out = {
            "barren": np.array([t.species.barren for t in tables], np.uint8),
            "asked": np.frombuffer(text, np.uint8),
        }
        ground = self.world.terrain.fenced() if self.made_ground else {}
        none = {
            "ground": np.zeros((0, 0), np.uint8),
            "corners": np.zeros((0, 2)),
            "lengths": np.zeros(0, np.int64),
        }
        return out | {f"ground.{key}": array for key, array in (none | ground).items()}

    def load(self, state: dict[str, np.ndarray]) -> None:
        """Load a `state()`."""
        world = self.world
        for table, barren in zip(world.tables.values(), state["barren"], strict=True):
            table.species.barren = bool(barren)
        self.requests = []
        for order in json.loads(state["asked"].tobytes()):
            self.ask(order)
        ground = {k.removeprefix("ground."): v for k, v in state.items() if k.startswith("ground.")}
        there = ground["ground"].size > 0
        if self.made_ground or there:
            world.terrain, self.made_ground = flat_ground(world.space) if there else None, there
        if there:
            world.terrain.load(ground)


def flat_ground(space: Space) -> Terrain:
    """Return flat, open ground on which fences can be put up."""
    cell = max(min(CELL, min(space.size[:2]) / 100), math.sqrt(space.size[0] * space.size[1] / 4e6))
    ground = Terrain(space, cell)
    ground.declared = False
    return ground


def checked(
    world: SpatialWorld, order: dict[str, Any] | Intervention, requests: Sequence[dict[str, Any]]
) -> Any:
    """Validate an intervention for the next tick, given as a dict or a model, that will follow earlier
    `requests`."""
    fields = (
        order if isinstance(order, dict) else {k: v for k, v in order.model_dump().items() if v is not None}
    )
    data = {"at": world.tick} | fields
    if data["at"] != world.tick or "every" in data or "until" in data:
        raise ValueError(
            f"intervene: it is tick {world.tick} now; omit `at`, `every` and `until`, or put the "
            "intervention into the world file"
        )
    if world.config is not None:
        fences = [done for _, done in world.intervened if done["kind"] in ("fence", "road")]
        # the check depends on these; values set so far are in the config
        waiting = [done for done in requests if done["kind"] in ("fence", "road", "set")]
        return intervention(world.config, data, [*fences, *waiting])
    try:
        model = TypeAdapter(AnyIntervention).validate_python(data)
    except ValidationError as error:
        raise ValueError(f"intervene: {error}") from None
    if model.kind == "set" or getattr(model, "learning", None) is not None:
        raise ValueError(
            "intervene: this world was built by hand and has no configuration with values to set"
        )
    if (name := getattr(model, "species", None)) is not None and name not in world.tables:
        raise ValueError(unknown_name("intervene", "table", name, world.tables))
    if model.kind == "dose" and model.field is not None and model.field not in world.fields:
        raise ValueError(unknown_name("intervene", "field", model.field, world.fields))
    if model.kind == "add" and model.at_place is not None:
        at = zip("xyz", model.at_place, strict=False)
        places: dict[tuple[type, str], Any] = {(Position, axis): np.array([v], np.float32) for axis, v in at}
        newborn(world, world.tables[model.species], places, "intervene: add")
    return model


def _rank(table: Table, rows: np.ndarray, which: str, key: np.uint64) -> np.ndarray:
    """Return a number for each row; rows with the lowest numbers are culled first."""
    if which == "random":
        return random.draw_many(key, table.uid[rows], random.CULL)
    if which in ("richest", "poorest"):
        value = table[Metabolism].energy[rows]
    elif which in ("largest", "smallest"):
        value = table[Body].mass[rows]
    else:
        value = table[Biology].age[rows] if Biology in table else -table.born[rows]
    return -value if which in ("richest", "largest", "oldest") else value
