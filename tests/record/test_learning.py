"""What a recording holds of learning and actions: counted by hand, whole after a resume, and of no effect."""

import numpy as np
import pyarrow.parquet as pq
import pytest

from ecs_eco import World
from ecs_eco.record import resume, run_to_folder
from ecs_eco.record.learning import UPDATE, LearningPages, count_actions
from ecs_eco.record.parquet import read_parts


def test_of_a_group_the_first_action_that_is_on_is_counted_else_the_neutral_one():
    #             speed: still, walk, run; eat
    decision = np.array([[0, 1, 1, 1], [0, 0, 0, 0], [1, 0, 1, 0], [0, 0, 1, 1], [0, 1, 0, 1]], np.int8)
    alive, born = np.array([True, True, True, False, True]), np.array([0, 0, 0, 0, 7])
    done = np.zeros(4, np.int64)
    n = count_actions(
        np.arange(5), alive, born, 7, decision, np.array([0, 3]), np.array([3, 1]), np.array([0, -1]), done
    )
    assert n == 3  # one is dead, one was born in this tick and has not decided
    assert done.tolist() == [2, 1, 0, 1]


def test_every_update_has_a_row_and_every_tenth_tick_one_for_each_action(menagerie):
    world = World.from_config(menagerie(), seed=3, policies="untrained", learn=True)
    world.run(41)
    nerves = world.tables["ram"].species.nerves
    table = world.recorder.learning_series()
    assert table["tick"].to_pylist() == [r["tick"] for r in nerves.reports]
    for word in UPDATE:
        assert table[word].to_numpy() == pytest.approx([r[word] for r in nerves.reports], rel=1e-6), word
    acts = world.recorder.action_series().to_pydict()
    assert sorted(set(acts["tick"])) == [0, 10, 20, 30, 40] or sorted(set(acts["tick"])) == [10, 20, 30, 40]
    assert {a for s, a in zip(acts["species"], acts["action"], strict=True) if s == "ram"} == {
        f"{g}.{a}" for g, a in nerves.actions
    }
    assert all(n <= of for n, of in zip(acts["n"], acts["of"], strict=True))


def test_individuals_have_a_row_for_a_tick_in_which_some_learn_and_keep_one_report(menagerie):
    changes = {"species": {"ram": {"policy": {"kind": "individual"}}}}
    world = World.from_config(menagerie(**changes), seed=3, policies="untrained", learn=True)
    world.run(60)
    table = world.recorder.learning_series()
    assert len(table) > 1
    assert len(world.tables["ram"].species.nerves.reports) == 1
    assert min(table["n_learners"].to_pylist()) >= 1


def test_nothing_is_recorded_of_species_without_nerves(menagerie):
    world = World.from_config(menagerie(), policies="untrained")
    assert "moss" not in LearningPages(world, world.recorder.names).thinking


@pytest.mark.slow
def test_a_resumed_run_has_the_rows_of_one_that_went_on_and_recording_changes_nothing(menagerie, tmp_path):
    options = {"seed": 7, "policies": "untrained", "learn": True, "report": False}
    whole = run_to_folder(menagerie(), ticks=60, out=tmp_path / "whole", **options)
    run_to_folder(menagerie(), ticks=35, out=tmp_path / "half", **options)
    resumed = resume(tmp_path / "half", 60, report=False)
    for kind in ("learning", "actions"):
        one, two = (read_parts(tmp_path / name / kind) for name in ("whole", "half"))
        assert [c.to_pylist() for c in one.columns] == [c.to_pylist() for c in two.columns], kind
    assert whole["digest"] == resumed["digest"]
    bare = World.from_config(menagerie(), seed=7, policies="untrained", learn=True, record=False)
    bare.run(60)
    assert bare.digest() == whole["digest"]
    part = tmp_path / "whole" / "learning" / "part-00000.parquet"
    assert pq.read_schema(part).names[:2] == ["tick", "species"]


def test_what_is_in_memory_is_in_checkpoints(menagerie, tmp_path):
    world = World.from_config(menagerie(), seed=7, policies="untrained", learn=True)
    world.run(30)
    world.save(tmp_path / "w.safetensors")
    later = World.restore(tmp_path / "w.safetensors")
    for each in (world, later):
        each.run(20)
    assert later.recorder.action_series().equals(world.recorder.action_series())
    assert later.recorder.learning_series().equals(world.recorder.learning_series())
