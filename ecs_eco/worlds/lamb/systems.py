"""What lambs do that other animals of this package do not: breathe, suckle, and burn glucose and oxygen.

Breathing and suckling come right after the decision, before anybody moves: they happen where the lamb felt what it
decided on. All amounts are concentrations in the blood [mol/L]; every number is our choice (README.md).
"""

from typing import Any

import numpy as np

from ecs_eco import System, component, f32, njit
from ecs_eco.components import Chemistry, Nervous, Velocity
from ecs_eco.nervous.senses import Seekers, touch

MUZZLE = (-1.6, 1.6)  # [rad] the sector of the body that touches water and udder; that of the touch sensors in lamb.toml


@component
class Sucking:
    """How long a lamb has sucked at an udder without a pause."""

    since: f32 = 0.0  # [s]


class Breathe(System):
    """Who inhales in air fills its blood with oxygen, up to the ceiling; who inhales in water gets it into the lungs.

    A breath is work, and costs a little glucose.
    """

    needs = (Nervous, Chemistry)
    phase = "decide"
    acts = ("breathe",)
    breath = 0.0006  # [mol/L] oxygen from one second of inhaling
    ceiling = 0.008  # [mol/L] oxygen of saturated blood
    effort = 0.000005  # [mol/L] glucose that a second of inhaling costs
    water = 1.0  # [mol/L] water in the lungs after a second of inhaling it

    def update(self, table: Any, world: Any) -> None:
        """Let one species breathe."""
        if "breathe" in table.traits["nerves"].groups:
            rows, wet = touching(table, world, "water")
            glucose, oxygen, lungs = (world.substances.index(s) for s in ("glucose", "oxygen", "water"))
            amounts = np.array([self.breath, self.ceiling, self.effort, self.water], np.float32)
            inhale(rows, wet, table.traits["nerves"].doing(table, "inhale"), glucose, oxygen, lungs, np.float32(world.dt), amounts,
                   table[Chemistry].molarity)


class Suckle(System):
    """Who sucks at a ewe gets milk, which becomes blood sugar; the ewe lets it down only to a lamb that keeps on sucking.

    A pause, or losing touch with the udder, stops the flow. Ewes have milk enough for all.
    """

    needs = (Nervous, Chemistry)
    phase = "decide"
    acts = ("suck",)
    let_down = 4.0  # [s] of sucking before milk flows
    milk = 0.0001  # [mol/L] glucose from one second of flow
    ceiling = 0.005  # [mol/L] glucose of a full lamb

    def start(self, world: Any) -> None:
        """Give those who suck the memory of the udder."""
        for table in world.tables.values():
            if "nerves" in table.traits and "suck" in table.traits["nerves"].groups:
                table.add_component(Sucking)

    def update(self, table: Any, world: Any) -> None:
        """Let one species suckle."""
        if Sucking in table:
            rows, at_udder = touching(table, world, "ewe")
            amounts = np.array([self.let_down, self.milk, self.ceiling], np.float32)
            suck(rows, at_udder, table.traits["nerves"].doing(table, "suck"), world.substances.index("glucose"), np.float32(world.dt),
                 amounts, table[Sucking].since, table[Chemistry].molarity)


class Burn(System):
    """Living and walking burn glucose in oxygen: the first lasts for minutes, the second for seconds."""

    needs = (Nervous, Chemistry, Velocity)
    phase = "metabolise"
    glucose = (0.0000015, 0.000003)  # [mol/L/s] at rest; more per m/s
    oxygen = (0.0002, 0.0001)  # [mol/L/s] at rest; more per m/s

    def update(self, table: Any, world: Any) -> None:
        """Burn what one species holds."""
        chemistry, speed, dt = table[Chemistry], table[Velocity].speed, np.float32(world.dt)
        for substance, (rest, way) in (("glucose", self.glucose), ("oxygen", self.oxygen)):
            burn(table.alive[: table.high], speed, world.substances.index(substance), np.float32(rest), np.float32(way), dt,
                 chemistry.molarity)


def touching(table: Any, world: Any, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the living rows i64[n] and whether a body of a kind touches the muzzle: f32[n], 1 or 0."""
    seekers = Seekers(world, table)
    felt = np.zeros((seekers.n, 1), np.float32)
    touch([kind], False, list(MUZZLE))(world, table, seekers, felt, 0)
    return seekers.rows, felt[:, 0]


@njit
def inhale(rows, wet, inhales, glucose, oxygen, lungs, dt, amounts, molarity):
    """Move oxygen, or water, into those who inhale; amounts f32[4] are breath, ceiling, effort and water."""
    for i in range(rows.size):
        row = rows[i]
        if not inhales[row]:
            continue
        molarity[row, glucose] = max(molarity[row, glucose] - amounts[2] * dt, np.float32(0.0))
        if wet[i]:
            molarity[row, lungs] += amounts[3] * dt
        else:
            molarity[row, oxygen] = min(molarity[row, oxygen] + amounts[0] * dt, amounts[1])


@njit
def suck(rows, at_udder, sucks, glucose, dt, amounts, since, molarity):
    """Count the seconds of sucking at an udder, and let milk flow; amounts f32[3] are let-down [s], milk and ceiling."""
    for i in range(rows.size):
        row = rows[i]
        if not (at_udder[i] and sucks[row]):
            since[row] = 0
            continue
        if since[row] >= amounts[0]:
            molarity[row, glucose] = max(molarity[row, glucose], min(molarity[row, glucose] + amounts[1] * dt, amounts[2]))
        since[row] += dt


@njit
def burn(alive, speed, substance, rest, way, dt, molarity):
    """Take (rest + way × speed) dt of a substance, as far as there is any, from the living."""
    for row in range(alive.size):
        if alive[row]:
            molarity[row, substance] = max(molarity[row, substance] - (rest + way * speed[row]) * dt, np.float32(0.0))
