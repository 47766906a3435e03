"""Bodies exchange heat with their surroundings."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.compiled.per_row import Number, of_row
from ecs_eco.components import Body, Coat, HeatExchange, Metabolism, Physical, Position, Shape
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.genomes.own_values import own_values
from ecs_eco.space.bodies import extents
from ecs_eco.space.shapes import surface

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

NOTHING = np.zeros(0, np.float32)
KEYS = (  # in the field order of `Heat`
    "heat.specific_heat",
    "heat.conductance",
    "heat.insulation",
    "heat.metabolic_heat",
    "heat.regulate.set_point",
    "heat.regulate.warming",
    "heat.regulate.cooling",
    "heat.regulate.cost",
)
LEAST_CAPACITY = 1e-60  # [J/K] heat capacity of a massless body, which adopts the ambient temperature at once


class Heat(NamedTuple):
    """Heat exchange and production, for kernels: numbers, or arrays [rows] with one value per body."""

    specific_heat: Number  # [J/(kg K)]
    conductance: Number  # [W/(m^2 K)]
    insulation: Number  # [m^2 K/W]
    metabolic_heat: Number  # [J] heat per unit of energy burned
    set_point: Number  # [K]
    warming: Number  # maximum production [W]
    cooling: Number  # maximum loss [W]
    cost: Number  # energy per joule of warming or cooling


class ExchangeHeat(System):
    """A body cools or warms toward the temperature of its surroundings, and its metabolism warms it; an
    animal that regulates its temperature pays to stay at its set point.

    Newton's law of cooling, C dT/dt = k (T_surroundings − T) + P, is solved exactly, so the temperature curve
    does not depend on the length of a tick. C is mass × specific heat, k is surface / (1/conductance +
    insulation), and P is the heat from metabolism and regulation. An animal without energy does not regulate
    its temperature.
    """

    needs = (Position, Body, Physical, HeatExchange)
    phase = "metabolise"
    submodel = Submodel(
        "Body temperature",
        reads=("heat",),
        rules={
            "": "`C dT/dt = k (T_surroundings − T) + P`, with `C = mass × specific_heat`, `k = surface/"
            "(1/conductance + insulation)`, `surface = 4π radius²` for a sphere, and P the heat from "
            "metabolism and regulation, solved exactly (Newton's law of cooling)."
        },
        changes=("Physical.temperature", "HeatExchange", "Metabolism.energy", "Metabolism.burnt"),
    )
    asked_for = staticmethod(lambda table: HeatExchange in table)

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Update the temperatures of one kind of body."""
        heat = table.species.heat
        if heat is None:
            return
        p, b, high = table[Position], table[Body], table.high
        around = world.surroundings("temperature", p.x[:high], p.y[:high], p.z[:high])
        around = around.astype(np.float32, copy=False)
        coat = table[Coat].insulation if Coat in table else NOTHING
        energy, burnt = (
            (table[Metabolism].energy, table[Metabolism].burnt) if Metabolism in table else (NOTHING, NOTHING)
        )
        way = getattr(heat, "regulate", None)
        regulation = (
            (0.0, 0.0, 0.0, 0.0)
            if way is None or not energy.size
            else (float(np.float32(way.set_point)), way.warming, way.cooling, way.cost)
        )
        values = own_values(
            table,
            dict(
                zip(
                    KEYS,
                    (
                        heat.specific_heat,
                        heat.conductance,
                        heat.insulation,
                        getattr(heat, "metabolic_heat", 0.0),
                        *regulation,
                    ),
                    strict=True,
                )
            ),
        )
        world.split(
            exchange,
            high,
            table.alive,
            b.mass,
            round_as(table),
            around,
            coat,
            Heat(*values),
            world.dt,
            table[Physical].temperature,
            table[HeatExchange].residue,
            energy,
            burnt,
        )


def round_as(table: Table) -> np.ndarray:
    """Return, for each body, the radius of the sphere with the same surface area: f32[capacity] [m]."""
    if Shape not in table:
        return table[Body].radius
    return np.sqrt(surface(*extents(table)) / (4 * math.pi)).astype(np.float32)


@njit
def exchange(
    first: int,
    last: int,
    alive: np.ndarray,
    mass: np.ndarray,
    radius: np.ndarray,
    around: np.ndarray,
    coat: np.ndarray,
    heat: Heat,
    dt: float,
    temperature: np.ndarray,
    residue: np.ndarray,
    energy: np.ndarray,
    burnt: np.ndarray,
) -> None:
    """Advance the temperature [K] of living bodies to the end of a tick; record the energy cost."""
    specific_heat, conductance, insulation, metabolic_heat, set_point, warming, cooling, cost = heat
    for row in range(first, last):
        if not alive[row]:
            continue
        # float64(), because float() of a float32 remains a float32 in a kernel
        capacity = max(np.float64(mass[row]) * of_row(specific_heat, row), LEAST_CAPACITY)
        resistance = coat[row] if coat.size else of_row(insulation, row)
        leaks, costs, goal = of_row(conductance, row), of_row(cost, row), of_row(set_point, row)
        shivers, pants = of_row(warming, row), of_row(cooling, row)
        k = 4.0 * math.pi * np.float64(radius[row]) ** 2 * leaks / (1.0 + leaks * resistance)
        rate, place = k / capacity, np.float64(around[row])
        own = of_row(metabolic_heat, row) * burnt[row] / dt if burnt.size else 0.0
        now, left, spent = np.float64(temperature[row]) + residue[row], dt, 0.0
        if shivers > 0 or pants > 0:
            # [J] heat that the body can pay for
            most = max(np.float64(energy[row]), 0.0) / costs if costs > 0 else np.inf
            if now != goal:
                power = shivers if now < goal else -pants
                slope = (own + power) / capacity - rate * (now - place)
                arrives = when(goal - now, slope, rate)
                time = min(arrives, dt, lasts(most, power))
                now = goal if time == arrives else now + slope * span(rate, time)
                spent, left = abs(power) * time, dt - time
            if now == goal and left > 0:
                hold = k * (goal - place) - own
                power = min(max(hold, -pants), shivers)
                time = min(left, lasts(most - spent, power))
                if power != hold:
                    now += (own + power - k * (now - place)) / capacity * span(rate, time)
                spent, left = spent + abs(power) * time, left - time
        if left > 0:
            now += (own / capacity - rate * (now - place)) * span(rate, left)
        temperature[row] = now
        residue[row] = now - temperature[row]
        if spent > 0:
            before = energy[row]
            energy[row] = before - spent * costs
            burnt[row] += before - energy[row]


@njit
def span(rate, time):
    """Return the integral of exp(−rate t) from 0 to `time` [s]."""
    return -math.expm1(-rate * time) / rate if rate > 0 else time


@njit
def when(gap, slope, rate):
    """Return the time [s] until a temperature has changed by `gap` [K] if its rate of change begins at
    `slope` [K/s] and decays exponentially; infinite if it never does."""
    if gap * slope <= 0 or gap * rate / slope >= 1:
        return np.inf
    return -math.log1p(-gap * rate / slope) / rate if rate > 0 else gap / slope


@njit
def lasts(most, power):
    """Return how long [s] an amount of heat [J] lasts at a given power [W]."""
    return max(most, 0.0) / abs(power) if power != 0 else np.inf
