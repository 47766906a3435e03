"""Some hundred cases of studies/fuzz.py, which has the rest; and what fuzzing found, each by itself."""

import json
import os
import random
import re
import signal
import time
import warnings

import numpy as np
import pytest
from typer.testing import CliRunner

from ecs_eco.cli.app import app
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError, RecordingError
from studies.common.fuzz import files, worlds
from studies.common.fuzz.guard import guarded
from studies.common.fuzz.sources import parsed, sources


def _judged(judge, items):
    collected = []
    for item in items:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            collected.append(judge(item) | {"item": item[:3]})
    return collected


@pytest.mark.slow
@pytest.mark.parametrize("what", ["text", "values"])
def test_mutated_worlds_are_refused_with_a_place_or_run(what, tmp_path):
    outcomes = _judged(worlds.judge, [("herd", what, seed, str(tmp_path)) for seed in range(40)])
    assert not [f for f in outcomes if f["kind"] in worlds.FAILURES]
    kinds = {f["kind"] for f in outcomes}
    assert {"refused", "ran 5 ticks"} <= kinds


@pytest.mark.slow
@pytest.mark.parametrize("world", ["predator-prey", "menagerie"])
def test_mutated_worlds_are_refused_with_a_place_or_accepted(world, tmp_path, monkeypatch):
    monkeypatch.setattr(worlds, "_run", lambda config: {"kind": "accepted"})
    outcomes = _judged(
        worlds.judge,
        [(world, what, seed, str(tmp_path)) for what in ("text", "values") for seed in range(100)],
    )
    assert not [f for f in outcomes if f["kind"] in worlds.FAILURES]
    assert {"refused", "accepted"} <= {f["kind"] for f in outcomes}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded") / "run"
    files.recorded("herd", folder)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("judge", [files._Checkpoints, files._Recordings])
def test_damaged_files_are_refused_by_name_or_hold_the_same(judge, recorded, tmp_path):
    outcomes = _judged(judge(recorded, tmp_path / "damaged"), [("herd", "", seed) for seed in range(1, 61)])
    assert not [f for f in outcomes if f["kind"] in worlds.FAILURES]
    assert sum(f["kind"] == "refused" for f in outcomes) > 50


def test_the_judge_sees_a_wrong_load(recorded, tmp_path, monkeypatch):
    from ecs_eco.record import checkpoint

    judge, read = files._Checkpoints(recorded, tmp_path / "damaged"), checkpoint.read

    def careless(path):
        meta, arrays = read(path)
        return meta, arrays | {
            "table/goat/uid": arrays["table/goat/uid"] + (1 if "damaged" in str(path) else 0)
        }

    assert judge.asked(judge.files()[0], 1)["kind"] == "same content"
    monkeypatch.setattr(checkpoint, "read", careless)
    assert judge.asked(judge.files()[0], 1)["kind"] == "wrong load"


def test_readings_are_the_same_to_the_bit():
    one = {"a": [np.array([np.nan, 0.0]), 1.0, float("nan")], "b": "x"}
    assert files._equal(one, {"a": [np.array([np.nan, 0.0]), 1.0, float("nan")], "b": "x"})
    for other in (
        {"a": one["a"]},
        one | {"b": "y"},
        one | {"a": [np.array([np.nan, -0.0]), 1.0, float("nan")]},
        one | {"a": one["a"][:2]},
    ):
        assert not files._equal(one, other)


def test_a_hang_and_a_dead_process_are_counted_and_the_rest_goes_on():
    def judge(item):
        if item == 1:
            time.sleep(60)
        if item == 2:
            os.kill(os.getpid(), signal.SIGKILL)
        return {"kind": str(item)}

    outcomes = list(guarded(judge, range(4), seconds=1.0))
    assert [f["kind"] for f in outcomes] == ["0", "hang", "crash", "3"]


@pytest.mark.parametrize("kind", ["series", "births", "deaths", "snapshots"])
def test_one_flipped_bit_anywhere_in_a_part_is_seen(kind, recorded, tmp_path):
    from ecs_eco.record.parquet import read_part

    part = sorted((recorded / kind).glob("*.parquet"))[0]
    raw, chance = part.read_bytes(), random.Random(5)
    for at in chance.sample(range(len(raw)), 40):
        damaged = bytearray(raw)
        damaged[at] ^= 1 << chance.randrange(8)
        (tmp_path / "part.parquet").write_bytes(damaged)
        with pytest.raises(RecordingError, match=r"part\.parquet: is damaged"):
            read_part(tmp_path / "part.parquet", needed=True)


def test_a_changed_manifest_is_refused_and_one_without_seal_too(recorded, tmp_path):
    from ecs_eco.analysis.runs import load_series

    files._copied(recorded, tmp_path / "run")
    manifest = json.loads((recorded / "manifest.json").read_text())
    (tmp_path / "run" / "manifest.json").write_text(json.dumps(manifest | {"dt": 2.0}))
    with pytest.raises(RecordingError, match="its seal does not match"):
        load_series(tmp_path / "run")
    (tmp_path / "run" / "manifest.json").write_text(
        json.dumps({k: v for k, v in manifest.items() if k != "seal"})
    )
    with pytest.raises(RecordingError, match="its seal is missing"):
        load_series(tmp_path / "run")


@pytest.mark.slow
@pytest.mark.parametrize("command", ["report", "lineage"])
def test_a_damaged_part_ends_a_command_with_its_name(command, recorded, tmp_path):
    files._copied(recorded, tmp_path / "run")
    part = tmp_path / "run" / "births" / "part-00000.parquet"
    part.write_bytes(part.read_bytes()[:-7])
    done = CliRunner().invoke(app, [command, str(tmp_path / "run")])
    assert done.exit_code in (1, 2)
    assert "part-00000.parquet: is damaged" in done.stderr


# --- what fuzzing found -------------------------------------------------------------------------------------


def _goat(path, value):
    """The herd with one value of a goat changed."""
    data = parsed(sources()["herd"][0])
    node = data["species"]["goat"]
    for part in path[:-1]:
        node = node[part]
    node[path[-1]] = value
    return data


def _refused(data, path, *words):
    with pytest.raises(ConfigError) as error:
        load(data)
    [problem] = [p for p in error.value.problems if ".".join(map(str, p.key)) == path]
    for word in words:
        assert word in str(problem)


def test_a_nose_further_off_than_the_world_is_wide_is_refused():
    # it smelled beyond the end of the field: 30 m of world, bodies of up to 0.6 m (a gene says so),
    # so 25 radii at most
    _refused(_goat(("sensors", 2, "at"), [1e6, 0.5]), "species.goat.sensors.2.at", "at most 25")
    assert load(_goat(("sensors", 2, "at"), [24.0, 0.5]))


def _gene(data, trait):
    """The place of a gene of the goat, and the gene."""
    return next(
        (i, gene)
        for i, gene in enumerate(data["species"]["goat"]["genome"]["genes"])
        if gene.get("trait") == trait
    )


def test_a_gene_that_puts_a_nose_there_is_refused():
    data = _goat(("count",), 5)
    i, gene = _gene(data, "sensors.musk.left")
    gene["low"] = -1e6
    _refused(data, f"species.goat.genome.genes.{i}.low", "-25 to 25")


def test_a_gene_of_pace_beyond_the_world_is_refused():
    data = _goat(("count",), 5)
    i, gene = _gene(data, "locomotion.pace")
    gene["high"] = 1e6
    _refused(data, f"species.goat.genome.genes.{i}.high", "at most 18.75")  # 15 m, at 0.8 m in a tick


@pytest.mark.parametrize("value", ["1/0", {}, [], True])
def test_a_hyperparameter_that_is_no_number_is_told_where_genes_name_it(value):
    _refused(_goat(("ppo", "learning_rate"), value), "species.goat.ppo.learning_rate", "not possible")


@pytest.mark.parametrize(
    ("name", "value", "most"), [("entropy_coef", 1e39, "1e+30"), ("horizon", 10**40, "1e+09")]
)
def test_a_hyperparameter_beyond_all_numbers_is_refused(name, value, most):
    _refused(_goat(("ppo", name), value), f"species.goat.ppo.{name}", f"at most {most}")


def test_a_long_genome_is_checked_at_once():
    # operators were tried on all of it
    assert load(_goat(("genome", "loci"), 50_000_000)).species["goat"].genome.loci == 50_000_000


@pytest.mark.parametrize(
    ("mutate", "word"),
    [({"low": [0], "up": 1, "indpb": 0.1}, "1 numbers as low"), ({"indpb": "x"}, "indpb = x")],
)
def test_odd_arguments_of_an_operator_are_refused(mutate, word):
    _refused(
        _goat(("genome", "mutate"), {"operator": "mutUniformInt", **mutate}),
        "species.goat.genome.mutate.operator",
        word,
    )


@pytest.mark.parametrize(("section", "cell"), [("terrain", 1e-200), ("fields", 1e-200)])
def test_cells_whose_square_is_nothing_are_refused(section, cell):
    data = _goat(("count",), 5)
    if section == "terrain":
        data["terrain"] = {"cell": cell}
        _refused(data, "terrain.cell", "too small for float32")
    else:
        data["fields"]["musk"]["cell"] = cell
        _refused(data, "fields.musk.cell", "too small for float32")


@pytest.mark.parametrize("section", ["terrain", "fields"])
def test_cells_of_almost_nothing_are_refused_for_their_number(section):
    data = _goat(("count",), 5)
    (data.setdefault("terrain", {}) if section == "terrain" else data["fields"]["musk"])["cell"] = 1e-30
    _refused(data, "terrain.cell" if section == "terrain" else "fields.musk.cell", "cells")


def test_a_number_that_float32_makes_0_is_refused_where_0_is():
    _refused(
        _goat(("sensors", 2, "half_saturation"), 5e-324),
        "species.goat.sensors.2.half_saturation",
        "at least 1e-30",
    )


def test_more_sites_of_plants_than_can_be_is_refused():
    data = _goat(("count",), 5)
    data["space"]["size"] = [30.0, 1e8]
    _refused(data, "species.grass.reproduction.spacing", "sites")


def test_many_problems_of_a_long_file_are_told_at_once(tmp_path):
    eaten = ", ".join('{ eats = "nobody", gain = 0.1 }' for _ in range(3000))  # each line was looked for anew
    text = sources()["menagerie"][0]
    new = re.sub(r'diet = \[\{ eats = "ram".*?\]', f"diet = [{eaten}]", text)
    assert new != text
    (tmp_path / "world.toml").write_text(new)
    with pytest.raises(ConfigError, match=r"world\.toml, line \d+: species\.lynx\.diet\.0\.eats"):
        load(tmp_path / "world.toml")


def test_too_little_memory_ends_a_command_with_a_word(monkeypatch):
    def exhausted(*arguments, **more):
        raise MemoryError("Unable to allocate 3 TiB")

    monkeypatch.setattr("ecs_eco.cli.run.run_to_folder", exhausted)
    done = CliRunner().invoke(app, ["run", "predator-prey"])
    assert (done.exit_code, done.stderr) == (1, "Not enough memory: Unable to allocate 3 TiB\n")
