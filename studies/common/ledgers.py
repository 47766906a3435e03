"""Accuracy of the energy and matter ledgers, measured in small random worlds."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecs_eco.record import ledger, matter

INTERNAL = ("eaten", "taken_up", "released", "remains")
"""Flows between holders, which sum to zero over all holders."""
SUBSTANCES = ("sugar", "gas", "salt")


def furthest_off(world: Any) -> dict[str, float]:
    """Return a world's largest ledger errors, each as a share of the largest stock: of a species (energy), of
    a substance in a holder (matter), or of a substance in the whole world (flows between holders)."""
    series = {name: np.array(values) for name, values in world.series().to_pydict().items()}
    off = {"energy": _share(series, ledger.LEDGER, ledger.imbalance(series), (len(world.recorder.names),))}
    if world.matter is None:
        return off
    shape = (*world.matter.stock.shape,)
    pages = {name: np.array(values) for name, values in world.recorder.matter_series().to_pydict().items()}
    off["matter"] = _share(pages, matter.LEDGER, matter.imbalance(pages), shape)
    stock = np.reshape(pages["stock_before"], (-1, *shape)).sum(1).max(0)
    for flow in INTERNAL:
        between = np.abs(np.reshape(pages[flow], (-1, *shape)).sum(1)).max(0)
        off["between"] = max(off.get("between", 0.0), _relative(between, stock))
    return off


def _share(page: dict[str, Any], columns: Any, imbalance: Any, shape: tuple[int, ...]) -> float:
    sizes = [np.abs(page[column]) for column in columns]  # energy may enter and leave within one tick
    return _relative(
        np.abs(np.reshape(imbalance, (-1, *shape))).max(0),
        np.reshape(np.max(sizes, axis=0), (-1, *shape)).max(0),
    )


def _relative(off: np.ndarray, stock: np.ndarray) -> float:
    return float(np.divide(off, stock, out=np.where(off > 0, np.inf, 0.0), where=stock > 0).max(initial=0.0))


def drawn(seed: int) -> dict[str, Any]:
    """Return a small random world, in which matter moves by every mechanism that a world file supports."""
    rng = np.random.default_rng(seed)
    volume = bool(rng.random() < 0.3)
    size = [12.0, 10.0, 8.0] if volume else [12.0, 10.0]
    fields = {f"{name}_field": _field(rng, name, volume) for name in SUBSTANCES if rng.random() < 0.8}
    fields["scent"] = {"cell": 1.0, "diffusion": 0.3, "decay": 0.1}
    soil = {name: 0.2 for name in SUBSTANCES if f"{name}_field" in fields} or None
    world = {
        "format": 1,
        "name": "drawn",
        "dt": float(rng.choice([0.25, 1.0, 3.0])),
        "seed": seed,
        "ticks": 100,
        "space": {"size": size, "edges": str(rng.choice(["torus", "walls"]))},
        "substances": dict.fromkeys(SUBSTANCES, ""),
        "fields": fields,
        "terrain": None if rng.random() < 0.5 else {"lakes": [{"at": [4.0, 4.0], "radius": 2.0}]},
        "objects": {
            "stone": {"count": 8, "body": {"radius": 0.2, "opaque": False}, "substances": _held(rng)},
            "carcass": {
                "body": {"radius": 0.2, "opaque": False},
                "reactions": _reactions(rng, energy=False),
                **({"decomposition": {"rate": 0.1}} if rng.random() < 0.7 else {}),
            },
        },
        "species": {
            "moss": _moss(rng, soil),
            "slug": _slug(rng, fields, ["moss", "stone"]),
            "newt": _slug(rng, fields, ["slug", "carcass"]),
        },
        "interventions": [
            {"kind": "cull", "at": 5, "share": 0.3, "species": "slug"},
            {"kind": "add", "at": 9, "count": 3, "species": "newt"},
        ],
    }
    return {key: value for key, value in world.items() if value is not None}


def _held(rng: Any) -> dict[str, float]:
    return {name: float(rng.uniform(0.05, 2.0)) for name in SUBSTANCES if rng.random() < 0.8} or {"salt": 1.0}


def _field(rng: Any, substance: str, volume: bool) -> dict[str, Any]:
    field = {
        "cell": float(rng.choice([1.0, 2.5])),
        "substance": substance,
        "diffusion": float(rng.choice([0.0, 0.2])),
        "decay": float(rng.choice([0.0, 0.02])),
        "initial": float(rng.uniform(1e-4, 0.05)),
    }
    field |= {} if volume else {"depth": float(rng.uniform(0.05, 1.0))}
    return field | ({"renewal": 0.05} if rng.random() < 0.4 else {})


def _reactions(rng: Any, energy: bool = True) -> list[dict[str, Any]]:
    out = []
    for _ in range(int(rng.integers(0, 3))):
        used, made = rng.permutation(SUBSTANCES)[:2]
        out.append(
            {
                "from": {str(used): float(rng.uniform(0.5, 2))},
                "to": {str(made): float(rng.uniform(0.5, 2))},
                "rate": float(rng.uniform(1e-4, 0.1)),
                "light": bool(rng.random() < 0.3),
                "energy": float(rng.uniform(-0.05, 0.1)) if energy else 0.0,
                "half": {str(used): 0.1} if rng.random() < 0.5 else {},
            }
        )
    return out


def _exchange(rng: Any, fields: dict[str, Any]) -> list[dict[str, Any]]:
    out: list[dict[str, Any]] = []
    for name, field in fields.items():
        if "substance" not in field:
            continue
        ways: list[dict[str, Any]] = [
            {"kind": "uptake", "field": name, "rate": float(rng.uniform(1e-3, 0.5)), "at": [1.0, 0.5]},
            {"kind": "equilibrate", "field": name, "rate": float(rng.uniform(0.01, 2.0)), "partition": 1.5},
            {
                "kind": "release",
                "field": name,
                "substance": field["substance"],
                "rate": float(rng.uniform(0.01, 0.5)),
                "above": 0.02,
            },
        ]
        out += [way for way in ways if rng.random() < 0.5]
    return [*out, *([{"kind": "release", "substance": "salt", "rate": 0.05}] if rng.random() < 0.3 else [])]


def _moss(rng: Any, soil: dict[str, float] | None) -> dict[str, Any]:
    rooted = soil is not None and rng.random() < 0.7
    return {
        "count": 30,
        "body": {"radius": 0.15, "opaque": False},
        "substances": soil if rooted else _held(rng),
        "reactions": _reactions(rng),
        "born_with": "soil" if rooted else "declared",
        "metabolism": {"energy": 0.2, "energy_max": 0.5, "photosynthesis": 0.02},
        "lethal": [{"property": "age", "max": 25.0}],
        "remains": "carcass",
        "reproduction": {"kind": "spread", "rate": 0.1, "seed_rain": 0.01, "spacing": 1.0},
    }


def _slug(rng: Any, fields: dict[str, Any], food: list[str]) -> dict[str, Any]:
    held = _held(rng)
    smell = {"scent": {"substance": next(iter(held)), "rate": 0.02, "consume": bool(rng.random() < 0.5)}}
    gene = {
        "alphabet": "01",
        "genes": [{"name": "size", "trait": "body.radius", "letters": 4, "low": 0.1, "high": 0.4}],
    }
    out = {
        "count": 12,
        "max_count": 60,
        "body": {"radius": 0.25, "mass": 1.0, "opaque": False},
        "substances": held,
        "born_with": str(rng.choice(["declared", "mother"])),
        "metabolism": {"energy": 0.6, "energy_max": 1.0, "basal": 0.01},
        "locomotion": {"speed": {"crawl": 0.3}, "turn": 0.5},
        "reactions": _reactions(rng),
        "exchange": _exchange(rng, fields),
        "emits": smell if rng.random() < 0.5 else {},
        "diet": [
            {"eats": name, "reach": 0.3, "gain": 0.2, "assimilation": float(rng.uniform(0, 1))}
            for name in food
        ],
        "actions": {"speed": ["crawl"], "turn": ["left", "none", "right"]},
        "always_on": ["crawl"],
        "genome": gene if rng.random() < 0.5 else None,
        "reproduction": {
            "kind": "asexual",
            "rate": 0.05,
            "energy_min": 0.5,
            "energy_given": 0.2,
            "dispersal": 3.0,
        },
        "lethal": [
            {"property": "energy", "min": 0.0},
            {"property": "age", "max": 60.0},
            {"property": next(iter(held)), "max": 20.0},
        ],
        "remains": "carcass" if rng.random() < 0.7 else None,
    }
    return {key: value for key, value in out.items() if value is not None}
