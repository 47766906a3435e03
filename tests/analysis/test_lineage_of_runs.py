"""Lineages of real runs, from their folders and from memory; the command, and the report."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

from ecs_eco import World
from ecs_eco.analysis.lineage import ALIVE, Lineage
from ecs_eco.analysis.report import write_report
from ecs_eco.analysis.runs import load_series
from ecs_eco.cli import app
from ecs_eco.components import Genome
from ecs_eco.record import Recorder, run_to_folder
from ecs_eco.record.belonging import mark_of
from ecs_eco.record.parquet import write_part
from ecs_eco.record.seal import write_manifest
from tests.analysis.families import FAMILY, GENES, parsed, write_folder


@pytest.fixture(scope="module")
def run(menagerie, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "out"
    run_to_folder(menagerie(), seed=7, ticks=60, out=folder, policies="untrained", report=False)
    return folder


def test_the_living_of_a_real_run_are_those_of_its_series_at_every_tick(run):
    lineage, series = Lineage.read(run), load_series(run)
    for species in series.species:
        assert (
            lineage.living_sums(series.ticks, mask=lineage.species == species).tolist()
            == series.of(species).tolist()
        )
    assert (lineage.generation() > 1).any()


def test_a_world_in_memory_has_the_lineage_that_a_folder_has(run, menagerie):
    world = World.from_config(menagerie(), seed=7, policies="untrained", record=False)
    Recorder(world, keep_events=True)
    kept, read = Lineage.of(world.run(60)), Lineage.read(run)
    for name in ("uid", "parent", "parent2", "species", "born", "died", "cause", "genome"):
        assert (getattr(kept, name) == getattr(read, name)).all(), name
    assert (kept.end, kept.dt) == (read.end, read.dt) == (59, 0.5)
    assert set(read.cause) >= {"", "eaten by ram"}


def test_genomes_of_a_real_run_are_those_of_its_organisms(menagerie, tmp_path):
    genes = [
        {"name": "red", "letters": 1, "values": [0, 0, 0, 1]},
        {"name": "age", "trait": "life.age_max", "letters": 4, "low": 50, "high": 90},
    ]
    config = menagerie(
        species={
            "ram": {
                "genome": {"ploidy": 2, "mutate": {"operator": "mutUniformInt", "indpb": 0.2}, "genes": genes}
            }
        }
    )
    run_to_folder(config, seed=7, ticks=60, out=tmp_path / "run", policies="untrained", report=False)
    world = World.from_config(config, seed=7, policies="untrained").run(60)
    table, lineage = world.tables["ram"], Lineage.read(tmp_path / "run").of_species("ram")
    layout, loci, alive = table.species.heredity.layout, table[Genome].loci[table.by_uid()], lineage.alive(59)
    assert lineage.uid[alive].tolist() == table.uid[table.by_uid()].tolist()
    assert lineage.genome[alive].tolist() == [layout.alphabet.decode(row) for row in loci]
    red = lineage.frequencies("ram", "red", 1)
    assert [red.of(v)[-1] for v in ("0", "1")] == [
        (layout.alleles(loci, "red") == v).any(1).sum() for v in (0, 1)
    ]
    assert 0 < red.of("1")[-1] < table.n == red.n[-1]
    born = np.flatnonzero(lineage.mother >= 0)
    assert any(lineage.genome[i] != lineage.genome[lineage.mother[i]] for i in born)  # they mutate
    assert (lineage.genome[lineage.species == "ram"] != "").all()


def test_a_world_that_keeps_no_events_has_no_lineage(menagerie):
    with pytest.raises(RuntimeError, match="keep_events=True"):
        Lineage.of(World.from_config(menagerie()))
    with pytest.raises(RuntimeError, match="no recorder"):
        Lineage.of(World.from_config(menagerie(), record=False))


def test_csv_and_tree_of_a_real_run_agree_with_its_births_and_deaths(run, tmp_path):
    result = CliRunner().invoke(
        app,
        [
            "lineage",
            str(run),
            "--csv",
            str(tmp_path / "ram.csv"),
            "--newick",
            str(tmp_path / "ram.nwk"),
            "--species",
            "ram",
        ],
    )
    assert result.exit_code == 0, result.output
    births, deaths = (
        pa.concat_tables([pq.read_table(p) for p in sorted((run / kind).glob("*.parquet"))])
        for kind in ("births", "deaths")
    )
    births = {b["uid"]: b for b in births.to_pylist() if b["species"] == "ram"}
    died = {d["uid"]: d["tick"] for d in deaths.to_pylist() if d["species"] == "ram"}
    rows = list(csv.DictReader((tmp_path / "ram.csv").read_text(encoding="utf-8").splitlines()))
    assert [int(r["id"]) for r in rows] == sorted(births)
    assert {int(r["id"]): r["ancestor_list"] for r in rows} == {
        u: f"[{b['parent'] or 'none'}]" for u, b in births.items()
    }
    assert {int(r["id"]): int(r["destruction_time"]) for r in rows if r["destruction_time"] != "inf"} == died
    assert {int(r["id"]): int(r["origin_time"]) for r in rows} == {u: b["tick"] for u, b in births.items()}
    tree = parsed((tmp_path / "ram.nwk").read_text().strip())
    assert {int(k): int(p or 0) for k, (p, _) in tree.items()} == {u: b["parent"] for u, b in births.items()}
    assert len(died) > 5
    assert any(b["parent"] for b in births.values())
    alive = len(births) - len(died)
    assert (
        f"ram\n  without parents: 40\n  born to parents: {len(births) - 40}\n  alive at tick 59: "
        f"{alive}\n" in result.output
    )
    assert "moss" not in result.output


def test_the_command_says_every_species_and_prunes_to_the_living(run, tmp_path):
    result = CliRunner().invoke(app, ["lineage", str(run), "--newick", str(tmp_path / "all.nwk"), "--living"])
    assert result.exit_code == 0, result.output
    assert [line for line in result.output.splitlines() if not line.startswith(" ")][:3] == [
        "lynx",
        "moss",
        "ram",
    ]
    lineage = Lineage.read(run)
    tree = parsed((tmp_path / "all.nwk").read_text().strip())
    tips = {int(uid) for uid in tree} - {int(parent) for parent, _ in tree.values() if parent}
    assert tips <= set(lineage.uid[lineage.died < 0].tolist()) <= set(map(int, tree))
    assert len(tree) < len(lineage)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], 'DIR: "nowhere"\n  no such folder; expected: a folder written by `ecs-eco run`'),
        (["."], "has no manifest.json"),
        (
            ["RUN", "--species", "rem"],
            'no such species in this run; expected: lynx, moss, ram; did you mean "ram"?',
        ),
        (["RUN", "--csv", "missing/x.csv"], '--csv: "missing/x.csv"\n  its folder does not exist'),
        (["RUN", "--newick", "."], "is a folder; expected: a file in an existing folder"),
    ],
)
def test_the_command_refuses_what_cannot_be(run, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["lineage", *(str(run) if a == "RUN" else a for a in arguments)])
    assert result.exit_code == 2
    assert message in result.output


def test_the_command_says_what_does_not_fit_in_a_folder(tmp_path):
    result = CliRunner().invoke(
        app, ["lineage", str(write_folder(tmp_path / "run", [*FAMILY, (12, 11, 0, 9, ALIVE, "AA")]))]
    )
    assert result.exit_code == 2
    assert "the organism 12 has the parent 11, whose birth is not recorded" in result.output


@pytest.mark.slow
def test_the_report_draws_genes_of_few_values_alone(run, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(run, folder)
    assert "Genes" not in write_report(folder).read_text()
    births = pa.concat_tables([pq.read_table(p) for p in sorted((folder / "births").glob("*.parquet"))])
    letters = ["ACGT"[u % 4] + "A" for u in births["uid"].to_pylist()]
    births = births.set_column(births.column_names.index("genome"), "genome", pa.array(letters))
    first = folder / "births" / "part-00000.parquet"
    head = write_part(births, first, mark_of(first)[0])
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["heads"]["births"] = head
    genomes = {
        "ram": GENES["finch"],
        "moss": {"alphabet": "ACGT", "ploidy": 1, "genes": GENES["finch"]["genes"][:1]},
    }
    write_manifest(folder, manifest | {"genomes": genomes})
    page = write_report(folder).read_text()
    assert "<h2>Genes</h2>" in page
    assert "Number of ram that carry each gene" in page
    assert "Number of moss" not in page
    assert (Path(folder) / "figures" / "carriers-1.svg").is_file()
