"""A recorded run tells births, deaths and its story as a living one does."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.analysis.extinction import declines
from ecs_eco.analysis.runs import load_series
from ecs_eco.config import load
from ecs_eco.record import run_to_folder
from ecs_eco.view.curves import DEPTH
from ecs_eco.view.live import Live
from ecs_eco.view.recording import Recording
from ecs_eco.view.replay import Replay
from tests.view.parks import SMALL

HALF = "the last with at least half of the peak"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A park from which all wolves are taken before tick 6."""
    out = tmp_path_factory.mktemp("told") / "run"
    cull = {"kind": "cull", "species": "wolf", "share": 1.0, "at": 6}
    run_to_folder(
        load("predator-prey", SMALL | {"interventions": [cull]}),
        seed=5,
        ticks=20,
        out=out,
        policies="random",
        report=False,
    )
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


def test_depths_of_a_record_and_of_a_living_world_are_heights_below_the_surface(tmp_path):
    few = {"species.phytoplankton.count": 60, "species.copepod.count": 20, "species.krill.count": 3}
    config = load("diel-migration", few)
    run_to_folder(config, seed=2, ticks=12, out=tmp_path / "run", policies="random", report=False)
    recorded = Replay(tmp_path / "run").series(-1)["reports"][DEPTH]
    live = Live(World.from_config(config, seed=2, policies="random"))
    for _ in range(12):
        live.world.run(1)
        live.passed()
        live.sample()
    said = live.series(-1)["reports"][DEPTH]
    assert said.keys() == recorded.keys() == {"copepod", "krill"}  # what drifts has no depth of its own
    assert said["krill"][1:] == pytest.approx(recorded["krill"][1:], rel=1e-3)
    assert -30 < min(said["copepod"][1:]) <= max(said["copepod"][1:]) < 0


def test_the_story_of_a_record_has_its_extinction_and_its_account(folder):
    replay = Replay(folder)
    (story,) = [message for message in replay.greeting() if message["kind"] == "story"]
    gone = [entry for entry in story["entries"] if entry["kind"] == "extinct"]
    assert [(entry["species"], entry["tick"]) for entry in gone] == [("wolf", 6)]
    n = {tick: Recording(folder).numbers(tick)["wolf"] for tick in (5, 6)}
    assert n[5] > n[6] == 0
    (why,) = replay.handle({"kind": "why"})
    assert any("wolf died out at tick 6" in line for line in why["sections"]["What happened"])


def test_an_extinction_has_the_same_numbers_in_the_story_the_account_and_reports(tmp_path):
    culls = [
        {"kind": "cull", "species": "wolf", "share": share, "at": at}
        for share, at in ((0.6, 9), (0.5, 23), (1.0, 31))
    ]
    starving = {"species.wolf.metabolism.energy": 0.4, "species.wolf.metabolism.basal": 0.02}
    config = load("predator-prey", SMALL | starving | {"interventions": culls})
    run_to_folder(config, 7, 40, tmp_path / "run", "random", report=False)
    (end,) = [d for d in declines(load_series(tmp_path / "run")) if d.species == "wolf"]
    assert end.since > 0
    assert len(end.causes) > 1
    shares = ", ".join(f"{n / end.deaths:.0%} {cause}" for cause, n in end.causes.items())
    replay, live = Replay(tmp_path / "run"), Live(World.from_config(config, seed=7, policies="random"))
    for _ in range(41):
        live.passed()
        live.world.run(1)
    for source in (replay, live):
        (story,) = [message for message in source.greeting() if message["kind"] == "story"]
        (entry,) = [e for e in story["entries"] if e["kind"] == "extinct" and e["species"] == "wolf"]
        text = f"Deaths since tick {end.since} ({HALF}): {end.deaths} ({shares}). Births: {end.births}."
        assert entry["cause"].startswith(text)
        (why,) = source.handle({"kind": "why"})
        told = " ".join(why["sections"]["What happened"])
        assert f"wolf died out at tick {end.tick}; at tick {end.since} ({HALF}) there were {end.n}." in told
        assert f"Deaths since then: {end.deaths} ({shares}). Births: {end.births}." in told


def test_an_organism_of_a_record_has_a_sentence(folder):
    replay = Replay(folder)
    assert replay.organism(1)["sentence"].startswith("Deer, ")
