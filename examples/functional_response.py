"""Measure how many seeds a walking animal eats at each density, and fit Holling's equation.
`python examples/functional_response.py figure.svg` also draws the three types."""

import sys

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import curve_fit

from ecs_eco import World

SIDE, DT, SPEED, REACH = 50.0, 0.25, 1.0, 0.5  # [m], [s], [m/s], [m] between centers
DENSITIES = np.array([0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64])  # [1/m²]
CASES = {  # handling time [s]; whether an animal walks only where it smells seeds
    "type I: no handling time": (0.0, False),
    "type II: 5 s of handling": (5.0, False),
    "type III: walks where it smells seeds": (5.0, True),
}


def plain(n: int, handling: float, scent: bool) -> World:
    """Return a world with n seeds, each of which is replaced when eaten, and 20 animals that never die."""
    eater = {
        "count": 20,
        "body": {"radius": 0.25},
        "metabolism": {"energy": 0.0, "energy_max": 1e6, "handling_time": handling},
        "locomotion": {"speed": {"sit": 0.0, "walk": SPEED}},
        "wander": {"turn": 0.2},
        "diet": [{"eats": "seed", "reach": REACH - 0.3, "gain": 1.0}],
        "actions": {"speed": ["sit", "walk"], "eat": ["eat"]},
        "always_on": ["eat"],
        "default_action": {"speed": "sit" if scent else "walk"},
    }
    seed = {"count": n, "body": {"radius": 0.05, "opaque": False}, "renewal": 1000.0}
    content = {"format": 1, "name": "plain", "dt": DT, "space": {"size": [SIDE, SIDE]}}
    if scent:
        content["fields"] = {"scent": {"cell": 2.0, "diffusion": 0.5, "decay": 0.5}}
        seed["emits"] = {"scent": 1.0}
        eater["sensors"] = [{"kind": "smell", "field": "scent", "half_saturation": 0.1}]
        eater["reflex"] = {"formulas": {"walk": "scent - 0.5"}}
    return World.from_config(content | {"objects": {"seed": seed}, "species": {"eater": eater}}, seed=1)


def measured(handling: float, scent: bool, ticks: int) -> np.ndarray:
    """Return the seeds eaten per second by one animal, at each density."""
    rates = []
    for density in DENSITIES:
        world = plain(round(density * SIDE**2), handling, scent).run(ticks)
        eaten = sum(world.series()["eaten: seed"].to_pylist())
        rates.append(eaten / (world.table("eater").n * ticks * DT))
    return np.array(rates)


def holling(n: np.ndarray, a: float, h: float, power: float = 1.0) -> np.ndarray:
    """Return the seeds eaten per second at density n, with search rate a and handling time h [s]."""
    return a * n**power / (1 + a * h * n**power)


def draw(rates: dict[str, np.ndarray], fits: dict[str, np.ndarray], file: str) -> None:
    """Draw the measured rates as dots and the fits as lines."""
    figure = Figure(figsize=(9, 3), layout="constrained")
    for ax, (name, rate) in zip(figure.subplots(1, 3), rates.items(), strict=True):
        fine = np.linspace(0, DENSITIES.max(), 200)
        ax.plot(fine, holling(fine, *fits[name]), color="#0072b2")
        ax.plot(DENSITIES, rate, "o", color="#1f1f1f", ms=4)
        ax.set(title=name, xlabel="seeds per m²", ylim=(0, None))
        ax.title.set(fontsize=8.5)
        ax.spines[["top", "right"]].set_visible(False)
    figure.axes[0].set_ylabel("seeds eaten per second")
    figure.savefig(file, dpi=160, metadata={"Date": None} if file.endswith(".svg") else None)


if __name__ == "__main__":
    ticks = 600 if len(sys.argv) > 1 else 100
    rates, fits = {name: measured(*case, ticks) for name, case in CASES.items()}, {}
    for name, rate in rates.items():
        start = (1.0, 5.0, 2.0) if "III" in name else (1.0, 1.0)
        fits[name] = curve_fit(holling, DENSITIES, rate, start, bounds=(0, 100))[0]
        print(f"{name}: {rate.round(3)}; a, h[, power]: {fits[name].round(2)}")
    if len(sys.argv) > 1:
        draw(rates, fits, sys.argv[1])
