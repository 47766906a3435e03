"""Stretches of a recorded run of which more is known."""

import pytest

from ecs_eco.record import resume, run_to_folder
from ecs_eco.view.recording import Recording
from ecs_eco.view.replay import Replay
from ecs_eco.view.rerun import Stretch, spans, stretches


@pytest.fixture
def run(menagerie, tmp_path):
    def made(**options):
        return run_to_folder(
            menagerie(), ticks=12, out=tmp_path / "run", seed=7, policies="random", report=False, **options
        )

    made.folder = tmp_path / "run"
    return made


def told(kind, first, last, species, n=None, wrong=None):
    return {"kind": kind, "first": first, "last": last, "species": species, "n": n, "wrong": wrong}


def test_without_details_there_is_none(run):
    run()
    assert Replay(run.folder).greeting()[0]["stretches"] == []


@pytest.mark.parametrize(("record", "kind", "n"), [("full", "full", None), ("focal=2", "focal", 2)])
def test_marks_say_which_ticks_were_recorded_in_detail_and_of_whom(run, record, kind, n):
    run(record=record)
    marks = Replay(run.folder).greeting()[0]
    assert marks["stretches"] == [told(kind, 0, 11, ["ram", "lynx"], n)]


def test_parts_that_follow_each_other_are_one_stretch(run):
    run(record="focal=2", checkpoint_every=5, keep=3)
    resume(run.folder, 20, report=False)
    recording = Recording(run.folder)
    assert len(recording.details["ram"].groups) > 1
    assert spans(recording, "ram") == [(0, recording.last)]


def test_what_was_run_again_is_told_with_where_it_differs(run):
    run(record="focal=2")
    again = Stretch(3, 8, {}, {}, 5)
    assert stretches(Recording(run.folder), [again])[1:] == [told("filled", 3, 8, [], wrong=5)]
