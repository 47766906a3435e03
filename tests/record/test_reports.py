"""Reporters: what a user measures, in the series and in all that reads them."""

import json
from pathlib import Path

import numpy as np
import pytest

from ecs_eco import World, component, f32
from ecs_eco.analysis import measures
from ecs_eco.analysis.compare import compare
from ecs_eco.analysis.runs import load_series
from ecs_eco.components import Body, Metabolism, Position
from ecs_eco.config import load
from ecs_eco.config.models.reporters import is_reporter
from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab.searching.evaluate import objective, score
from ecs_eco.record import Recorder, resume, run_to_folder

PLANT = {"count": 3, "body": {"radius": 0.1}, "metabolism": {"energy": 0.5, "basal": 0.01}}
GARDEN = {
    "format": 1,
    "name": "garden",
    "ticks": 40,
    "space": {"size": [20.0, 20.0]},
    "species": {"moss": PLANT, "fern": PLANT | {"count": 2, "metabolism": {"energy": 0.8}}},
}
REPORTERS = {
    "mean energy": "mean(Metabolism.energy)",
    "ferns per moss": "count(fern) / count(moss)",
    "rich": "count(Metabolism.energy >= 0.5)",
}


def ferns(world):
    """Number of ferns, of the ferns alone."""
    return {"fern": world.tables["fern"].n}


def columns(world, *names):
    """Columns of the series of a world, by species in the order of the file: moss, fern."""
    series = load_series(world.series())
    return [series.columns[name] for name in names]


def test_formulas_and_functions_are_columns_of_the_series():
    world = World.from_config(GARDEN, reporters=REPORTERS | {"ferns": ferns}).run(3)
    mean, ratio, rich, own, energy = columns(world, *REPORTERS, "ferns", "energy_mean")
    np.testing.assert_allclose(mean, energy, rtol=1e-6)
    assert ratio.tolist() == [[2 / 3, 2 / 3]] * 3  # a number of the world stands in each species' row
    assert rich.tolist() == [[0, 2]] * 3
    np.testing.assert_array_equal(own, [[np.nan, 2]] * 3)
    assert world.measure("rich") == {"moss": 0.0, "fern": 2.0}
    assert world.measure("ferns per moss") == 2 / 3


def test_a_run_is_the_same_to_the_bit_with_reporters_and_without():
    plain = World.from_config(GARDEN).run(20)
    reported = World.from_config(GARDEN | {"reporters": REPORTERS}, reporters={"ferns": ferns}).run(20)
    assert reported.digest() == plain.digest()
    for name in plain.series().column_names:
        assert reported.series()[name].equals(plain.series()[name])


def test_a_world_without_reporters_has_the_hash_it_had():
    config = load(GARDEN)
    assert "reporters" not in config.resolved()
    assert load(GARDEN, reporters=REPORTERS).config_hash != config.config_hash


def test_results_do_not_depend_on_rows():
    from ecs_eco.testing import shuffle

    worlds = [
        World.from_config(
            "predator-prey",
            policies="random",
            reporters=REPORTERS | {"ferns per moss": "sum(deer.Metabolism.energy) / count(wolf)"},
        )
        for _ in range(2)
    ]
    shuffle(worlds[1], 3)
    for world in worlds:
        world.run(3)
    for one, other in zip(columns(worlds[0], *REPORTERS), columns(worlds[1], *REPORTERS), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_world_made_by_hand_measures_components_of_its_own():
    @component
    class Wool:
        length: f32 = 0.5  # [m]

    world = World((9.0, 9.0))
    world.add_table("sheep", Position, Body, Wool)
    Recorder(world)
    world.spawn("sheep", Position(x=1.0, y=1.0), Wool(length=0.25), n=2)
    world.run(1)
    world.add_reporter("wool", "sum(Wool.length)")
    world.add_reporter("sheep count", lambda world: np.int64(world.tables["sheep"].n))
    world.run(2)
    wool, n = columns(world, "wool", "sheep count")
    np.testing.assert_array_equal(wool[:, 0], [np.nan, 0.5, 0.5])
    np.testing.assert_array_equal(n[:, 0], [np.nan, 2, 2])


@pytest.mark.parametrize(
    ("name", "what", "words"),
    [
        ("n", "count()", "every series has a column"),
        ("2nd", "count()", "not a name"),
        ("moss", "count()", "has this name"),
        ("x", "energy", 'did you mean "Metabolism.energy"'),
        ("x", "mean(Metabolism.enrgy)", 'no field "enrgy" at character 6; expected: energy'),
        ("x", "mean(frn.Metabolism.energy)", 'did you mean "fern"'),
        ("x", "meen(Metabolism.energy)", 'unknown function "meen" at character 1'),
        ("x", "Metabolism.energy", "a value for each organism"),
        ("x", "mean(mean(Metabolism.energy))", "within another"),
        ("x", "mean(moss.Body.mass * fern.Body.mass)", "of more than one species"),
        ("x", "count(mos)", 'did you mean "moss"'),
        ("x", "1 + 1", "no aggregate function"),
        ("x", "().__class__", "is not a field"),
        ("x", "quantile(Body.mass, 2)", "a number from 0 to 1"),
        ("x", "mean(Position.x", "not an expression"),
        ("x", "garden:ferns", "which `code` does not list"),
        ("x", "garden:ferns:2", "expected a formula or module:name"),
        ("x", 3, "wrong type"),
    ],
)
def test_a_wrong_reporter_is_refused_with_its_place_and_what_is_allowed(name, what, words):
    with pytest.raises(ConfigError, match=name) as error:
        World.from_config(GARDEN | {"reporters": {name: what}})
    assert words in str(error.value)


def test_a_component_that_nobody_has_is_refused_before_the_first_tick():
    with pytest.raises(ConfigError, match="fern does not have the component Nervous"):
        World.from_config(GARDEN | {"reporters": {"mood": "mean(fern.Nervous.happiness)"}})
    with pytest.raises(ConfigError, match="no species has the component Nervous"):
        World.from_config(GARDEN | {"reporters": {"mood": "mean(Nervous.happiness)"}})


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ("many", "returned 'many'; expected a number"),
        ({"mos": 1}, "unknown species 'mos'; known: moss, fern; did you mean"),
        ([1, 2], "expected a number"),
    ],
)
def test_a_function_that_says_something_else_is_named(said, words):
    world = World.from_config(GARDEN, reporters={"odd": lambda world: said})
    with pytest.raises(ValueError, match="reporter 'odd'") as error:
        world.run(1)
    assert words in str(error.value)


def test_an_error_in_a_function_says_in_which_reporter_it_was():
    world = World.from_config(GARDEN, reporters={"odd": lambda world: 1 / 0})
    with pytest.raises(ZeroDivisionError) as error:
        world.run(1)
    assert error.value.__notes__ == ["in the reporter 'odd', at tick 0"]


def test_where_nobody_lives_a_mean_is_nan_and_a_sum_is_0():
    world = World.from_config(
        GARDEN, reporters={"mean": "mean(Metabolism.energy)", "sum": "sum(Metabolism.energy)"}
    )
    moss = world.tables["moss"]
    for uid in moss.uid[moss.rows()].tolist():
        world.kill(uid)
    mean, total = columns(world.run(1), "mean", "sum")
    np.testing.assert_array_equal(np.isnan(mean), [[True, False]])
    assert total[0, 0] == 0


def test_every_column_of_a_series_but_reporters_is_known_by_name():
    names = World.from_config("diel-migration", policies="random").run(1).series().column_names
    assert not [name for name in names if is_reporter(name)]


def test_a_resumed_run_has_the_series_of_one_that_was_not_stopped(tmp_path: Path):
    data = GARDEN | {"reporters": REPORTERS}
    run_to_folder(data, 1, 40, tmp_path / "whole", report=False)
    run_to_folder(data, 1, 15, tmp_path / "stopped", report=False)
    resume(tmp_path / "stopped", 40, report=False)
    whole, stopped = (load_series(tmp_path / name) for name in ("whole", "stopped"))
    assert whole.reporters == tuple(REPORTERS)
    for name, values in whole.columns.items():
        np.testing.assert_array_equal(stopped.columns[name], values)


def test_a_world_restored_with_its_series_in_memory_goes_on_with_them(tmp_path: Path):
    world = World.from_config(GARDEN | {"reporters": REPORTERS}).run(5)
    world.save(tmp_path / "w.safetensors")
    again = World.restore(tmp_path / "w.safetensors")
    assert again.run(5).series().equals(world.run(5).series())


@pytest.mark.slow
def test_a_report_shows_what_was_measured(tmp_path: Path):
    run_to_folder(GARDEN | {"reporters": REPORTERS}, 1, 40, tmp_path / "run")
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert "<h2>Measured</h2>" in page
    for words in ("mean energy", "ferns per moss", "the world"):
        assert words in page
    assert (tmp_path / "run" / "figures" / "measured.svg").stat().st_size > 5000


@pytest.mark.slow
def test_a_comparison_has_means_and_differences_of_what_was_measured(tmp_path: Path):
    arms = {}
    for arm, energy in (("poor", 0.5), ("rich", 0.9)):
        data = json.loads(json.dumps(GARDEN | {"reporters": REPORTERS}))
        data["species"]["moss"]["metabolism"]["energy"] = energy
        arms[arm] = [World.from_config(data, seed=seed).run(20).series() for seed in (1, 2, 3)]
    result = compare(arms, tmp_path, n_boot=19)["measured"]
    assert list(result["arms"]["mean energy"]) == ["moss", "fern"]
    assert list(result["arms"]["ferns per moss"]) == [measures.WORLD]
    poor, rich = (result["arms"]["mean energy"]["moss"][arm]["mean"][0] for arm in arms)
    assert result["effects"]["mean energy"]["moss"]["rich"][0] == pytest.approx(rich - poor)
    assert rich - poor == pytest.approx(0.4)
    assert "<h2>Measured</h2>" in (tmp_path / "compare.html").read_text(encoding="utf-8")


def test_a_reporter_is_an_objective_of_a_search():
    data = GARDEN | {"reporters": REPORTERS, "search": {"objective": "ferns per moss"}}
    world = World.from_config(data).run(10)
    series = load_series(world.series())
    assert objective(world.config.search, series, ["moss"]) == pytest.approx(2 / 3)
    assert score("ferns per moss", series, ["moss"], {"ferns per moss": 1.0}) == pytest.approx(2 / 3)
    assert score("ferns per moss", series, ["moss"], {"ferns per moss": 0.5}) == pytest.approx(3 / 4)
    with pytest.raises(ConfigError, match='did you mean "ferns per moss"'):
        World.from_config(data | {"search": {"objective": "ferns per mos"}})


def test_a_reporter_may_not_join_a_run_that_is_recorded_already(tmp_path: Path):
    def prepare(world):
        with pytest.raises(RuntimeError, match="add it to the world file"):
            world.add_reporter("late", "count()")

    run_to_folder(GARDEN, 1, 2, tmp_path / "run", report=False, prepare=prepare)


def test_energy_of_a_species_by_name_is_one_number_of_the_world():
    world = World.from_config(GARDEN, reporters={"e": "sum(fern.Metabolism.energy)"}).run(1)
    (said,) = columns(world, "e")
    assert said[0].tolist() == [world.tables["fern"][Metabolism].energy[:2].sum(dtype=np.float64)] * 2
