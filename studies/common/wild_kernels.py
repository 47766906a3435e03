"""Calls to kernels that the small worlds never run in a tick (those of the viewer, fitted networks, operators
and water), with a world's numbers."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

KEYS = np.arange(4, dtype=np.uint64)


def call_others(world: Any, chance: random.Random, odd: Any) -> None:
    """Call these kernels with a world's current columns and with extreme numbers: `odd(dtype, shape)`."""
    for table in world.tables.values():
        if "Position" in [component.__name__ for component in table.columns]:
            show(world, table)
            carry(world, table, odd)
        if table.species.heredity is not None and table.species.heredity.layout is not None:
            breed(table, odd)
    think(chance, odd)


def show(world: Any, table: Any) -> None:
    """Pack living organisms into a viewer frame, colored by each of their numbers, and read the fields at
    their positions."""
    from ecs_eco.components import Position
    from ecs_eco.view.frames import Encoder, extent, grade

    p, high = table[Position], table.high
    alive, value, smell = table.alive[:high], np.zeros(high, np.uint8), np.zeros(high, np.float32)
    for columns in table.columns.values():
        for column in vars(columns).values():
            if column.dtype == np.float32 and len(column.shape) == 1:
                grade(alive, column[:high], *extent(alive, column[:high]), value)
    frame = Encoder(world.space.size, 1)
    frame.begin(1, world.tick)
    frame.add(p.x[:high], p.y[:high], p.z[:high], p.heading[:high], value, table.uid[:high], alive)
    frame.bytes()
    for field in world.fields.values():
        field.sample(p.x[:high], p.y[:high], p.z[:high], smell)


def carry(world: Any, table: Any, odd: Any) -> None:
    """Move copies of the positions with currents of extreme speed."""
    from ecs_eco.components import Position
    from ecs_eco.space import water
    from ecs_eco.space.geometry import Places

    p, high, space = table[Position], table.high, world.space.extent
    places = Places(*(column[:high].copy() for column in (p.x, p.y, p.z)))
    alive, still, dt = table.alive[:high], odd(np.float32, (3, 3)), np.float32(world.dt)
    water.carry(alive, *odd(np.float32, (3, high)), dt, space, places)
    water.drift(0, high, alive, still, odd(np.float32, ())[()], dt, space, places)


def breed(table: Any, odd: Any) -> None:
    """Create genomes from valid letters with every operator; genomes with invalid letters are refused by
    name."""
    from deap import tools
    from deap.base import Toolbox

    from ecs_eco.genomes.batch import Operators

    layout = table.species.heredity.layout
    size = len(layout.alphabet)
    first, second = (odd(np.uint8, (KEYS.size, layout.row)) for _ in range(2))
    try:
        layout.decode(first)
    except ValueError as error:
        if "is not the number of a letter; expected 0 to" not in str(error):
            raise
    first, second = first % size, second % size
    layout.encode(layout.decode(first), clip=True)
    changes = [(tools.mutUniformInt, {"low": 0, "up": size - 1}), (tools.mutShuffleIndexes, {})]
    for mate, more in ((tools.cxOnePoint, {}), (tools.cxTwoPoint, {}), (tools.cxUniform, {"indpb": 0.5})):
        for mutate, bounds in [*changes, (tools.mutFlipBit, {})] if size == 2 else changes:
            box = Toolbox()
            box.register("mate", mate, **more)
            box.register("mutate", mutate, indpb=0.5, **bounds)
            box.register("select_mate", lambda *_: 0)
            layout.check(Operators(box, layout).offspring(first, second, KEYS))


def think(chance: random.Random, odd: Any) -> None:
    """Run networks with extreme weights on extreme observations, draw choices from extreme logits, add noise
    and sum coefficients."""
    from ecs_eco.genomes.codes import cosines
    from ecs_eco.genomes.fit import Fitted
    from ecs_eco.genomes.heredity import blur, draws
    from ecs_eco.genomes.kernels import combine
    from ecs_eco.learning.choice import choose_best

    n = chance.choice((0, 1, 5))
    network = Fitted("reflex", (3, 4, 6), np.zeros(46, np.float32), 0.0)
    network.each(odd(np.float32, (n, 3)), odd(np.float32, (n, 46)))
    choose_best(odd(np.float32, (n, 5)), np.array([0, 2, 5]), np.zeros((n, 2), np.int64))
    basis = cosines((3, 4), 5)
    combine(odd(np.float64, (n, len(basis))), basis, np.zeros((n, basis.shape[1])))
    keys = odd(np.uint64, (n,))
    blur(keys, draws(keys, 7)[:1].sum(), odd(np.float32, (n, 4)))
