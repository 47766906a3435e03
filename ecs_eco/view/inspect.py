"""The current or last state of one organism for the panel, read from a live world without changing it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ecs_eco.components import Biology, Genome, Metabolism, Nervous, Position, Shape
from ecs_eco.ecosystem import World
from ecs_eco.engine.table import Table
from ecs_eco.genomes.codes import Code
from ecs_eco.genomes.promoters import copies_in
from ecs_eco.nervous.thoughts import minds, thinkers
from ecs_eco.space.bodies import extents
from ecs_eco.view.genealogy import Genealogy
from ecs_eco.view.scene import reach_of

SEXES = ("none", "female", "male")
WIDEST = 64  # maximum number of listed values of a gene
OF_NOW = ("born", "died", "parents", "children", "generation")  # fields that can change after death


def state_of(world: World, uid: int, lives: Genealogy | None = None) -> dict[str, Any]:
    """Return the state of one organism between ticks, as shown in the viewer.

    Parameters
    ----------
    world : World
    uid : int
    lives : Genealogy, optional
        Source of parents, children and facts about dead organisms.

    Returns
    -------
    dict
        Body, genome and nervous system, with the readings and the decision of the last tick.

    Raises
    ------
    KeyError
        If the organism is unknown.

    Notes
    -----
    This draws no random numbers and changes nothing.

    Examples
    --------
    >>> from ecs_eco import World
    >>> from ecs_eco.view.inspect import state_of
    >>> world = World.from_config("predator-prey", seed=1).run(1)
    >>> uid = int(world.table("wolf").uid[world.table("wolf").rows()[0]])
    >>> state_of(world, uid)["species"]
    'wolf'
    """
    out = {"kind": "organism", "uid": int(uid), "detail": "full", "note": ""}
    out |= dict.fromkeys(OF_NOW) | {"species": None, "parents": [], "children": []}
    out |= {} if lives is None else lives.facts(uid)
    try:
        table, row = world.locate(uid)
    except KeyError:
        if out["species"] is None:
            raise
        return nothing_of(out)
    out |= {"species": table.name, "alive": True, "born": int(table.born[row]), "died": None}
    layout: Any = getattr(table.species.heredity, "layout", None) if Genome in table else None
    genome = None if layout is None else marked(layout, table[Genome].loci[row])
    out |= body(world, table, row) | {"genome": genome, "nerves": nerves(table, row)}
    reach = reach_of(world, table, row)
    eyes = {"reach": reach, "channels": seen_by(world, table, reach)}
    return out | {key: value for key, value in eyes.items() if value}


def seen_by(world: World, table: Table, reach: Mapping[str, float | None]) -> dict[str, dict[str, Any]]:
    """Return, for each channel that reads 1 − distance/range, the target of its sensor, if it has one, and the
    range [m] if known and independent of light; `reach` contains individual ranges by number (None: unknown)."""
    out: dict[str, dict[str, Any]] = {}
    for number, sensor in enumerate(table.species.sensors):
        if sensor.kind not in ("nearest", "rays"):
            continue
        lit, far = getattr(sensor, "sight", None) is not None, reach.get(str(number), sensor.range)
        about = {} if lit or far is None else {"range": far}
        if sensor.kind == "nearest":
            targets = {} if sensor.kin else {f"{sensor.name or sensor.base()}_near": sensor.target}
        else:
            targets = {f"{sensor.name}_{target}_near": target for target in sensor.targets}
        for name in sensor.channels(3 if world.space.volume else 2):
            if name.endswith("_near"):
                out[name] = about | ({"target": targets[name]} if name in targets else {})
    return out


def nothing_of(out: dict[str, Any]) -> dict[str, Any]:
    """Return a message that contains only an organism's pedigree."""
    nothing = dict.fromkeys(("age", "sex", "energy", "energy_max", "place", "heading", "genome", "nerves"))
    return (
        nothing
        | {"trace": {"tick": [], "happiness": [], "energy": []}, "alive": False}
        | out
        | {"detail": "record"}
    )


def body(world: World, table: Table, row: int) -> dict[str, Any]:
    """Return the body of a living organism (None for values that it lacks), and a trace of the current tick."""
    out: dict[str, Any] = dict.fromkeys(("place", "heading", "age", "sex", "energy", "energy_max"))
    if Position in table:
        p = table[Position]
        out |= {
            "place": [number(p.x[row]), number(p.y[row]), number(p.z[row])],
            "heading": number(p.heading[row]),
        }
    if Shape in table:
        *sides, rounding = extents(table)
        out["size"] = [number(side[row] + 2 * rounding[row]) for side in sides]
    if Biology in table:
        out |= {"age": number(table[Biology].age[row]), "sex": SEXES[table[Biology].sex[row]]}
    if Metabolism in table:
        budget = getattr(table.species.section, "metabolism", None)
        out |= {
            "energy": number(table[Metabolism].energy[row]),
            "energy_max": None if budget is None else budget.energy_max,
        }
    happiness = number(table[Nervous].happiness[row]) if Nervous in table else None
    return out | {"trace": {"tick": [world.tick], "happiness": [happiness], "energy": [out["energy"]]}}


def marked(layout: Any, loci: np.ndarray) -> dict[str, Any]:
    """Return a genome u8[loci] as text, with the position and value of each gene. Network weights are
    counted, not listed.

    In a genome of variable length, each copy of a gene has a string, position and value; genes without copies
    have no letters.
    """
    decoded, length = layout.decode(loci[None]), layout.length
    letters, text = {"alphabet": layout.alphabet.letters}, layout.text(loci)
    if layout.longest is None:
        genes = [_gene(code, code.first, code.stop, decoded[code.name][0]) for code in layout.genes]
        for gene in genes if layout.ploidy == 2 else ():
            gene["alleles"] = [_listed(v) for v in layout.alleles(loci[None], gene["name"])[0]]
        strings = [text[s * length : (s + 1) * length] for s in range(layout.ploidy)]
        return letters | {"strings": strings, "genes": genes}
    genes, seen = [], dict.fromkeys(layout.promoters, 0)
    for piece in layout.mark(loci):
        if piece.gene:
            value = layout.values_of(loci[None], piece.gene)[1][seen[piece.gene]]
            seen[piece.gene] += 1
            end = piece.first + len(piece.letters)
            genes.append(_gene(layout[piece.gene], piece.first, end, value) | {"string": piece.string})
    absent = [
        _gene(layout[name], 0, 0, decoded[name][0]) | {"text": "absent"} for name, n in seen.items() if not n
    ]
    return letters | {"strings": text.split(layout.separator), "genes": genes + absent}


def _gene(code: Code, first: int, end: int, value: np.ndarray | float) -> dict[str, Any]:
    return {
        "name": code.name,
        "trait": code.gene.trait,
        "from": int(first),
        "to": int(end),
        "value": _listed(value),
        "text": f"{np.size(value):,} weights" if np.ndim(value) else code.text,
    }


def recorded_genome(known: dict[str, Any], text: str) -> dict[str, Any]:
    """Return a genome as recorded: the positions of genes, without values."""
    genes = known["genes"]
    if known.get("longest"):
        promoters = {g["name"]: g["promoter"] for g in genes}
        spans = {g["name"]: len(g["promoter"]) + g["letters"] for g in genes}
        strings = text.split(known["separator"])
        places = [
            {"name": name, "string": s, "from": at, "to": at + spans[name]}
            for s, string in enumerate(strings)
            for name, at in copies_in(string, promoters, spans)
        ]
    else:
        length = len(text) // known["ploidy"]
        strings = [text[s * length : (s + 1) * length] for s in range(known["ploidy"])]
        places = [{"name": g["name"], "from": g["at"], "to": g["at"] + g["letters"]} for g in genes]
    traits = {g["name"]: g["trait"] for g in genes}
    found = [place | {"trait": traits[place["name"]], "value": None} for place in places]
    return {"alphabet": known["alphabet"], "strings": strings, "genes": found}


def _listed(value: np.ndarray | float) -> float | list[float | None] | None:
    """Return a gene's value for JSON: a number, a short list, or None for network weights."""
    values = np.asarray(value)
    if values.ndim == 0:
        return number(values.item())
    return [number(v) for v in values] if len(values) <= WIDEST else None


def nerves(table: Table, row: int) -> dict[str, Any] | None:
    """Return the nervous system of a living organism in the last tick, or None if it has not decided yet."""
    rows, at = thinkers(table, table.uid[row : row + 1])
    if not rows.size:
        return None
    own = table.species.nerves
    happiness, reward = (
        (table[Nervous].happiness[row], table[Nervous].reward[row])
        if own.happiness is not None
        else (None, None)
    )
    mind, continuous = minds(table, rows, at), own.ranges.groups
    actions = (
        (group, name, *values, group in continuous)
        for (group, name), *values in zip(
            own.actions, mind.y[0], mind.p[0], mind.z[0], mind.decision[0], strict=True
        )
    )
    return described(zip(own.channels, mind.x[0], strict=True), actions, happiness, reward)


def described(
    sensors: Iterable[tuple[str, Any]], actions: Iterable[tuple[Any, ...]], happiness: Any, reward: Any
) -> dict[str, Any]:
    """Return a nervous system for the viewer, given sensors with readings and the arguments of `action`."""
    return {
        "sensors": [{"name": name, "value": number(value)} for name, value in sensors],
        "actions": [action(*values) for values in actions],
        "happiness": number(happiness),
        "reward": number(reward),
    }


def action(
    group: str, name: str, reflex: Any, probability: Any, chosen: Any, decision: Any, continuous: bool
) -> dict[str, Any]:
    """Return an action for the viewer: reflex (−1, 0 or 1), probability, and whether it was carried out. A
    continuous action has the value added by the reflex, the value chosen and the value carried out."""
    form: Callable[[Any], Any] = number if continuous else int
    values = {"reflex": reflex, "chosen": chosen, "decision": decision}
    out = {"group": group, "name": name, "probability": None if continuous else number(probability)}
    out |= {key: form(value) for key, value in values.items()}
    return out | ({"continuous": True} if continuous else {})


def drawable(nerves: dict[str, Any] | None) -> dict[str, Any]:
    """Return the nervous system of a state as arguments for `draw_nervous_system`.

    Parameters
    ----------
    nerves : dict or None
        `state_of(world, uid)["nerves"]`

    Returns
    -------
    dict
        Empty for an organism without a nervous system.

    Examples
    --------
    >>> from ecs_eco.view.inspect import drawable
    >>> drawable(None)
    {}
    """
    if nerves is None:
        return {}
    column = {"y": "reflex", "probabilities": "probability", "decision": "decision"}
    values: dict[str, Any] = {
        "readings": [math.nan if s["value"] is None else s["value"] for s in nerves["sensors"]]
    }
    for name, key in column.items():
        values[name] = [math.nan if a[key] is None else a[key] for a in nerves["actions"]]
    return values | {"happiness": nerves["happiness"]}


def number(value: float | None) -> float | None:
    """Return a number for JSON in the shortest form that preserves single precision, or None for NaN."""
    if value is None or not math.isfinite(value):
        return None
    return (
        float(np.format_float_positional(np.float32(value), unique=True))
        if abs(value) < 1e15
        else float(value)
    )
