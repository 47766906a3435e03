"""What lambs do that other animals of this package do not: breathe, suckle, and burn glucose with oxygen.

Breathing and suckling come right after the decision, before anybody moves: they happen where the lamb felt
what it decided on. Amounts are concentrations in the body [mol/L]; every number is our choice (README.md).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Chemistry, Nervous, Velocity
from ecs_eco.engine.schema import component, i32
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.life.births import ticks
from ecs_eco.life.matter import booked
from ecs_eco.nervous.sensors.touch import touch
from ecs_eco.space.seekers import Seekers

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

# [rad] where it touches an udder; nostrils: where water gets in. Those of the sensors in lamb.toml
MOUTH = (-1.6, 1.6)
NOSTRILS = (-1.2, 1.2)


@component
class Sucking:
    """How long a lamb has sucked at an udder without a pause."""

    since: i32 = 0  # [ticks]


class Breathe(System):
    """Inhaling in air brings oxygen into the blood, up to saturation;
    inhaling in water brings water into the lungs."""

    needs = (Nervous, Chemistry)
    phase = "decide"
    acts = ("breathe",)
    submodel = Submodel(
        "Breathing",
        rules={
            "": "While inhaling in air, `oxygen ← max(oxygen, min(oxygen + breath dt, saturation))`; while "
            "inhaling with the nostrils in water, the concentration of water grows by `water dt`."
        },
        changes=("Chemistry",),
    )
    breath = 0.0007  # [mol/L/s] oxygen while inhaling
    saturation = 0.007  # [mol/L]
    water = 1.0  # [mol/L/s] water while inhaling it

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Let one species breathe."""
        nerves = table.species.nerves
        if "breathe" in nerves.groups:
            rows, wet = touching(table, world, "water", NOSTRILS)
            oxygen, water = world.substances.index("oxygen"), world.substances.index("water")
            with booked(world, table, "brought_in"):
                inhale(
                    rows,
                    wet,
                    nerves.doing(table, "inhale"),
                    np.float32(self.breath * world.dt),
                    np.float32(self.saturation),
                    np.float32(self.water * world.dt),
                    oxygen,
                    water,
                    table[Chemistry].molarity,
                )


class Suckle(System):
    """Sucking at a ewe gives milk, which becomes blood sugar;
    a ewe lets it down only to a lamb that keeps sucking.

    A pause, or losing touch with the udder, stops the flow. Ewes have enough milk for all.
    """

    needs = (Nervous, Chemistry)
    phase = "decide"
    acts = ("suck",)
    submodel = Submodel(
        "Suckling",
        rules={
            "": "After `let_down` seconds of sucking without a pause, `glucose ← max(glucose, min(glucose + "
            "milk dt, full))`."
        },
        changes=("Chemistry", "Sucking"),
    )
    let_down = 4.0  # [s] of sucking before milk flows
    milk = 0.00006  # [mol/L/s] glucose while it flows
    full = 0.005  # [mol/L] glucose of a lamb that has had enough

    def start(self, world: SpatialWorld) -> None:
        """Add the clock of sucking to species that can suck."""
        for table in world.tables.values():
            if table.species.nerves is not None and "suck" in table.species.nerves.groups:
                table.add_component(Sucking)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Let one species suckle."""
        if Sucking in table:
            rows, at_udder = touching(table, world, "ewe", MOUTH)
            with booked(world, table, "brought_in"):
                suck(
                    rows,
                    at_udder,
                    table.species.nerves.doing(table, "suck"),
                    ticks(self.let_down, world.dt),
                    np.float32(self.milk * world.dt),
                    np.float32(self.full),
                    world.substances.index("glucose"),
                    table[Sucking].since,
                    table[Chemistry].molarity,
                )


class Burn(System):
    """Living and walking burn glucose with oxygen: the glucose lasts for a quarter of an hour,
    the oxygen for half a minute."""

    needs = (Nervous, Chemistry, Velocity)
    phase = "metabolise"
    submodel = Submodel(
        "Burning of glucose",
        rules={
            "": "`c ← max(0, c − (rest + walk × speed) dt)` for glucose and oxygen, with a pair (rest, walk) "
            "each."
        },
        changes=("Chemistry",),
    )
    glucose = (0.0000035, 0.000006)  # [mol/L/s] at rest; more per m/s
    oxygen = (0.0002, 0.0001)  # [mol/L/s] at rest; more per m/s

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Burn glucose and oxygen of one species."""
        with booked(world, table, "reacted"):
            for substance, (rest, walk) in (("glucose", self.glucose), ("oxygen", self.oxygen)):
                burn(
                    table.alive[: table.high],
                    table[Velocity].speed,
                    np.float32(rest * world.dt),
                    np.float32(walk * world.dt),
                    world.substances.index(substance),
                    table[Chemistry].molarity,
                )


def touching(
    table: Table, world: SpatialWorld, kind: str, sector: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the living rows i64[n] and whether something of a kind touches a sector of their bodies:
    f32[n], 1 or 0."""
    seekers = Seekers(world, table)
    felt = np.zeros((seekers.n, 1), np.float32)
    touch([kind], False, list(sector))(world, table, seekers, felt, 0)
    return seekers.rows, felt[:, 0]


@njit
def inhale(rows, wet, inhales, breath, saturation, gulp, oxygen, water, molarity):
    """Add a breath of air, or a gulp of water where it is wet, to those that inhale."""
    for i in range(rows.size):
        row = rows[i]
        if inhales[row] and wet[i]:
            molarity[row, water] += gulp
        elif inhales[row]:
            molarity[row, oxygen] = max(
                molarity[row, oxygen], min(molarity[row, oxygen] + breath, saturation)
            )


@njit
def suck(rows, at_udder, sucks, let_down, milk, full, glucose, since, molarity):
    """Count the ticks of sucking at an udder, and let milk flow from `let_down` on."""
    for i in range(rows.size):
        row = rows[i]
        if not (at_udder[i] and sucks[row]):
            since[row] = 0
            continue
        if since[row] >= let_down:
            molarity[row, glucose] = max(molarity[row, glucose], min(molarity[row, glucose] + milk, full))
        since[row] += 1


@njit
def burn(alive, speed, rest, walk, substance, molarity):
    """Take rest + walk × speed of a substance from the living, as far as they have it."""
    for row in range(alive.size):
        if alive[row]:
            molarity[row, substance] = max(
                molarity[row, substance] - rest - walk * speed[row], np.float32(0.0)
            )
