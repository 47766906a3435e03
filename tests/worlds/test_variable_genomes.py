"""Worlds whose genomes have strings of variable length: promises, checkpoints, records, what is shown."""

import json

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.report.write import write_report
from ecs_eco.components import Body, Genome, Reflexes
from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.testing import check_world
from ecs_eco.view.inspect import recorded_genome, state_of
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from tests.worlds.herd import HERD, herd

RATES = {"insertion": 0.01, "base_deletion": 0.01, "duplication": 0.05, "gene_deletion": 0.05}


def goats_with(**genome):
    """A herd whose goats have genomes of variable length and no policy that learns."""
    genes = [
        {
            "name": "green",
            "trait": "reflex.green.weight",
            "letters": 1,
            "values": [0, 0, 0, -1],
            "promoter": "TAT",
            "copies": 2,
            "copy_rule": "sum",
        },
        {"name": "size", "trait": "body.radius", "letters": 3, "low": 0.2, "high": 0.6, "promoter": "CGC"},
        {
            "name": "legs",
            "trait": "locomotion.pace",
            "letters": 3,
            "low": 0.5,
            "high": 2.0,
            "copies": 0,
            "promoter": "GGA",
        },
    ]
    return herd(
        components=[],
        genome={"max_length": 40, "loci": 24, "genes": genes, **RATES, **genome},
        reproduction=HERD["species"]["goat"]["reproduction"] | {"gestation": 2.0},
    )


@pytest.fixture(scope="module")
def lived():
    return World.from_config(goats_with(ploidy=2)).run(80)


@pytest.mark.slow
@pytest.mark.definition("3 genome")
@pytest.mark.parametrize(
    "genome", [{}, {"ploidy": 2, "expression": "mean"}, {"mate": {"operator": "cxMessyOnePoint"}}]
)
def test_a_herd_with_strings_of_variable_length_keeps_its_promises(genome):
    check_world(lambda threads: World.from_config(goats_with(**genome), threads=threads), ticks=50)


def test_newborn_are_what_their_strings_say_and_strings_come_to_differ(lived):
    goat = lived.tables["goat"]
    rows = goat.rows()[goat.born[goat.rows()] > 0]
    layout, loci = goat.species.heredity.layout, goat[Genome].loci[rows]
    values, copies = layout.decode(loci), layout.copy_numbers(loci)
    assert rows.size > 20
    assert np.array_equal(goat[Body].radius[rows], values["size"])
    assert np.array_equal(goat[Reflexes].weight[rows, 0], values["green"])
    assert set(np.unique(copies["green"])) > {3, 4, 5}
    assert len(np.unique(layout.lengths(loci))) > 5
    absent = copies["legs"] == 0
    assert absent.any()
    assert (values["legs"][absent] == 1).all()


def test_a_world_goes_on_from_a_checkpoint_and_forks(tmp_path):
    world = World.from_config(goats_with(max_length=26)).run(40)
    world.save(tmp_path / "world.ckpt")
    other, fork = World.restore(tmp_path / "world.ckpt"), world.fork(seed=9)
    operators = [w.tables["goat"].species.heredity.operators for w in (world, other)]
    assert operators[0].at_limit.sum() > 0
    assert operators[0].at_limit.tolist() == operators[1].at_limit.tolist()
    assert world.run(20).digest() == other.run(20).digest()
    assert operators[0].at_limit.tolist() == operators[1].at_limit.tolist()
    assert fork.run(20).digest() != world.digest()


def test_rates_may_change_in_a_living_world_and_counts_go_on():
    world = World.from_config(goats_with(max_length=26)).run(40)
    heredity = world.tables["goat"].species.heredity
    before = heredity.operators.at_limit.copy()
    world.reconfigure(load(world.config, {"species.goat.genome.duplication": 0.0}))
    assert heredity.operators.duplication == 0
    assert heredity.operators.at_limit.tolist() == before.tolist()
    assert before.sum() > 0
    with pytest.raises(ValueError, match="max_length"):
        world.reconfigure(load(world.config, {"species.goat.genome.max_length": 60}))


def test_an_organism_is_shown_with_every_copy_of_its_genes(lived):
    goat = lived.tables["goat"]
    layout, live = goat.species.heredity.layout, Live(lived)
    for row in goat.rows()[:20]:
        shown = state_of(lived, int(goat.uid[row]))["genome"]
        json.dumps(shown, allow_nan=False)
        assert layout.separator.join(shown["strings"]) == layout.text(goat[Genome].loci[row])
        for gene in shown["genes"]:
            if gene["to"]:
                letters = shown["strings"][gene["string"]][gene["from"] : gene["to"]]
                assert letters.startswith(layout.promoters[gene["name"]])
        numbers = {n: int(c[0]) for n, c in layout.copy_numbers(goat[Genome].loci[row][None]).items()}
        assert {n: sum(g["name"] == n and g["to"] > 0 for g in shown["genes"]) for n in numbers} == numbers
    live.sample()
    assert live.frame(0, "gene:size")


@pytest.mark.slow
def test_a_record_has_the_strings_and_who_carries_what(tmp_path):
    run_to_folder(goats_with(ploidy=2), ticks=60, out=tmp_path / "run", report=False)
    lineage = Lineage.read(tmp_path / "run")
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    kept, texts = manifest["genomes"]["goat"], lineage.genome[lineage.species == "goat"]
    assert (kept["longest"], kept["separator"]) == (40, "|")
    assert {text.count("|") for text in texts} == {1}
    assert len({len(text) for text in texts}) > 5
    carried = lineage.frequencies("goat", "green", 20)
    assert carried.values == ("0", "-1")
    alive = (lineage.born <= 0) & (lineage.species == "goat")
    founders = [recorded_genome(kept, text) for text in lineage.genome[alive]]
    says = [
        any(g["name"] == "green" and f["strings"][g["string"]][g["to"] - 1] == "T" for g in f["genes"])
        for f in founders
    ]
    assert carried.of("-1")[0] == sum(says)
    with pytest.raises(ValueError, match="genes have no fixed position"):
        lineage.frequencies("goat", (0, 2), 20)
    assert write_report(tmp_path / "run").exists()


def test_a_recorded_run_is_shown(tmp_path):
    run_to_folder(goats_with(), ticks=40, out=tmp_path / "run", report=False)
    replay = Replay(tmp_path / "run")
    assert replay.frame(0, "gene:size")
    uid = int(replay.organisms("goat").uid[0])
    shown = replay.organism(uid)["genome"]
    assert len(shown["strings"]) == 1
    assert {gene["name"] for gene in shown["genes"]} == {"green", "size", "legs"}
    assert replay.series(-1)["genes"]["goat.size"][0] is not None
