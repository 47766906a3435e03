"""The `record` key: fields of components in the tables of births, deaths and snapshots."""

import numpy as np
import pyarrow.parquet as pq
import pytest

from ecs_eco import System, World, component, f32, i16
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.report import write_report
from ecs_eco.components import Metabolism, Position
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.record import Recorder
from ecs_eco.record.parquet import read_parts
from ecs_eco.runs.run import resume, run_to_folder


@component
class Strain:
    """The pathogen of an organism."""

    virulence: f32 = 0.5
    genome: i16[2] = 3


class Mutate(System):
    """Pathogens become more virulent; the fourth tick kills the first of each species and bears another."""

    needs = (Strain,)

    def update(self, table, world):
        table[Strain].virulence[table.alive] += np.float32(0.25)
        table[Strain].genome[table.alive] += (1, 2)
        if world.tick == 3:
            world.kill(int(table.uid[table.by_uid()[0]]))
            world.spawn(table.name, Position(x=1.0, y=1.0), Strain(virulence=2.0, genome=[8, 9]), parent=2)


def world_of(**changes):
    host = {"count": 2, "body": {"radius": 0.2}, "components": [Strain]}
    config = {
        "format": 1,
        "name": "ward",
        "space": {"size": [9.0, 9.0]},
        "species": {"host": host, "stone": {"count": 1, "body": {"radius": 0.2}}},
        "systems": [Mutate],
        "record": ["Strain.virulence", "Strain.genome"],
    }
    return config | changes


NAMES = ["Strain.virulence", "Strain.genome.0", "Strain.genome.1"]


def rows(folder, kind, species="host"):
    """Return what is recorded of a species in a table."""
    table = read_parts(folder / kind).select(["tick", "species", *NAMES]).to_pylist()
    return [tuple(row[name] for name in ("tick", *NAMES)) for row in table if row["species"] == species]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("ward") / "run"
    run_to_folder(world_of(), seed=1, ticks=6, out=out, snapshot_every=5, report=False, checkpoint_every=2)
    return out


def test_fields_are_in_births_deaths_and_snapshots_and_null_where_a_species_lacks_them(run):
    assert rows(run, "births") == [(0, 0.5, 3, 3), (0, 0.5, 3, 3), (3, 2.0, 8, 9)]
    assert rows(run, "deaths") == [(3, 1.5, 7, 11)]  # four ticks of 0.25, 1 and 2
    assert rows(run, "snapshots") == [*[(0, 0.75, 4, 5)] * 2, (5, 2.0, 9, 15), (5, 2.5, 10, 13)]
    assert rows(run, "births", "stone") == [(0, None, None, None)]
    assert rows(run, "snapshots", "stone") == [(tick, None, None, None) for tick in (0, 5)]
    assert pq.read_schema(run / "births" / "part-00000.parquet").names[-3:] == NAMES


def test_lineages_and_reports_have_recorded_fields(run, tmp_path):
    lineage = Lineage.read(run)
    assert lineage.uid.tolist() == [1, 2, 3, 4]
    host = lineage.of_species("host")
    assert host.recorded["birth: Strain.genome.1"].tolist() == [3, 3, 9]
    np.testing.assert_array_equal(host.recorded["death: Strain.virulence"], [1.5, np.nan, np.nan])
    np.testing.assert_array_equal(lineage.of_species("stone").recorded["birth: Strain.virulence"], [np.nan])
    lines = lineage.to_csv(tmp_path / "tree.csv").read_text().splitlines()
    assert lines[0].endswith(
        ",genome," + ",".join(f"{when}: {n}" for n in NAMES for when in ("birth", "death"))
    )
    assert sum(line.endswith(",,,,,,") for line in lines) == 1  # the stone
    assert sum(line.endswith(",2.0,,8.0,,9.0,") for line in lines) == 1
    page = write_report(run, tmp_path).read_text()
    assert "Recorded fields" in page
    assert (
        "<td class='words'>Strain.genome.0</td><td class='words'>host</td><td>4.67 ± 2.36</td><td>7 ± 0</td>"
        in page
    )
    assert "2.25 ± 0.25" in page  # virulence 2 and 2.5 in the last snapshot


def test_pandas_reads_recorded_fields(run):
    pandas = pytest.importorskip("pandas")
    births = pandas.read_parquet(run / "births")
    assert births["Strain.virulence"].isna().sum() == 1
    assert births["Strain.virulence"].sum() == 3.0


def test_a_world_in_memory_keeps_recorded_fields():
    world = World.from_config(world_of(), seed=1, record=False)
    recorder = Recorder(world, keep_events=True)
    world.run(6)
    assert recorder.events("deaths")["Strain.virulence"].tolist() == [1.5]
    lineage = Lineage.of(world)
    assert np.isnan(lineage.recorded["birth: Strain.virulence"]).sum() == 1
    np.testing.assert_array_equal(np.sort(lineage.recorded["death: Strain.genome.0"]), [7, *[np.nan] * 3])


def test_a_resumed_run_records_the_same_bytes(run, tmp_path):
    half = tmp_path / "half"
    run_to_folder(world_of(), seed=1, ticks=4, out=half, snapshot_every=5, report=False)
    resume(half, 6, report=False, trust=True)
    for kind in ("births", "deaths", "snapshots"):
        assert read_parts(half / kind).equals(read_parts(run / kind)), kind


def test_recording_changes_no_other_column_and_no_result(run, tmp_path):
    plain = tmp_path / "plain"
    run_to_folder(world_of(record=[]), seed=1, ticks=6, out=plain, snapshot_every=5, report=False)
    for kind in ("births", "deaths", "snapshots", "series"):
        table = read_parts(run / kind)
        assert table.drop_columns([n for n in table.column_names if n in NAMES]).equals(
            read_parts(plain / kind)
        )
    digests = [World.from_config(world_of(record=r)).run(6).digest() for r in ([], ["Strain.genome"])]
    assert digests[0] == digests[1]


@pytest.mark.parametrize(
    ("field", "words"),
    [
        ("Strain.virulense", ['record.0 = "Strain.virulense"', "Strain has no field", "Strain.virulence"]),
        ("Strian.virulence", ['unknown component "Strian"', 'did you mean "Strain.virulence"?']),
        ("Strain", ["Strain is a component", "Strain.virulence, Strain.genome"]),
        ("virulence", ["not a Component.field", 'did you mean "Strain.virulence"?']),
        ("Gestation.sperm", None),
    ],
)
def test_names_are_checked_when_a_world_is_loaded(field, words):
    with pytest.raises(ConfigError) as error:
        load(world_of(record=[field])) if words else World.from_config(world_of(record=[field]))
    for word in words or ["no species has the component Gestation"]:
        assert word in str(error.value)


def test_a_field_is_recorded_once_and_columns_are_limited():
    with pytest.raises(ConfigError, match="recorded twice"):
        load(world_of(record=["Metabolism.energy"] * 2))
    many = component(type("Many", (), {"__annotations__": {"x": f32[300]}, "x": 0.0, "__module__": __name__}))
    config = world_of(record=["Many.x"])
    config["species"]["stone"]["components"] = [many]
    with pytest.raises(ConfigError, match="too many columns"):
        World.from_config(config)


def test_a_shipped_component_is_recorded():
    world = World.from_config(world_of(record=["Metabolism.burnt"]), record=False)
    recorder = Recorder(world, keep_events=True)
    world.run(4)
    assert recorder.events("births")["Metabolism.burnt"].dtype == world.table("host")[Metabolism].burnt.dtype
