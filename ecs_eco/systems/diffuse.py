"""Smells leave bodies, spread and decay."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.config.features.chemistry import Emission
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_value
from ecs_eco.life.matter import Bodies, bodies, held, hold, part_lost
from ecs_eco.space.index import Index
from ecs_eco.space.world import SpatialWorld

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table


class Diffuse(System):
    """Bodies emit smells and substances into the fields, either at a given rate or in proportion to their
    content. The fields diffuse, decay and are renewed."""

    phase = "environment"
    divisible = True
    submodel = Submodel(
        "Fields",
        where=("emits", "fields.substance"),
        reads=("emits", "fields"),
        rules={
            "": "`∂c/∂t = diffusion ∇²c − decay c + emission` in every cell of a field; diffusion is "
            "solved in explicit steps, decay and emission exactly. Emission is the sum over the bodies whose "
            "centers are in the cell; for a substance, it is divided by the volume of the cell. Walls "
            "stop diffusion. The value at a position is interpolated linearly between cell centers.",
            "fields.renewal": "A renewed field also gains `renewal (initial − c)`.",
            "emits.consume": "A body loses the emitted amount if `consume` is true. Such emissions of one "
            "substance share `1 − exp(−Σ rate dt)` of it in proportion to their rates.",
        },
    )
    world: SpatialWorld

    def process(self, *_: object) -> None:
        """Advance all fields by one tick."""
        world = self.world
        emitters: list[tuple[Table, Index]] = []
        for table in world.tables.values():
            ways, of_its_own = list[tuple[str, Emission]](), False
            for name, way in table.species.emits.items():
                if isinstance(way, Emission):
                    ways.append((name, way))
                else:
                    of_its_own = True
            if ways:
                self.emanate(table, sorted(ways))
            if of_its_own:
                emitters.append((table, world.index(table)))
        mine = list(world.fields) if world.bands.size == 1 else self.mine()
        world.together(*[partial(self.spread, name, emitters) for name in mine])
        if world.bands.size > 1:
            self.share(mine)

    def mine(self) -> list[str]:
        """Return the fields that this process advances: some of the smells, and all substance fields."""
        fields = self.world.fields
        mine = self.world.bands.mine([name for name, field in fields.items() if field.substance is None])
        return [name for name, field in fields.items() if field.substance is not None or name in mine]

    def share(self, mine: list[str]) -> None:
        """Exchange the smells that each process has advanced."""
        smells = {name: field for name, field in self.world.fields.items() if field.substance is None}
        for name in smells.keys() - mine:
            smells[name].source[...] = 0  # another process has added it to the field
        self.world.bands.share({name: field.value for name, field in smells.items()})

    def emanate(self, table: Table, ways: list[tuple[str, Emission]]) -> None:
        """Emit substances from one kind of body. The emissions that consume a substance remove 1 − exp(−Σ rate
        dt) of it together, in proportion to their rates; emissions that consume nothing come first."""
        world, index = self.world, self.world.index(table)
        rates = [own_value(table, f"emits.{name}.rate", way.rate) * world.dt for name, way in ways]
        total, gone = dict[str, Any](), dict[str, Any]()
        for (_, way), rate in zip(ways, rates, strict=True):
            total[way.substance] = total.get(way.substance, 0.0) + rate * way.consume
        for (name, way), share in sorted(zip(ways, rates, strict=True), key=lambda one: one[0][1].consume):
            field, s, amount = world.fields[name], world.substances.index(way.substance), np.empty(index.n)
            if way.consume:
                all_of_it, lost = total[way.substance], gone.get(way.substance, 0.0)
                mine = part_lost(all_of_it) * (share / np.maximum(all_of_it, 1e-30))
                gone[way.substance], share = lost + mine, np.minimum(mine / np.maximum(1 - lost, 1e-30), 1.0)
            evaporate(index.rows, bodies(table), s, share, way.consume, amount)
            if way.consume and world.matter is not None:
                world.matter.book(("table", table.name), "emitted", -amount.sum(), s)
                if field.substance is not None:
                    world.matter.book(("field", name), "emitted", amount.sum(), s)
            if field.substance is not None:
                amount /= field.litres
            field.emit(index.x, index.y, index.z, amount.astype(field.source.dtype))

    def spread(self, name: str, emitters: list[tuple[Table, Index]]) -> None:
        """Add the emissions to one field, then let it diffuse and decay."""
        world, field = self.world, self.world.fields[name]
        emitted: tuple[Any, ...] = ()
        for table, index in emitters:
            each: Any = table.species.emits.get(name)
            if each is not None and not isinstance(each, Emission):
                if emitted:
                    field.emit(*emitted)
                if table.species.traits:
                    each = own_value(table, f"emits.{name}", each)
                amount: Any
                if isinstance(each, np.ndarray):
                    amount = (each[index.rows] * world.dt).astype(np.float32)
                else:
                    amount = np.float32(each * world.dt)
                emitted = index.x, index.y, index.z, amount
        if field.substance is None:
            field.pass_time(world.dt, *emitted)
            return
        if emitted:
            field.emit(*emitted)
        before, losses = field.held(), field.decay + field.renewal
        field.pass_time(world.dt)
        if world.matter is not None and losses:
            s, came = world.substances.index(field.substance), 0.0
            if field.renewal and field.initial is not None:
                came = field.renewal * world.dt * float(field.initial.sum()) * field.litres
            went = came - (field.held() - before)
            world.matter.book(("field", name), "decayed", -went * field.decay / losses, s)
            world.matter.book(("field", name), "brought_in", came - went * field.renewal / losses, s)


@njit
def evaporate(
    rows: np.ndarray, bodies: Bodies, s: int, share: Number, consume: bool, amount: np.ndarray
) -> None:
    """Write the amount of a substance that each body emits, a share of its content, to `amount` f64[n] [mol];
    remove it from the bodies if `consume` is true."""
    for i in range(rows.size):
        row = rows[i]
        c = held(bodies, row, s)
        rest = c * (1 - of_row(share, row))
        left = hold(bodies, row, s, rest) if consume else rest
        amount[i] = (c - left) * bodies.volume[row]
