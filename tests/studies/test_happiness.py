"""What the study of happiness concludes from made-up cases, and how it counts generations."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.config import load
from studies import happiness as study

SMALL = {
    "space.size": [60.0, 60.0],
    "species.vole.count": 150,
    "species.berry.count": 320,
    "species.nightshade.count": 30,
}


def _case(arm, seed, end, risk=1.0):
    genes = {f"{s}.{g}": f"0.0 0.0 0.0 {end} {end}" for s, names in study.GENES.items() for g in names}
    genes["vole.nightshade"] = f"0.0 0.0 0.0 0.0 {-end}"
    return {
        "case": {"arm": arm, "seed": seed},
        "result": {"genes": genes, "generations": 31.0, "numbers": {"vole": 310.0}, "risk": risk},
    }


def test_the_study_compares_arms_in_pairs_of_one_seed():
    cases = [_case("evolving", s, e, 0.5) for s, e in ((1, 0.8), (2, 0.6), (3, 0.7))]
    cases += [_case("no learning", s, e, 1.0) for s, e in ((1, 0.1), (2, -0.1), (3, 0.0))]
    assert study.changed(cases, "evolving", "vole.energy") == pytest.approx({1: 0.8, 2: 0.6, 3: 0.7})
    verdicts = {v["statement"]: v for v in study.summarise(cases)["verdicts"]}
    energy = verdicts["change of the weight of energy in happiness, evolving minus no learning"]
    assert energy["value"] == pytest.approx([0.7, 0.7, 0.7])
    assert energy["met"]
    assert verdicts["change of the weight of nightshade in happiness, evolving minus no learning"][
        "value"
    ] == pytest.approx([-0.7] * 3)
    assert verdicts["a vole's risk of death from nightshade, evolving relative to no learning"][
        "value"
    ] == pytest.approx([0.5] * 3)
    assert verdicts["no learning: vole genes that changed, of 5 (95% interval without 0)"]["value"] == 0


def test_the_study_says_so_where_nothing_evolved():
    cases = [
        _case(arm, s, e) for arm in ("evolving", "neutral drift") for s, e in ((1, 0.2), (2, -0.2), (3, 0.1))
    ]
    verdicts = {v["statement"]: v["met"] for v in study.summarise(cases)["verdicts"]}
    assert not verdicts["change of the weight of energy in happiness, evolving minus neutral drift"]
    assert verdicts["fewest generations of voles in an evolving run"]


def test_generations_are_counted_from_both_parents():
    world = World.from_config(load("happiness", SMALL), seed=1)
    vole = world.tables["vole"]
    depth = study.Generations(world, "vole")
    rows, (a, b) = vole.rows()[:1], vole.uid[vole.rows()[1:3]]
    assert depth.mean() == 0
    depth.born(vole, rows, np.array([a]), np.array([b]))
    assert depth.of[int(vole.uid[rows[0]])] == 1
    depth.born(vole, rows, vole.uid[rows], np.array([b]))
    assert depth.of[int(vole.uid[rows[0]])] == 1.5
