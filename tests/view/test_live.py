"""A living world to be watched: what it says of itself, and that watching changes nothing."""

import base64
import json
import struct

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Genome, Metabolism, Position
from ecs_eco.config import load
from ecs_eco.config.loading import changed
from ecs_eco.config.mutable_keys import refused
from ecs_eco.engine.errors import CheckpointError, ConfigError
from ecs_eco.engine.system import System
from ecs_eco.record import fork, resume, run_to_folder
from ecs_eco.runs.repeat import repeat, repeatable
from ecs_eco.runs.run import Stopped
from ecs_eco.view.live import Live
from ecs_eco.view.player import Player
from ecs_eco.view.watch import Window

SMALL = {"species.grass.count": 300, "species.deer.count": 60, "species.wolf.count": 12}
ACTS = {  # by the tick before which they are asked for
    3: {"kind": "cull", "species": "deer", "share": 0.5},
    5: {"kind": "add", "species": "wolf", "count": 4, "at_place": [60, 60]},
    8: {"kind": "set", "set": {"species.deer.metabolism.basal": 0.01}},
    9: {"kind": "fence", "region": [20, 20, 100, 100]},
    12: {"kind": "switch", "species": "deer", "reproduction": False},
}


def small(policies="random", **options):
    return World.from_config(load("predator-prey", SMALL), seed=5, policies=policies, record=False, **options)


class Page:
    """Reads all it gets; looks at everything: colours, panels,
    acts. Asks for one step at each tick that it sees."""

    def __init__(self, player, acts=None):
        self.player, self.acts, self.frames, self.said, self.ticks = player, dict(acts or {}), [], [], []
        player.say(self, {"kind": "join"})
        player.say(self, {"kind": "params"})

    def send(self, messages):
        for message in messages:
            if isinstance(message, bytes):
                self.frames.append(message)
                number, tick = struct.unpack_from("<II", message, 4)
                self.player.say(self, {"kind": "ack", "frame": number})
                self.player.say(self, {"kind": "colour",
                                       "by": ("species", "energy", "happiness", "age")[number % 4]})
                self.player.say(self, {"kind": "select", "uid": 310})
                if tick in self.acts:
                    self.player.say(self, {"kind": "act", "what": self.acts.pop(tick)})
                if tick not in self.ticks:  # where time is short, a tick is seen in its new colour too
                    self.ticks.append(tick)
                    self.player.say(self, {"kind": "step"})
            else:
                self.said.append(json.loads(message))

    def got(self, kind):
        return [m for m in self.said if m["kind"] == kind]


def watched(world, ticks, acts=None):
    """Let a world live in front of a page that steps through it, acting on its way."""
    player = Player(Live(world, ticks), playing=False)
    page = Page(player, acts)
    player.halted = (lambda: world.tick >= ticks and bool(page.frames)
                     and struct.unpack_from("<I", page.frames[-1], 8)[0] == ticks)
    player.source.run(player.turn)
    return page


@pytest.mark.parametrize("policies", ["random", "untrained"])
def test_a_watched_world_is_the_same_to_the_byte(policies):
    alone, seen = small(policies).run(15), small(policies)
    page = watched(seen, 15)
    assert page.ticks == list(range(16))
    assert seen.digest() == alone.digest()
    assert seen.before_tick == []


def test_what_the_user_calls_before_ticks_is_called_while_a_page_watches_and_stays():
    seen, ticks = small(), []
    seen.before_tick.append(lambda: ticks.append(seen.tick))
    watched(seen, 5)
    assert ticks[:5] == [0, 1, 2, 3, 4]
    assert len(seen.before_tick) == 1


def test_what_pages_do_is_the_same_in_a_world_file():
    seen = small()
    watched(seen, 20, ACTS)
    # each at the start of the tick that was to come
    assert [tick for tick, _ in seen.intervened] == list(ACTS)
    file = load("predator-prey",
                SMALL | {"interventions": [{"at": tick, **what} for tick, what in ACTS.items()]})
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
        run_to_folder(config, 5, 20, tmp_path / "run", "random", prepare=acting(ACTS, dies=11),
                      checkpoint_every=6, report=False)
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
        run_to_folder(load("predator-prey", SMALL), 5, 12, tmp_path / "run", "random", prepare=prepare,
                      report=False)
    manifest = resume(tmp_path / "run", 12, report=False)
    assert [tick for tick, _ in manifest["intervened"]] == [6, 6]
    assert [tick for tick, _ in manifest["asked"]] == [6, 6]
    assert repeat(tmp_path / "run")["same"]


def test_a_fork_leaves_out_what_was_asked_for_in_its_first_tick_however_its_parent_ended(tmp_path):
    config, act = load("predator-prey", SMALL), {6: ACTS[3]}
    run_to_folder(config, 5, 9, tmp_path / "whole", "random", prepare=acting(act), checkpoint_every=6,
                  report=False)

    def stops(world):
        acting(act)(world)
        world.before_tick.append(lambda: world.stop() if world.tick == 6 else None)

    with pytest.raises(Stopped):
        run_to_folder(config, 5, 9, tmp_path / "stopped", "random", prepare=stops, report=False)
    forks = [fork(tmp_path / name, tmp_path / f"fork-{name}", 6, until=9, report=False)
             for name in ("whole", "stopped")]
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
    with pytest.raises(CheckpointError, match="fork that one again"):
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
    for what in (None, [], "cull", {}, {"kind": "burn"}, {"kind": "cull", "species": "deer", "share": 2.0},
                 {"kind": "add", "at": 7}):
        (answer,) = live.handle({"kind": "act", "what": what})
        assert answer["level"] == "error"
        assert answer["text"]
    live.world.run(2)
    assert live.world.intervened == []


def test_two_changes_while_the_world_waits_must_fit_each_other():
    live = Live(small())
    live.handle({"kind": "act", "what": {"kind": "set", "set": {"species.deer.reproduction.rate": 0.0}}})
    (answer,) = live.handle({"kind": "act",
                             "what": {"kind": "set", "set": {"species.deer.metabolism.basal": 0.5}}})
    assert answer["level"] == "info"
    (answer,) = live.handle({"kind": "act",
                             "what": {"kind": "set", "set": {"species.deer.metabolism.basal": -1.0}}})
    assert answer["level"] == "error"
    live.world.run(1)
    deer = live.world.config.species["deer"]
    assert (deer.metabolism.basal, deer.reproduction.rate) == (0.5, 0.0)
    assert len(live.world.intervened) == 2


def test_hello_says_who_lives_where():
    live = Live(small())
    hello = live.hello()
    assert hello["mode"] == "live"
    assert hello["size"] == [240.0, 240.0]
    assert [s["name"] for s in hello["species"]] == ["grass", "deer", "wolf"]
    assert [s["moves"] for s in hello["species"]] == [False, True, True]
    assert hello["colours"] == ["species", "energy", "happiness", "age"]
    assert hello["terrain"] is None
    json.dumps(hello, allow_nan=False)
    assert live.counts() == {"grass": 300, "deer": 60, "wolf": 12}


def test_without_a_sun_there_are_no_days_and_the_light_is_ambient():
    live = Live(small())
    assert live.hello()["day"] is None
    live.world.ambient["light"] = 0.5
    assert struct.unpack_from("<2f", live.frame(1, "species"), 16) == pytest.approx((0.5, np.pi / 6))


@pytest.mark.parametrize(("kind", "start", "light", "elevation"), [
    ("natural", 0.5, 1.0, 90), ("natural", 0.75, 0.0, 0), ("natural", 0.0, 0.0, -90),
    ("inverted", 0.0, 1.0, 90), ("inverted", 0.5, 0.0, -90),
])  # fmt: skip
def test_the_sun_stands_where_the_hour_says(kind, start, light, elevation):
    sun = {"kind": kind, "day": 100.0, "start": start}
    live = Live(World.from_config(load("predator-prey", SMALL | {"sun": sun}), seed=5, policies="random",
                                  record=False))
    assert live.hello()["day"] == {"length": 100.0, "start": (start + 0.5 * (kind == "inverted")) % 1}
    assert struct.unpack_from("<2f", live.frame(1, "species"),
                              16) == pytest.approx((light, np.radians(elevation)), abs=1e-6)
    live.world.tick += 50  # half a day later
    assert live.world.time == 50.0
    assert struct.unpack_from("<2f", live.frame(2, "species"),
                              16)[1] == pytest.approx(np.radians(-elevation), abs=1e-6)


def test_a_sun_that_never_moves_makes_no_days():
    live = Live(World.from_config(load("predator-prey", SMALL | {"sun": {"kind": "constant"}}),
                                  policies="random", record=False))
    assert live.hello()["day"] is None
    light, elevation = struct.unpack_from("<2f", live.frame(1, "species"), 16)
    assert light == pytest.approx(1 / np.pi)  # the mean over a day at the equator
    assert np.sin(elevation) == pytest.approx(light)


def test_another_day_is_told_once_it_is_another():
    live = Live(World.from_config(load("predator-prey", SMALL | {"sun": {"day": 100.0, "start": 0.5}}),
                                  policies="random", record=False))
    live.handle({"kind": "act", "what": {"kind": "set", "set": {"sun.start": 0.0}}})
    live.world.run(1)
    assert live.hello()["day"] == {"length": 100.0, "start": 0.0}


def test_the_ground_is_sent_with_its_landmarks_and_large_ones_coarser():
    ground = {"cell": 0.5, "hills": {"amplitude": 3.0, "scale": 30.0},
              "rocks": [{"at": [10.0, 10.0], "radius": 2.0}]}
    live = Live(World.from_config(load("predator-prey", SMALL | {"terrain": ground}), policies="random",
                                  record=False))
    hello = live.hello()
    terrain = hello["terrain"]
    heights = np.frombuffer(base64.b64decode(terrain["heights"]), "<f4").reshape(terrain["ny"], terrain["nx"])
    assert heights.size <= 65_536
    assert terrain["cell"] * terrain["nx"] == pytest.approx(240)
    assert 1 < np.abs(heights).max() < 20
    assert terrain["rocks"][0]["radius"] == 2.0
    assert hello["objects"] == []  # a rock of the ground is no object that comes with every frame


def test_a_frame_has_all_that_live_at_their_places():
    world = small()
    live = Live(world)
    world.run(3)
    frame = live.frame(1, "energy")
    counts = struct.unpack_from("<3I", frame, 28)
    assert counts == tuple(live.counts().values())
    at = 40 + 12 * counts[0]
    x, _, _, _, value, uid = struct.unpack_from("<HHHBBI", frame, at)
    table, row = world.locate(uid)
    assert table.name == "deer"
    assert x == pytest.approx(table[Position].x[row] / 240 * 65535, abs=0.6)
    energy = table[Metabolism].energy[row] / world.config.species["deer"].metabolism.energy_max
    assert value == pytest.approx(1 + 254 * min(energy, 1), abs=0.6)
    assert live.scales("energy")["deer"] == (0.0, 1.0)
    assert live.scales("age") == {}


def test_genes_have_colours_and_curves():
    world = World.from_config("reflexes", policies="random", record=False)
    live = Live(world)
    genes = [c for c in live.hello()["colours"] if c.startswith("gene:")]
    assert genes
    name, code = next((n, next(iter(found.values()))) for n, found in live._genes.items() if found)
    live.frame(1, f"gene:{code.name}")
    assert live.scales(f"gene:{code.name}")[name] == pytest.approx((code.low, code.high))
    live.sample()
    mean = live.series(-1)["genes"][f"{name}.{code.name}"][0]
    table = world.tables[name]
    decoded = table.species.heredity.layout.decode(table[Genome].loci[table.rows()], [code.name])[code.name]
    assert mean == pytest.approx(float(decoded.mean()), rel=1e-4)


def test_a_world_made_by_hand_can_be_watched():
    world = World([10.0, 10.0])
    world.add_table("mite", Position, Metabolism)
    world.spawn("mite", Position(x=5.0, y=2.0), n=3)
    world.flush()
    page = watched(world, 2)
    assert struct.unpack_from("<I", page.frames[0], 28) == (3,)
    assert page.got("params") == [{"kind": "params", "list": []}]
    (answer,) = Live(world).handle({"kind": "act", "what": {"kind": "cull", "species": "mite", "count": 1}})
    assert "no system that intervenes" in answer["text"]


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
    found = {p["key"]: p for p in message["list"]}
    basal = found["species.deer.metabolism.basal"]
    assert (basal["value"], basal["unit"], basal["low"], basal["high"]) == (0.004, "energy/s", 0.0, None)
    assert basal["about"] == "energy burnt by living"
    assert found["species.deer.diet.0.chance"]["high"] == 1
    assert not {k for k in found if k.endswith(".count") or k.startswith(("space", "training", "seed"))}
    for key in list(found)[::7]:  # a sample: each of them may really be set
        value = found[key]["value"]
        new = ((not value) if isinstance(value, bool) else value * 1.01
               if isinstance(value, float) else value + 1)
        assert "cannot change" not in objection(config, key, new), key
