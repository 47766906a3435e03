"""What pages ask for: as in a world file, and recorded, repeated, resumed and forked with the run."""

import json

import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.config.loading import changed
from ecs_eco.config.mutable_keys import refused
from ecs_eco.engine.errors import CheckpointError, ConfigError
from ecs_eco.engine.system import System
from ecs_eco.record import fork, resume, run_to_folder
from ecs_eco.runs.repeat import repeat, repeatable
from ecs_eco.runs.run import Stopped
from ecs_eco.view.live import Live
from ecs_eco.view.watch import Window
from tests.view.parks import ACTS, SMALL, Page, small, watched


def test_what_pages_do_is_the_same_in_a_world_file():
    seen = small()
    watched(seen, 20, ACTS)
    # each at the start of the tick that was to come
    assert [tick for tick, _ in seen.intervened] == list(ACTS)
    file = load(
        "predator-prey", SMALL | {"interventions": [{"at": tick, **what} for tick, what in ACTS.items()]}
    )
    again = World.from_config(file, seed=5, policies="random", record=False).run(20)
    assert seen.digest() == again.digest()
    assert seen.digest() != small().run(20).digest()


def acting(acts, dies=None):
    """Somebody who acts before these ticks, until the power fails."""

    def prepare(world):
        def between():
            if world.tick == dies:
                raise RuntimeError("the power failed")
            if world.tick in acts:
                world.intervene(acts[world.tick])

        world.before_tick.append(between)

    return prepare


def test_what_was_asked_for_after_the_last_checkpoint_of_a_run_that_died_is_done_again(tmp_path):
    config = load("predator-prey", SMALL)
    whole = run_to_folder(config, 5, 20, tmp_path / "whole", "random", prepare=acting(ACTS), report=False)
    with pytest.raises(RuntimeError, match="the power failed"):
        run_to_folder(
            config,
            5,
            20,
            tmp_path / "run",
            "random",
            prepare=acting(ACTS, dies=11),
            checkpoint_every=6,
            report=False,
        )
    # before the last of them: without it
    fork(tmp_path / "run", tmp_path / "fork", from_tick=10, until=20, report=False)
    # whoever asks again for what is done again, once
    manifest = resume(tmp_path / "run", 20, report=False, prepare=acting(ACTS))
    assert [tick for tick, _ in manifest["intervened"]] == list(ACTS)
    assert [tick for tick, _ in manifest["asked"]] == list(ACTS)
    assert manifest["digest"] == whole["digest"]
    earlier = acting({tick: act for tick, act in ACTS.items() if tick < 12})
    without = run_to_folder(config, 5, 20, tmp_path / "without", "random", prepare=earlier, report=False)
    assert json.loads((tmp_path / "fork" / "manifest.json").read_text())["digest"] == without["digest"]
    assert repeat(tmp_path / "run")["same"]


def test_what_waits_when_a_run_stops_is_done_once_when_it_goes_on(tmp_path):
    def prepare(world):
        def between():
            if world.tick == 6:
                world.intervene(ACTS[3])
                world.intervene(ACTS[3])  # twice, as asked
                world.stop()

        world.before_tick.append(between)

    with pytest.raises(Stopped):
        run_to_folder(
            load("predator-prey", SMALL), 5, 12, tmp_path / "run", "random", prepare=prepare, report=False
        )
    manifest = resume(tmp_path / "run", 12, report=False)
    assert [tick for tick, _ in manifest["intervened"]] == [6, 6]
    assert [tick for tick, _ in manifest["asked"]] == [6, 6]
    assert repeat(tmp_path / "run")["same"]


def test_a_fork_leaves_out_what_was_asked_for_in_its_first_tick_however_its_parent_ended(tmp_path):
    config, act = load("predator-prey", SMALL), {6: ACTS[3]}
    run_to_folder(
        config, 5, 9, tmp_path / "whole", "random", prepare=acting(act), checkpoint_every=6, report=False
    )

    def stops(world):
        acting(act)(world)
        world.before_tick.append(lambda: world.stop() if world.tick == 6 else None)

    with pytest.raises(Stopped):
        run_to_folder(config, 5, 9, tmp_path / "stopped", "random", prepare=stops, report=False)
    forks = [
        fork(tmp_path / name, tmp_path / f"fork-{name}", 6, until=9, report=False)
        for name in ("whole", "stopped")
    ]
    assert forks[0]["digest"] == forks[1]["digest"]
    assert forks[0]["intervened"] == forks[1]["intervened"] == []


class Asks(System):
    """Asks for a cull in the middle of tick 3."""

    phase = "interact"

    def process(self, *_):
        if self.world.tick == 3:
            self.world.intervene(ACTS[3])


def test_what_a_system_asks_for_waits_in_a_checkpoint(tmp_path):
    config = load("predator-prey", SMALL, systems=[Asks()])
    world = World.from_config(config, seed=5, policies="random", record=False).run(4)
    world.save(tmp_path / "world.ckpt")
    other = World.restore(tmp_path / "world.ckpt", systems=[Asks()], record=False).run(2)
    assert [tick for tick, _ in other.intervened] == [4]
    assert other.digest() == world.run(2).digest()


def test_a_fork_that_lost_its_checkpoints_does_not_begin_anew(tmp_path):
    run_to_folder(load("predator-prey", SMALL), 5, 4, tmp_path / "run", "random", report=False)
    fork(tmp_path / "run", tmp_path / "fork", until=6, report=False)
    for file in (tmp_path / "fork" / "checkpoints").iterdir():
        file.unlink()
    with pytest.raises(CheckpointError, match="fork that run again"):
        resume(tmp_path / "fork", 8, report=False)


def test_a_run_that_goes_on_is_watched_and_what_is_done_then_is_repeated_too(tmp_path):
    run_to_folder(load("predator-prey", SMALL), 5, 4, tmp_path / "run", "random", report=False)
    acts = {tick: act for tick, act in ACTS.items() if tick > 4}
    window = Window(20, lambda address: None)

    def prepare(world):
        window.open(world)
        window.player.playing = False
        Page(window.player, acts)

    with window:
        manifest = resume(tmp_path / "run", 20, report=False, prepare=prepare)
    assert [tick for tick, _ in manifest["intervened"]] == list(acts)
    assert repeat(tmp_path / "run")["same"]


def test_a_recorded_run_with_acts_is_repeated_to_the_same_digest(tmp_path):
    pages = []
    window = Window(20, lambda address: None)

    def prepare(world):
        window.open(world)
        window.player.playing = False
        pages.append(Page(window.player, ACTS))

    with window:
        config = load("predator-prey", SMALL)
        manifest = run_to_folder(config, 5, 20, tmp_path / "run", "random", prepare=prepare, report=False)
    assert manifest["finished"]
    assert [tick for tick, _ in manifest["intervened"]] == list(ACTS)
    repetition = repeat(tmp_path / "run")
    assert repetition["same"]
    assert repetition["interventions"] == 5
    assert load(repeatable(manifest)).interventions[1].at == 5
    assert repeat(tmp_path / "run", tmp_path / "again")["same"]
    other = repeatable(manifest)
    other["interventions"][0]["at"] += 1
    assert World.from_config(load(other), seed=5, policies="random").run(20).digest() != manifest["digest"]


def test_acts_that_are_wrong_are_refused_in_the_words_of_the_world_file():
    live = Live(small())
    (answer,) = live.handle({"kind": "act", "what": {"kind": "cull", "species": "dear", "share": 0.5}})
    assert answer["level"] == "error"
    assert answer["field"] == "species"
    assert 'did you mean "deer"?' in answer["text"]
    for what in (
        None,
        [],
        "cull",
        {},
        {"kind": "burn"},
        {"kind": "cull", "species": "deer", "share": 2.0},
        {"kind": "add", "at": 7},
    ):
        (answer,) = live.handle({"kind": "act", "what": what})
        assert answer["level"] == "error"
        assert answer["text"]
    live.world.run(2)
    assert live.world.intervened == []


def test_two_changes_while_the_world_waits_must_fit_each_other():
    live = Live(small())
    live.handle({"kind": "act", "what": {"kind": "set", "set": {"species.deer.reproduction.rate": 0.0}}})
    (answer,) = live.handle(
        {"kind": "act", "what": {"kind": "set", "set": {"species.deer.metabolism.basal": 0.5}}}
    )
    assert answer["level"] == "info"
    (answer,) = live.handle(
        {"kind": "act", "what": {"kind": "set", "set": {"species.deer.metabolism.basal": -1.0}}}
    )
    assert answer["level"] == "error"
    live.world.run(1)
    deer = live.world.config.species["deer"]
    assert (deer.metabolism.basal, deer.reproduction.rate) == (0.5, 0.0)
    assert len(live.world.intervened) == 2


def objection(config, key, new):
    """What is said against another value in a living world."""
    try:
        return " ".join(map(str, refused(config, changed(config, {key: new}))))
    except ConfigError as error:
        return str(error)  # a value that would be wrong in a file too


def test_listed_values_are_those_that_may_change():
    config = load("predator-prey", SMALL)
    live = Live(World.from_config(config, policies="random", record=False))
    (message,) = live.handle({"kind": "params"})
    listed = {p["key"]: p for p in message["list"]}
    basal = listed["species.deer.metabolism.basal"]
    assert (basal["value"], basal["unit"], basal["low"], basal["high"]) == (0.004, "energy/s", 0.0, None)
    assert basal["about"] == "basal metabolic rate"
    assert listed["species.deer.diet.0.chance"]["high"] == 1
    assert not {k for k in listed if k.endswith(".count") or k.startswith(("space", "training", "seed"))}
    for key in list(listed)[::7]:  # a sample: each of them may really be set
        value = listed[key]["value"]
        new = (
            (not value)
            if isinstance(value, bool)
            else value * 1.01
            if isinstance(value, float)
            else value + 1
        )
        assert "cannot change" not in objection(config, key, new), key
