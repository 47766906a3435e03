"""Small random food webs with arbitrary or misleading names, each with at most one deliberate fault.

A healthy web is drawn first: size, population sizes, costs, diets, births and lifespans are random, and
policies act at random. A disaster then changes one aspect of it by a random factor. The label names the
change, not what happens in the run.
"""

from __future__ import annotations

from typing import Any

import numpy as np

DISASTERS = ("overgrazing", "predators too good", "predators too few", "newborns starve", "poisoned")
CLASSES = (*DISASTERS, "healthy")
WEBS = (  # producer, grazer, predator, a second producer
    ("grass", "deer", "wolf", "fern"),
    ("algae", "snail", "fish", "moss"),
    ("phytoplankton", "copepod", "krill", "diatom"),
    ("lichen", "mite", "spider", "fungus"),
    ("clover", "hare", "lynx", "thistle"),
    ("kelp", "urchin", "otter", "dulse"),
    ("weed", "aphid", "ladybird", "nettle"),
    ("alpha", "beta", "gamma", "delta"),
    ("p1", "h1", "c1", "p2"),
    ("wolf", "grass", "deer", "otter"),  # misleading names
)
CAUSES = ("starved", "no energy left", "hunger", "energy too low")
OLD = ("too old", "old age", "age too high")


def web(seed: int, label: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a labeled world, as a dict for `ecs_eco.config.load`, and its random draws: the names, the web
    and the factors."""
    rng = np.random.default_rng([seed, CLASSES.index(label)])
    plant, grazer, predator, other = WEBS[int(rng.integers(1, len(WEBS))) if rng.random() < 0.7 else 0]
    levels = 3 if label in ("predators too good", "predators too few") or rng.random() < 0.6 else 2
    side = float(rng.uniform(70, 110))
    words = {"low": str(rng.choice(CAUSES)), "high": str(rng.choice(OLD))}
    species = {plant: _plant(rng, side), grazer: _grazer(rng, plant, side, words)}
    if levels == 3:
        species[predator] = _predator(rng, grazer, side, words)
    drawn: dict[str, Any] = {
        "who": grazer,
        "plant": plant,
        "grazer": grazer,
        "predator": predator if levels == 3 else None,
        "levels": levels,
    }
    if label != "healthy":
        CHANGES[label](rng, species, drawn, other)
    config = {"format": 1, "name": "web", "space": {"size": [side, side]}, "species": species}
    return config, drawn


def about(rng: np.random.Generator, value: float, spread: float = 0.15) -> float:
    """Return a random value within a given factor of another value."""
    return float(value * np.exp(rng.normal(0, spread)))


def _plant(rng: np.random.Generator, side: float) -> dict[str, Any]:
    spacing = about(rng, 2.5, 0.08)
    return {
        "count": round((side / spacing) ** 2 * rng.uniform(0.45, 0.7)),
        "body": {"radius": 0.3, "opaque": False},
        "metabolism": {"energy": 0.1, "energy_max": 0.1},
        "reproduction": {
            "kind": "spread",
            "rate": about(rng, 0.035),
            "seed_rain": about(rng, 0.0005, 0.3),
            "spacing": spacing,
        },
    }


def _walker(rng: np.random.Generator, basal: float, low: str, high: str, age: float) -> dict[str, Any]:
    gaits = {"still": 0.0, "walk": about(rng, 0.7)}
    return {
        "body": {"radius": 0.4},
        "metabolism": {"energy": 0.5, "energy_max": 1.0, "basal": basal},
        "locomotion": {"speed": gaits, "cost": {"still": 0.0, "walk": 0.004}, "turn": 0.6},
        "actions": {"speed": ["still", "walk"], "turn": ["left", "none", "right"]},
        "default_action": {"speed": "walk", "turn": "none"},
        "sensors": [{"kind": "own", "property": "energy"}],
        "policy": {"kind": "shared", "hidden": [2]},
        "happiness": {"weights": {"energy": 1.0}, "minimum": -1.0},
        "lethal": [
            {"property": "energy", "min": 0.0, "cause_below": low},
            {"property": "age", "max": age, "cause_above": high},
        ],
    }


def _grazer(rng: np.random.Generator, plant: str, side: float, words: dict[str, str]) -> dict[str, Any]:
    return _walker(rng, about(rng, 0.006), **words, age=about(rng, 900)) | {
        "count": round(side**2 * about(rng, 0.022)),
        "diet": [
            {
                "eats": plant,
                "reach": 0.4,
                "chance": about(rng, 0.4),
                "gain": about(rng, 0.19),
                "satiation": 0.9,
            }
        ],
        "reproduction": {
            "kind": "asexual",
            "place": "anywhere",
            "rate": about(rng, 0.012),
            "energy_min": 0.6,
            "energy_given": 0.3,
        },
    }


def _predator(rng: np.random.Generator, grazer: str, side: float, words: dict[str, str]) -> dict[str, Any]:
    out = _walker(rng, about(rng, 0.004), **words, age=about(rng, 1500))
    out["locomotion"]["speed"]["walk"] = about(rng, 1.0)
    return out | {
        "count": round(side**2 * about(rng, 0.0055)),
        "diet": [
            {
                "eats": grazer,
                "reach": 0.6,
                "chance": about(rng, 0.25),
                "gain": about(rng, 0.45),
                "satiation": 0.65,
            }
        ],
        "reproduction": {
            "kind": "asexual",
            "place": "anywhere",
            "rate": about(rng, 0.006),
            "energy_min": 0.5,
            "energy_given": 0.25,
            "spacing": about(rng, 6.0, 0.1),
        },
    }


def _overgrazing(
    rng: np.random.Generator, species: dict[str, Any], drawn: dict[str, Any], other: str
) -> None:
    """Make the grazer eat far faster than plants grow, and reproduce on that food."""
    plant, grazer = species[drawn["plant"]], species[drawn["grazer"]]
    drawn["grows"], drawn["eats"], drawn["births"] = (
        rng.uniform(0.1, 0.4),
        rng.uniform(2.5, 5),
        rng.uniform(2, 4),
    )
    plant["reproduction"]["rate"] *= drawn["grows"]
    plant["reproduction"]["seed_rain"] *= drawn["grows"] / 4
    grazer["diet"][0]["chance"] = min(1.0, grazer["diet"][0]["chance"] * drawn["eats"])
    grazer["diet"][0]["satiation"] = 1.0
    grazer["reproduction"]["rate"] *= drawn["births"]


def _too_good(rng: np.random.Generator, species: dict[str, Any], drawn: dict[str, Any], other: str) -> None:
    """Make the predator insatiable and less territorial, extend its reach, and make nearly every attack
    succeed."""
    hunter = species[drawn["predator"]]
    drawn["reach"], drawn["births"] = rng.uniform(1.5, 4), rng.uniform(1.5, 4)
    hunter["diet"][0] |= {"chance": float(rng.uniform(0.8, 1)), "reach": drawn["reach"], "satiation": 1.0}
    hunter["locomotion"]["speed"]["walk"] *= rng.uniform(1.2, 2)
    hunter["reproduction"]["rate"] *= drawn["births"]
    hunter["reproduction"]["spacing"] = float(rng.uniform(0, 2))


def _too_few(rng: np.random.Generator, species: dict[str, Any], drawn: dict[str, Any], other: str) -> None:
    """Make predators rare, poor hunters or infertile; in half of the webs, grazers multiply fast."""
    hunter, grazer = species[drawn["predator"]], species[drawn["grazer"]]
    drawn["who"], drawn["how"] = drawn["predator"], str(rng.choice(["catch", "births", "handful"]))
    if drawn["how"] == "catch":
        hunter["diet"][0]["chance"] *= rng.uniform(0.02, 0.15)
    elif drawn["how"] == "births":
        hunter["reproduction"]["rate"] *= rng.uniform(0.0, 0.1)
        hunter["lethal"][1]["max"] *= rng.uniform(0.2, 0.5)
    else:
        hunter["count"] = int(rng.integers(1, 4))
        hunter["diet"][0]["chance"] *= rng.uniform(0.1, 0.4)
    if rng.random() < 0.5:
        grazer["reproduction"]["rate"] *= rng.uniform(1.5, 3)


def _newborns(rng: np.random.Generator, species: dict[str, Any], drawn: dict[str, Any], other: str) -> None:
    """Make parents give newborns almost no energy."""
    drawn["who"] = drawn["predator"] if drawn["levels"] == 3 and rng.random() < 0.4 else drawn["grazer"]
    drawn["given"] = float(rng.uniform(0.001, 0.01))
    who = species[drawn["who"]]
    who["reproduction"]["energy_given"] = drawn["given"]
    who["lethal"][1]["max"] *= rng.uniform(0.2, 0.4)


def _poisoned(rng: np.random.Generator, species: dict[str, Any], drawn: dict[str, Any], other: str) -> None:
    """Poison the grazer's or predator's food: eating it costs energy or kills, or the diet includes a second,
    harmful food."""
    drawn["how"] = str(rng.choice(["poison", "deadly", "bad"]))
    plant, grazer = species[drawn["plant"]], species[drawn["grazer"]]
    if drawn["how"] == "poison":
        drawn["who"] = drawn["predator"] if drawn["levels"] == 3 and rng.random() < 0.4 else drawn["grazer"]
        eaten = grazer if drawn["who"] == drawn["predator"] else plant
        eaten["defence"] = {
            "poison": species[drawn["who"]]["diet"][0]["gain"] * float(rng.uniform(0.75, 1.1))
        }
        return
    drawn["who"] = drawn["grazer"]
    species[other] = {
        "count": round(plant["count"] * rng.uniform(0.3, 0.8)),
        "body": plant["body"],
        "metabolism": plant["metabolism"],
        "reproduction": plant["reproduction"] | {"seed_rain": 0.02},
    }
    if drawn["how"] == "deadly":
        bad = {"gain": 0.0, "deadly": True, "chance": float(rng.uniform(0.03, 0.3))}
    else:
        bad = {
            "gain": -grazer["diet"][0]["gain"] * float(rng.uniform(0.6, 1.5)),
            "chance": grazer["diet"][0]["chance"],
        }
    grazer["diet"].append({"eats": other, "reach": 0.1, "satiation": 0.9} | bad)


CHANGES = {
    "overgrazing": _overgrazing,
    "predators too good": _too_good,
    "predators too few": _too_few,
    "newborns starve": _newborns,
    "poisoned": _poisoned,
}
