"""Derived traits: formulas of genes, so that one gene has several effects."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.report import write_report
from ecs_eco.cli.summary import summary
from ecs_eco.components import Body, Genome, LifeHistory, SpeedScale, Traits
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.runs.run import run_to_folder

SIZE = {"name": "size", "trait": "body.radius", "letters": 1, "values": [0.5, 1.0, 1.5, 2.0]}
DERIVED = {
    "litter": {"from": "size", "formula": "8 * size ** 2"},
    "pace": {"from": "size", "formula": "1 / size"},
    "burn": {"from": "pace", "trait": "metabolism.basal", "formula": "0.001 * pace"},
}


def config(derived=DERIVED, gene=SIZE, **changes):
    deer = {
        "count": 40,
        "body": {"radius": 0.5},
        "metabolism": {"energy": 0.9},
        "locomotion": {"speed": {"go": 1.0}, "cost": {"go": 0.0}, "turn": 0.3},
        "reproduction": {
            "kind": "asexual",
            "rate": 0.05,
            "energy_min": 0.5,
            "energy_given": 0.01,
            "dispersal": 2.0,
        },
        "genome": {"genes": [gene], "derived": derived},
    }
    return {"format": 1, "name": "w", "space": {"size": [60.0, 60.0]}, "species": {"deer": deer | changes}}


def test_one_gene_has_several_effects_computed_by_hand():
    table = World.from_config(config()).run(30).table("deer")
    rows = table.rows()
    assert rows.size > 40  # newborn, too
    letter = table[Genome].loci[rows, 0]
    assert set(letter) == {0, 1, 2, 3}
    assert table[LifeHistory].litter[rows].tolist() == np.array([2, 8, 18, 32])[letter].tolist()
    np.testing.assert_array_equal(table[SpeedScale].pace[rows], (1 / np.float32([0.5, 1, 1.5, 2]))[letter])
    np.testing.assert_allclose(
        table[Traits].value[rows, table.species.traits["metabolism.basal"]],
        np.array([0.002, 0.001, 0.001 / 1.5, 0.0005])[letter],
        rtol=1e-6,
    )
    assert (table[Body].radius[rows] == np.float32([0.5, 1, 1.5, 2])[letter]).all()


def test_a_neutral_gene_may_be_read_and_whole_numbers_are_rounded():
    marker = {"name": "marker", "letters": 1, "values": [0.0, 0.3, 0.4, 0.9]}
    derived = {"litter": {"from": "marker", "formula": "1 + 2 * marker"}}
    table = World.from_config(config(derived, marker)).table("deer")
    letter = table[Genome].loci[table.rows(), 0]
    assert table[LifeHistory].litter[table.rows()].tolist() == np.array([1, 2, 2, 3])[letter].tolist()


def test_strings_of_variable_length_have_derived_traits():
    genome = {"genes": [SIZE | {"copies": 1}], "derived": DERIVED, "max_length": 60}
    table = World.from_config(config(genome=genome)).table("deer")
    rows = table.rows()
    radius = table[Body].radius[rows].astype(float)
    assert table[LifeHistory].litter[rows].tolist() == (8 * radius**2).tolist()
    assert "8 * size ** 2" in str(table.species.heredity.layout)


def test_drift_without_expression_has_no_derived_traits():
    table = World.from_config(config(), controls=["neutral-drift"]).table("deer")
    assert set(table[LifeHistory].litter[table.rows()].tolist()) == {1}


def test_the_summary_and_the_records_have_derived_traits(tmp_path):
    lines = summary(load(config())).splitlines()
    assert any(" ".join(line.split()) == "litter reproduction.litter 8 * size ** 2" for line in lines)
    run_to_folder(config(), ticks=20, out=tmp_path / "run")
    lineage = Lineage.read(tmp_path / "run")
    size = lineage.values("size")
    assert lineage.values("litter").tolist() == (8 * size**2).tolist()
    assert lineage.values("reproduction.litter").tolist() == (8 * size**2).tolist()
    np.testing.assert_allclose(lineage.values("burn"), 0.001 / size, rtol=1e-6)
    assert lineage.course("deer", "litter", 5).mean[0] == pytest.approx((8 * size[:40] ** 2).mean())
    assert "reproduction.litter" in write_report(tmp_path / "run", tmp_path).read_text()
    with pytest.raises(ValueError, match="is derived: no letters code for it"):
        lineage.frequencies("deer", "litter", 5)


@pytest.mark.parametrize(
    ("derived", "words"),
    [
        (
            {"a": {"from": "size", "trait": "locomotion.pace", "formula": "sise"}},
            ['unknown name "sise"', 'mean "size"?', "derived.a.formula"],
        ),
        (
            {"a": {"from": "size", "trait": "locomotion.pase", "formula": "size"}},
            ["no such trait", 'mean "locomotion.pace"?'],
        ),
        ({"a": {"from": "size", "trait": "body.radius", "formula": "size"}}, ["size also codes for it"]),
        ({"size": {"from": "size", "trait": "locomotion.pace", "formula": "size"}}, ["a gene has this name"]),
        ({"a": {"from": "size", "trait": "locomotion.pace", "formula": "2"}}, ["reads no gene"]),
        (
            {
                "a": {"from": "b", "trait": "locomotion.pace", "formula": "b"},
                "b": {"from": "a", "trait": "metabolism.basal", "formula": "a"},
            },
            ["circular: it reads itself, directly or through other formulas"],
        ),
        (
            {"a": {"from": "size", "trait": "reproduction.litter", "formula": "size"}},
            ["0 at size = 0.5, which is outside the range of reproduction.litter", "1 to 10000"],
        ),
        (
            {"a": {"from": "size", "trait": "locomotion.pace", "formula": "exp(300 * size)"}},
            ["inf at size = 0.5, which is outside the range of locomotion.pace"],
        ),
        (
            {"a": {"from": "size", "trait": "locomotion.pace", "formula": "sqrt(size - 1)"}},
            ["nan at size = 0.5, which is outside the range of locomotion.pace"],
        ),
        (
            {"a": {"from": "size", "trait": "locomotion.pace", "formula": "100 * size"}},
            ["more than half the world's width", "derived.a.formula"],
        ),
        ({"a": {"from": "size", "trait": "species", "formula": "size"}}, ["no such trait"]),
        ({"liter": {"from": "size", "formula": "size"}}, ["no such trait"]),
        ({"go": {"from": "size", "formula": "size"}}, ["no such trait", "locomotion.speed.go"]),
        (
            {"litter": {"from": "sise", "formula": "9"}},
            ["no gene or derived trait with this name", 'mean "size"?'],
        ),
        (
            {"litter": {"from": ["size", "pace"], "formula": "9 * size"}, "pace": DERIVED["pace"]},
            ["derived.litter.from", "the formula does not read pace"],
        ),
    ],
)
def test_what_is_wrong_is_refused_before_the_first_tick(derived, words):
    with pytest.raises(ConfigError) as error:
        load(config(derived))
    for word in words:
        assert word in str(error.value)


def test_a_formula_of_many_genes_is_checked_at_some_combinations():
    genes = [SIZE | {"name": f"g{i}", "trait": None} for i in range(40)]
    text = " + ".join(f"g{i}" for i in range(40))
    genome = {"genes": genes, "derived": {"litter": {"from": [f"g{i}" for i in range(40)], "formula": text}}}
    table = World.from_config(config(genome=genome)).table("deer")
    assert table[LifeHistory].litter[table.rows()] == pytest.approx(50, abs=15)  # the mean of a gene is 1.25


def test_derived_values_cannot_be_set_in_a_living_world():
    world = World.from_config(config())
    changed = config()
    changed["species"]["deer"]["reproduction"]["litter"] = 3
    with pytest.raises(ConfigError, match="the gene litter codes for it"):
        world.reconfigure(changed)
