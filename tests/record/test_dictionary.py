"""Recorded columns say what they hold: in the metadata of Parquet files, and in a run's data dictionary."""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from ecs_eco import System, World, component, f32, i16
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.analysis.runs import load_series
from ecs_eco.components import Body
from ecs_eco.engine import files
from ecs_eco.engine.comments import comments_of
from ecs_eco.engine.errors import RecordingError
from ecs_eco.record.dictionary import FIXED, Meaning
from ecs_eco.record.events import EVENTS
from ecs_eco.record.learning import ACTIONS, LEARNING
from ecs_eco.record.parquet import read_part, read_parts, write_part
from ecs_eco.runs.run import resume, run_to_folder


@component
class Fleas:
    """Parasites of a host."""

    number: f32 = 2.0  # [fleas] on the skin
    stages: i16[2] = 1  # [1] eggs and adults


class Itch(System):
    """Fleas multiply."""

    needs = (Fleas,)

    def update(self, table, world):
        table[Fleas].number[table.alive] += 1


def itchy(menagerie):
    genes = [{"name": "size", "trait": "body.radius", "letters": 2, "low": 0.2, "high": 0.4}]
    return menagerie(
        species={"ram": {"components": [Fleas], "genome": {"genes": genes}}},
        systems=[Itch],
        record=["Fleas.number", "Fleas.stages"],
        reporters={"fleas": "mean(ram.Fleas.number)"},
    )


@pytest.fixture(scope="module")
def run(menagerie, tmp_path_factory):
    out = tmp_path_factory.mktemp("itch") / "run"
    options = {"policies": "untrained", "report": False, "record": "focal=2", "snapshot_every": 5}
    run_to_folder(itchy(menagerie), seed=3, ticks=20, out=out, **options)
    return out


def said(run: Path, kind: str, column: str) -> Meaning:
    metadata = pq.read_schema(run / kind / "part-00000.parquet").field(column).metadata
    return Meaning(*(metadata[word.encode()].decode() for word in Meaning._fields))


def test_every_recorded_column_has_a_description_a_source_and_if_a_number_a_unit(run):
    kinds = {part.parent.name for part in run.glob("*/part-*.parquet")}
    assert kinds >= {"series", "births", "deaths", "snapshots", "matter", "actions", "details-ram"}
    for kind in kinds:
        for field in pq.read_schema(run / kind / "part-00000.parquet"):
            meaning = said(run, kind, field.name)
            assert meaning.description, (kind, field.name)
            assert meaning.source, (kind, field.name)
            assert meaning.unit or not pa.types.is_floating(field.type) or field.name == "fleas", field.name


def test_every_column_that_any_recording_may_have_is_explained():
    names = EVENTS | {"learning": tuple(LEARNING), "actions": tuple(ACTIONS)}
    for kind, columns in names.items():
        for column in columns:
            assert (kind, column) in FIXED or ("*", column) in FIXED, (kind, column)


def test_shipped_columns_have_their_unit_and_field(run):
    assert said(run, "deaths", "age") == Meaning("s", "age at death", "table.born")
    assert said(run, "births", "x").unit == "m"
    assert said(run, "series", "taken_in") == Meaning(
        "energy", "energy from food and light", "Metabolism.taken"
    )
    assert (
        said(run, "series", "died: eaten by ram").description
        == 'deaths in the tick with the cause "eaten by ram"'
    )


def test_columns_of_users_say_what_their_source_says(run):
    assert said(run, "births", "Fleas.number") == Meaning("fleas", "on the skin", "Fleas.number")
    assert said(run, "snapshots", "Fleas.stages.1") == Meaning(
        "1", "eggs and adults, entry 1", "Fleas.stages"
    )
    measured = said(run, "series", "fleas")
    assert measured.description == "your own measurement: mean(ram.Fleas.number)"
    assert measured.source == "reporters, fleas"


def test_comments_give_unit_and_meaning_of_a_field():
    assert comments_of(Fleas) == {"number": ("fleas", "on the skin"), "stages": ("1", "eggs and adults")}
    made = component(type("Made", (), {"__annotations__": {"x": f32}, "x": 0.0, "__module__": "nowhere"}))
    assert comments_of(made) == {}  # without a source


def test_a_name_of_several_noses_is_said_to_be_their_mean(tmp_path):
    out = tmp_path / "run"
    run_to_folder(
        "predator-prey", seed=1, ticks=2, out=out, policies="random", report=False, record="focal=1"
    )
    mean = "wolf_smell is the mean of wolf_smell_1 and wolf_smell_2"
    assert mean in said(out, "series", "happiness_mean").description
    assert mean in said(out, "details-deer", "sensor: wolf_smell_2").description
    felt = said(out, "details-deer", "happiness").description
    assert felt == f"happiness of the organism (energy - 0.3 * wolf_smell, where {mean})"
    assert said(out, "details-deer", "sensor: deer_near").source == "sensors.2, nearest"


def test_the_data_dictionary_of_a_run_is_that_of_its_files(run):
    content = json.loads((run / "data_dictionary.json").read_text())
    assert content["tables"]["births"]["Fleas.number"] == {
        "type": "float",
        "unit": "fleas",
        "description": "on the skin",
        "source": "Fleas.number",
    }
    for kind, columns in content["tables"].items():
        parts = sorted((run / kind).glob("*.parquet"))
        assert set(columns) == {name for part in parts for name in pq.read_schema(part).names}
    size = content["genes"]["ram"]["size"]
    assert size == {"unit": "m", "description": "radius of the body", "source": "body.radius, loci from 0"}
    page = (run / "data_dictionary.md").read_text()
    assert "\n## deaths/part-*.parquet\n\n| name | type | unit | description | source |\n" in page
    assert "\n| `age` | float | s | age at death | table.born |\n" in page


def test_a_resumed_run_has_the_same_dictionary_and_parts(run, menagerie, tmp_path):
    half = tmp_path / "half"
    options = {"policies": "untrained", "report": False, "record": "focal=2", "snapshot_every": 5}
    run_to_folder(itchy(menagerie), seed=3, ticks=11, out=half, **options)
    resume(half, 20, report=False, trust=True)
    for name in ("data_dictionary.json", "data_dictionary.md"):
        assert (half / name).read_bytes() == (run / name).read_bytes()


def test_parts_of_before_without_descriptions_are_read_along_with_new_ones(run, tmp_path):
    table = read_parts(run / "series")
    old = pa.Table.from_arrays(table.columns, names=table.column_names).slice(0, 30)
    (tmp_path / "series").mkdir()
    write_part(old, tmp_path / "series" / "part-00000.parquet")
    write_part(table.slice(30), tmp_path / "series" / "part-00001.parquet")
    (tmp_path / "manifest.json").write_text("{}")
    assert old.schema.field("n").metadata is None
    assert (load_series(tmp_path).of("ram") == load_series(run).of("ram")).all()


def test_a_run_is_a_table_of_organisms_and_one_of_their_genes(run, menagerie):
    pytest.importorskip("pandas")
    lineage = Lineage.read(run)
    frame, genes = lineage.to_pandas(), lineage.genes_to_pandas("ram")
    assert len(frame) == len(lineage)
    assert frame["died"].isna().sum() == frame["cause"].isna().sum() == (lineage.died < 0).sum()
    assert frame.loc[frame["species"] == "ram", "birth: Fleas.number"].iloc[0] == 2.0
    world = World.from_config(itchy(menagerie), seed=3, policies="untrained").run(20)
    ram = world.tables["ram"]
    living = genes.loc[ram.uid[ram.by_uid()]]
    assert living["size"].to_numpy() == pytest.approx(ram[Body].radius[ram.by_uid()])


def test_a_part_that_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    part = tmp_path / "part-00000.parquet"
    write_part(pa.table({"n": [7] * 100_000}), part)
    assert part.stat().st_size < 3000
    assert read_part(part).num_rows == 100_000
    monkeypatch.setattr(files, "MOST_BYTES", 300_000)
    with pytest.raises(RecordingError, match=r"part-00000\.parquet: unpacks to more than 600,000 bytes"):
        read_part(part)
