import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.engine.files import write_json
from ecs_eco.engine.versions import versions
from ecs_eco.record import run_to_folder
from ecs_eco.record.folder import git_commit
from ecs_eco.record.parquet import read_parts

TICKS = 40
FOUNDERS = 150 + 40 + 8


@pytest.fixture(scope="module")
def run(menagerie, tmp_path_factory):
    out = tmp_path_factory.mktemp("run") / "new" / "folder"
    shown = []
    manifest = run_to_folder(
        menagerie(),
        seed=7,
        ticks=TICKS,
        out=out,
        policies="untrained",
        snapshot_every=10,
        report=False,
        progress=lambda *at: shown.append(at),
    )
    return out, manifest, shown


def test_the_manifest_says_all_that_decides_the_run(run, menagerie):
    out, manifest, shown = run
    written = json.loads((out / "manifest.json").read_text())
    assert len(written.pop("seal")) == 64
    assert written == manifest
    expected = {
        "format": 2,
        "world": "menagerie",
        "seed": 7,
        "ticks": TICKS,
        "done": TICKS,
        "dt": 0.5,
        "policies": "untrained",
        "finished": True,
        "species": ["moss", "ram", "lynx"],
        "config_hash": load(menagerie()).config_hash,
    }
    assert {k: written[k] for k in expected} == expected
    assert load(written["config"]).config_hash == written["config_hash"]
    assert set(written["colors"]) == set(written["species"])
    assert written["causes"][0] == "culled"
    assert {"python", "numpy", "numba", "torch", "esper"} <= set(written["versions"])
    assert written["wall_seconds"] > 0
    world = World.from_config(menagerie(), seed=7, policies="untrained").run(TICKS)
    assert written["digest"] == world.digest()
    assert shown[-1] == (TICKS, TICKS)


def test_the_parquet_holds_what_a_world_in_memory_recorded(run, menagerie):
    out, _, _ = run
    world = World.from_config(menagerie(), seed=7, policies="untrained").run(TICKS)
    kept, written = world.series(), read_parts(out / "series")
    assert written.column_names == kept.column_names
    assert written.to_pydict() == kept.to_pydict()
    types = {f.name: f.type for f in written.schema}
    assert types["tick"] == pa.int64()
    assert types["n"] == pa.int32()
    assert types["energy_mean"] == pa.float32()
    assert types["stock_after"] == pa.float64()
    assert pa.types.is_dictionary(types["species"])
    assert types["died: starved"] == pa.int32()


def test_births_deaths_and_snapshots_are_there(run):
    out, manifest, _ = run
    series, births, deaths = (read_parts(out / kind).to_pydict() for kind in ("series", "births", "deaths"))
    assert len(births["uid"]) == FOUNDERS + sum(series["births"]) > FOUNDERS
    assert births["genome"] == [None] * len(births["uid"])  # no species has one
    assert manifest["genomes"] == {}
    assert len(deaths["uid"]) == sum(series["deaths"]) > 0
    for cause in manifest["causes"]:
        assert deaths["cause"].count(cause) == sum(series[f"died: {cause}"])
    eaten = [(c, k) for c, k in zip(deaths["cause"], deaths["killer"], strict=True) if c.startswith("eaten")]
    assert eaten
    assert all(k for _, k in eaten)
    assert len(set(births["uid"])) == len(births["uid"])
    snapshots = read_parts(out / "snapshots").to_pydict()
    assert sorted(set(snapshots["tick"])) == [0, 10, 20, 30]
    assert not list(out.rglob("*.tmp"))


class _PowerCut(Exception):
    """Something from outside."""


# before and after the dead are buried
@pytest.mark.parametrize(("error", "where"), [(_PowerCut, "Feed"), (KeyboardInterrupt, "Spread")])
def test_an_interrupted_run_leaves_readable_parts_and_says_that_it_is_not_finished(
    menagerie, tmp_path, monkeypatch, error, where
):
    from ecs_eco import systems

    system = getattr(systems, where)
    process = system.process

    def failing(self, *arguments):
        process(self, *arguments)
        if self.world.tick == 12:
            raise error

    monkeypatch.setattr(system, "process", failing)
    with pytest.raises(error):
        run_to_folder(
            menagerie(), seed=7, ticks=TICKS, out=tmp_path / "run", policies="untrained", report=False
        )
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert (manifest["finished"], manifest["done"], manifest["ticks"]) == (False, 12, TICKS)
    series = read_parts(tmp_path / "run" / "series").to_pydict()
    assert series["tick"] == [t for t in range(12) for _ in range(3)]
    deaths, births = (read_parts(tmp_path / "run" / kind).to_pydict() for kind in ("deaths", "births"))
    assert len(deaths["uid"]) == sum(series["deaths"])
    assert len(births["uid"]) == FOUNDERS + sum(series["births"])
    assert max(deaths["tick"] + births["tick"]) < 12
    monkeypatch.undo()
    whole = World.from_config(menagerie(), seed=7, policies="untrained").run(12)
    assert series == whole.series().to_pydict()


def test_a_part_is_whole_or_not_there(run, tmp_path, monkeypatch):
    from ecs_eco.engine import files
    from ecs_eco.record import parquet as arrow

    table = pa.table({"x": np.arange(3.0)})
    monkeypatch.setattr(files.os, "fsync", lambda _: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        arrow.write_part(table, tmp_path / "part-00000.parquet")
    assert not (tmp_path / "part-00000.parquet").exists()
    (tmp_path / "manifest.json").write_text('{"old": 1}')
    with pytest.raises(OSError, match="disk full"):
        write_json(tmp_path / "manifest.json", {"new": 2})
    assert json.loads((tmp_path / "manifest.json").read_text()) == {"old": 1}


def test_parts_of_a_long_run_are_read_as_one(tmp_path):
    from ecs_eco.record.parquet import to_arrow, write_part

    for part, columns in enumerate(
        [{"tick": np.arange(3)}, {"tick": np.arange(3, 5), "died: late": np.array([0, 1], np.int32)}]
    ):
        write_part(
            to_arrow(columns | {"species": np.zeros(len(columns["tick"]), np.int8)}, {"species": ["moss"]}),
            tmp_path / f"part-{part:05d}.parquet",
        )
    both = read_parts(tmp_path).to_pydict()
    assert both["tick"] == [0, 1, 2, 3, 4]
    assert both["died: late"] == [None, None, None, 0, 1]
    assert both["species"] == ["moss"] * 5
    assert pq.read_metadata(tmp_path / "part-00000.parquet").num_rows == 3


def test_a_folder_that_holds_something_is_not_touched(menagerie, tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(FileExistsError, match="exists and is not an empty folder; name another with --out"):
        run_to_folder(menagerie(), ticks=1, out=tmp_path, policies="untrained")
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_run_of_no_ticks_leaves_a_manifest(menagerie, tmp_path):
    manifest = run_to_folder(menagerie(), ticks=0, out=tmp_path, policies="random", report=False)
    assert (manifest["finished"], manifest["done"]) == (True, 0)


def test_versions_and_commit():
    assert all(isinstance(v, str) for v in versions().values())
    commit = git_commit()
    assert commit is None or len(commit) == 40


@pytest.mark.slow
def test_a_run_goes_on_and_is_whole_after_an_extinction(tmp_path):
    import json

    from ecs_eco.config import load
    from ecs_eco.record import run_to_folder
    from ecs_eco.record.parquet import read_parts

    small = {
        "space.size": [60.0, 60.0],
        "species.grass.count": 100,
        "species.deer.count": 10,
        "species.wolf.count": 3,
        "species.deer.metabolism.basal": 0.05,
        "species.wolf.metabolism.basal": 0.05,
    }
    run_to_folder(
        load("predator-prey", small),
        seed=1,
        ticks=60,
        out=tmp_path / "run",
        policies="random",
        snapshot_every=5,
    )
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    series, snapshots = read_parts(tmp_path / "run" / "series"), read_parts(tmp_path / "run" / "snapshots")
    assert (manifest["finished"], manifest["done"]) == (True, 60)
    assert [
        n for s, n in zip(series["species"].to_pylist(), series["n"].to_pylist(), strict=True) if s == "deer"
    ][-1] == 0
    assert max(snapshots["tick"].to_pylist()) == 55  # of the grass alone
    assert (tmp_path / "run" / "report.html").is_file()


def test_genomes_are_strings_that_repeat_or_do_not(tmp_path):
    from ecs_eco.record.parquet import to_arrow, write_part

    rng = np.random.default_rng(1)
    many = np.frombuffer(rng.choice(list(b"ACGT"), 8 * 1000).astype(np.uint8).tobytes(), "S8")
    few = np.where(np.arange(1000) % 2, b"ACGTACGT", b"TTTTTTTT")
    for name, column in {"few": few, "many": many, "none": np.zeros(1000, "S1")}.items():
        write_part(to_arrow({"genome": column}, {}), tmp_path / f"{name}.parquet")
        read_back = pq.read_table(tmp_path / f"{name}.parquet")["genome"]
        assert read_back.type == pa.string()
        assert read_back.to_pylist() == [text.decode() or None for text in column.tolist()]
    encodings = {
        name: pq.read_metadata(tmp_path / f"{name}.parquet").row_group(0).column(0).encodings
        for name in ("few", "many")
    }
    assert ["RLE_DICTIONARY" in encodings[name] for name in ("few", "many")] == [True, False]


def test_the_manifest_names_the_genes_of_a_layout():
    from types import SimpleNamespace

    from ecs_eco.analysis.carriers import numbers
    from ecs_eco.genomes import Gene, Layout
    from ecs_eco.life.kind import Kind
    from ecs_eco.record.genomes import genes_of

    genes = [
        Gene(name="red", trait="reflex.red.weight", letters=1, values=[0, 0, 0, -1]),
        Gene(name="size", trait="body.radius", letters=4, low=0.2, high=0.6),
        Gene(name="song", letters=2, at=7, values=list(range(16))),
    ]
    layout = Layout(genes, "ACGU", ploidy=2, loci=10)
    described = genes_of(SimpleNamespace(species=Kind(heredity=SimpleNamespace(layout=layout))))
    assert described == {
        "alphabet": "ACGU",
        "ploidy": 2,
        "genes": [
            {
                "name": "red",
                "at": 0,
                "letters": 1,
                "trait": "reflex.red.weight",
                "values": [0.0, 0.0, 0.0, -1.0],
                "dominance": "first",
            },
            {
                "name": "size",
                "at": 1,
                "letters": 4,
                "trait": "body.radius",
                "dominance": "first",
                "range": {"low": 0.2, "high": 0.6, "code": "positional", "scale": "linear", "codons": 1},
            },
            {
                "name": "song",
                "at": 7,
                "letters": 2,
                "trait": None,
                "values": [float(v) for v in range(16)],
                "dominance": "first",
            },
        ],
    }
    row = layout.encode({"red": -1, "size": 0.2, "song": 11})[0]
    # codons mean the same to readers of a folder
    assert numbers(["ACGU"[row[7]] + "ACGU"[row[8]]], described["genes"][2], "ACGU") == 11
    assert genes_of(SimpleNamespace(species=Kind())) is None
    assert genes_of(SimpleNamespace(species=Kind(heredity=SimpleNamespace(layout=None)))) is None


def test_parts_are_read_from_memory_of_arrows_own(tmp_path):
    """A thread of Arrow's that lets go of an object of Python's at the interpreter's end would abort the
    process."""
    from ecs_eco.record import parquet

    parquet.write_part(
        pa.table({"tick": np.arange(10), "x": np.arange(10.0)}), tmp_path / "part-00000.parquet"
    )
    opened = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            parquet.pa, "BufferReader", lambda part, real=pa.BufferReader: opened.append(part) or real(part)
        )
        assert parquet.read_part(tmp_path / "part-00000.parquet").num_rows == 10
    assert all(type(part) is pa.Buffer for part in opened)
    assert len(opened) == 1


def test_only_the_one_reader_reads_parquet():
    import ecs_eco

    root = Path(ecs_eco.__file__).parent
    words = ("pyarrow.parquet", "pyarrow.dataset", "read_row_group(", "iter_batches(")
    readers = {
        str(p.relative_to(root)) for p in root.rglob("*.py") if any(word in p.read_text() for word in words)
    }
    # belonging reads footers alone, and keeps no bytes; geodata only writes
    assert readers == {"record/parquet.py", "record/belonging.py", "record/geodata.py"}
