"""A recorded run tells births, deaths and its story as a living one does."""

import numpy as np
import pytest

from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.view.recording import Recording
from ecs_eco.view.replay import Replay
from tests.view.parks import SMALL


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A park from which all wolves are taken before tick 6."""
    out = tmp_path_factory.mktemp("told") / "run"
    cull = {"kind": "cull", "species": "wolf", "share": 1.0, "at": 6}
    run_to_folder(load("predator-prey", SMALL | {"interventions": [cull]}), seed=5, ticks=20, out=out,
                  policies="random", report=False)
    return out


def test_births_and_deaths_a_tick_account_for_the_numbers(folder):
    series = Replay(folder).series(-1)
    for name in ("grass", "deer", "wolf"):
        births, deaths = (np.array(series[kind][name][1:]) for kind in ("births", "deaths"))
        assert (np.diff(series["n"][name]) == births - deaths).all()
        by_cause = np.sum([line[1:] for line in series["causes"][name].values()] or [deaths * 0], axis=0)
        assert (by_cause == deaths).all()


def test_energy_taken_in_and_burnt_is_that_of_the_series(folder):
    replay = Replay(folder)
    energy, ticks = replay.series(-1)["energy"], replay.series(-1)["tick"]
    columns = replay.recording.series.between(0, 19, ("tick", "species", "taken_in", "burnt"))
    deer = columns["species"] == replay.recording.species.index("deer")
    assert columns["tick"][deer].tolist() == ticks
    assert energy["deer"]["burnt"] == pytest.approx(columns["burnt"][deer].tolist(), rel=1e-4)
    assert energy["deer"]["taken in"] == pytest.approx(columns["taken_in"][deer].tolist(), rel=1e-4)
    assert max(energy["deer"]["burnt"]) > 0


def test_the_story_of_a_record_has_its_extinction_and_its_account(folder):
    replay = Replay(folder)
    (story,) = [message for message in replay.greeting() if message["kind"] == "story"]
    gone = [entry for entry in story["entries"] if entry["kind"] == "extinct"]
    assert [(entry["species"], entry["tick"]) for entry in gone] == [("wolf", 6)]
    n = {tick: Recording(folder).numbers(tick)["wolf"] for tick in (5, 6)}
    assert n[5] > n[6] == 0
    (why,) = replay.handle({"kind": "why"})
    assert any("wolf died out at tick 6" in line for line in why["sections"]["What happened"])


def test_an_organism_of_a_record_has_a_sentence(folder):
    replay = Replay(folder)
    assert replay.organism(310)["sentence"].startswith("Deer, ")
