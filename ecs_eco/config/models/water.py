"""The sun, the year and the water: light by depth, temperature, currents."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from ecs_eco.engine.submodel import Submodel
from ecs_eco.inputs.section import (
    FREE,
    Name,
    NonNegative,
    Pair,
    Positive,
    Real,
    Section,
    Share,
    WithParameters,
    about,
    quantity,
    table,
)


class Sun(Section, change=FREE):
    """The sun rises and sets: light at the surface is ambient.light times the sine of the sun's elevation."""

    submodel = Submodel(
        "Light",
        reads=("sun", "ambient"),
        rules={
            "sun.kind=natural": "`light = ambient.light × max(0, sin(elevation))` at the surface, with "
            "`sin(elevation) = sin(latitude) sin(declination) + cos(latitude) cos(declination) cos(2π(t/day + "
            "start − 1/2))` (Iqbal 1983, eq. 1.5.1).",
            "sun.kind=inverted": "The sun rises half a day later: `light = ambient.light × max(0, sin(elevation))` "
            "(Iqbal 1983, eq. 1.5.1).",
            "sun.kind=constant": "Light at the surface is always the daily mean (Iqbal 1983, eq. 4.2.15).",
            "sun.moon": "The moon adds `ambient.light × moon × max(0, −sin(elevation))`.",
            "sun.declination & year": "The declination is sinusoidal over the year (Cooper 1969).",
        },
    )

    kind: Literal["natural", "inverted", "constant"] = about(
        "natural; inverted: shifted by half a day, so that the day is dark; constant: always the daily mean",
        "natural",
    )
    day: Positive = quantity("length of a day", "s", 86_400.0)
    start: Share = quantity(
        "time of day at the start, as a fraction of a day: 0 is midnight, 0.5 noon", "1", 0.0
    )
    latitude: Annotated[float, Field(ge=-90, le=90)] = quantity("latitude; north is positive", "deg", 0.0)
    declination: Annotated[float, Field(ge=-90, le=90)] = quantity(
        "declination: 23.4 at northern midsummer, 0 at the equinoxes; with a year, its maximum", "deg", 0.0
    )
    year: Positive | None = quantity(
        "length of a year that begins in spring; default: the length of `year`, or a constant season",
        "s",
        None,
    )
    moon: NonNegative = quantity(
        "light of a full moon at the zenith, relative to ambient.light; the moon is opposite to the sun",
        "1",
        0.0,
    )


class Year(Section, change=FREE):
    """The year and its temperature cycle; for the seasons of light, see `sun`."""

    submodel = Submodel(
        "Temperature",
        reads=("year",),
        rules={
            "year.temperature": "`T = ambient.temperature + temperature × cos(2π(t/length + start − warmest))`."
        },
    )

    length: Positive = quantity("length of a year", "s")
    start: Share = quantity(
        "time of the year at the start, as a fraction of a year: 0 is the spring equinox, 0.25 midsummer",
        "1",
        0.0,
    )
    temperature: Real = quantity(
        "amplitude of the sinusoidal temperature cycle around ambient.temperature", "K", 0.0
    )
    warmest: Share = quantity(
        "warmest time of the year (0 to 1); air temperature lags behind the sun", "1", 0.33
    )


class Current(Section):
    """The velocity of the water at one depth, interpolated linearly between depths."""

    depth: NonNegative = quantity("depth below the surface", "m")
    velocity: Pair = quantity("velocity along x and y", "m/s")


def _from_above(current: list[Current]) -> list[Current]:
    depths = [c.depth for c in current]
    if depths != sorted(set(depths)):
        raise ValueError(f"depths are {depths}; expected each depth once, in increasing order")
    return current


class Water(Section, change=FREE):
    """A volume of water; its surface is at the top of the space."""

    submodel = Submodel(
        "Water",
        reads=("water",),
        rules={
            "": "`light(depth) = light(0) exp(−τ(depth))` (Beer-Lambert); a layer adds `attenuation × thickness` "
            "to the optical depth τ.",
            "water.shading": "A body in a layer adds its shade, divided by the area of the water, to τ.",
            "water.deep_temperature": "`T(depth) = T(0) + (deep_temperature − T(0)) (1 + tanh((depth − "
            "thermocline)/thermocline_width))/2`.",
            "sensors.kind=pressure": "`pressure = ambient.pressure + density × 9.81 m/s² × depth`.",
            "body.compressible": "The pressure in a compressible body is the pressure at its depth.",
        },
    )

    attenuation: NonNegative = quantity("attenuation of light by the water itself (Beer-Lambert)", "1/m", 0.0)
    shading: dict[Name, NonNegative] = quantity("species = area of shade that one member casts", "m^2", {})
    layer: Positive = quantity(
        "thickness of the layers in which bodies that cast shade are counted", "m", 1.0
    )
    density: Positive = quantity(
        "density of the water; pressure increases by density × 9.81 m/s² × depth", "kg/m^3", 1025.0
    )
    deep_temperature: NonNegative | None = quantity(
        "temperature far below the thermocline; default: the ambient temperature everywhere", "K", None
    )
    thermocline: NonNegative = quantity(
        "depth where the temperature is halfway from ambient to deep", "m", 0.0
    )
    thermocline_width: Positive = quantity(
        "half the depth range over which most of the temperature change happens", "m", 1.0
    )
    current: Annotated[list[Current], AfterValidator(_from_above)] = table("velocities by depth", list)
    current_function: WithParameters | None = about(
        "module:name of a function(world, x, y, z) that returns velocities u, v, w [m/s], instead of a list "
        "by depth",
        None,
    )
