"""A living world is a recording in memory: both offer the same page at the same tick, field by field.

A recording shows the state at the end of a tick; the clock of a living world then stands at the next one, in the
light of that.
"""

import json

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.record import run_to_folder
from ecs_eco.record.parquet import read_parts
from ecs_eco.view.frames import HEADER, WORDS
from ecs_eco.view.live import Live
from ecs_eco.view.replay import Replay
from tests.view.ten_worlds import SLOW, WORLDS, small

TICKS, LOOKS = 26, (0, 9, 25)
OWN = {
    "mode",
    "first",
    "last",
    "tick",
    "acts",
    "rewinds",
    "stays",
    "snapshot_every",
    "note",
    "fields",
    "objects",
}
"""What a page is told of the kind of source; fields, and objects that come, go or move are not recorded."""


@pytest.fixture(
    scope="module", params=[pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in WORLDS]
)
def twins(request, tmp_path_factory):
    """What a page of a living world and one of its recording show at some ticks: by tick, a pair each."""
    config = small(request.param)
    out = tmp_path_factory.mktemp("twins") / "run"
    run_to_folder(
        config, seed=5, ticks=TICKS, out=out, policies="random", record="full", snapshot_every=1, report=False
    )
    live, replay = Live(World.from_config(config, seed=5, policies="random")), Replay(out)
    live.sample()  # as for a page that is open before the first tick
    seen, organisms = {}, sorted(read_parts(out / "births")["uid"].to_pylist())
    for tick in range(TICKS):
        live.passed()
        live.world.run(1)
        live.sample()
        if tick in LOOKS:
            live.passed()
            replay.handle({"kind": "seek", "tick": tick})
            uids = [uid for uid in organisms if uid < live.world.next_uid]
            uids = uids[:: max(1, len(uids) // 40)]
            seen[tick] = [json.loads(json.dumps(offered(source, uids))) for source in (live, replay)]
    return seen


def offered(source, uids):
    """All that a page may show, as JSON has it."""
    hello = source.hello()
    names, kin = [kind["name"] for kind in hello["species"]], uids[len(uids) // 2]
    return {
        "hello": {key: value for key, value in hello.items() if key not in OWN},
        "objects": [kind["name"] for kind in hello["objects"]],
        "marks": source.greeting()[0],
        "story": source.greeting()[1]["entries"],
        "counts": {name: n for name, n in source.counts().items() if name in names},
        "fates": sorted(source.fates(-1)),
        "frames": {
            colour: decoded(source, colour)[: len(names)] for colour in (*hello["colours"], f"kin:{kin}")
        },
        "series": source.series(-1),
        "organisms": {uid: source.organism(uid) for uid in uids},
        "trees": [source.handle({"kind": "tree", "uid": uid, "by": "family"}) for uid in uids],
        "tables": {name: source.handle({"kind": "table", "species": name})[0] for name in names},
        "scatter": source.handle({"kind": "scatter", "x": "energy", "y": "x"}),
        "why": source.handle({"kind": "why"})[0],
    }


def decoded(source, colour):
    """The organisms of a frame by kind, in the order of uids."""
    frame = source.frame(1, colour)
    *_, kinds = HEADER.unpack_from(frame)
    counts = np.frombuffer(frame, "<u4", kinds, HEADER.size)
    words = np.frombuffer(frame, "<u4", offset=HEADER.size + 4 * kinds).reshape(-1, WORDS)
    return [part[np.argsort(part[:, 2])].tolist() for part in np.split(words, counts.cumsum()[:-1])]


def test_who_and_what_there_is_is_the_same(twins):
    for live, replay in twins.values():
        for part in ("hello", "counts", "fates", "scatter"):
            assert live[part] == replay[part], part
        assert set(replay["objects"]) <= set(live["objects"])
        for land in ("interventions", "fences", "roads", "areas"):
            assert live["marks"][land] == replay["marks"][land]


def test_frames_are_the_same_in_all_colours(twins):
    for live, replay in twins.values():
        assert live["frames"].keys() == replay["frames"].keys()
        for colour, frame in live["frames"].items():
            if colour != "age":  # founders were there before the first tick; their record begins with it
                assert unsized(frame) == unsized(replay["frames"][colour]), colour


def unsized(frame):
    """A frame without the sizes of the young, which depend on their age: the lowest byte of the second word."""
    return [[[first, second & ~255, *more] for first, second, *more in rows] for rows in frame]


def test_tables_are_the_same(twins):
    for live, replay in twins.values():
        for name, table in live["tables"].items():
            ages, again = (shown["columns"].pop("age") for shown in (table, replay["tables"][name]))
            assert table == replay["tables"][name]
            assert ages == pytest.approx(again, abs=1.01 * live["hello"]["dt"])


def test_the_state_of_each_organism_is_the_same(twins):
    exact = ("uid", "species", "born", "alive", "parents", "generation", "genome")
    detailed = 0
    for tick, (live, replay) in twins.items():
        for uid, state in live["organisms"].items():
            again = replay["organisms"][uid]
            for part in exact[: len(exact) - (not state["alive"])]:  # a genome is forgotten with its bearer
                assert state[part] == again[part], (uid, part)
            assert set(state["children"]) <= set(again["children"])
            assert state["died"] == (
                again["died"] if again["died"] and again["died"]["tick"] <= tick else None
            )
            if state["alive"]:
                assert state["place"] == pytest.approx(again["place"])
                parts = ("energy", "energy_max", "heading")
                assert [state[p] for p in parts] == pytest.approx([again[p] for p in parts])
            if state["alive"] and state["nerves"]:
                detailed += 1
                assert state["nerves"] == again["nerves"]
                varied = "genome" in state and state["genome"]
                for channel, seen in state.get("channels", {}).items():
                    if not varied:
                        assert again["channels"][channel] == seen
                    else:  # the range may be a gene's, which is not recorded
                        assert again["channels"][channel].items() <= seen.items()
    assert detailed > 5


def test_trees_stories_and_accounts_are_the_same_in_the_end(twins):
    live, replay = twins[TICKS - 1]  # before, a recording knows what is to come
    assert live["trees"] == replay["trees"]
    assert live["story"] == replay["story"]
    for part in ("What happened", "Energy"):  # a living world has no snapshots, which tell what limited whom
        assert live["why"]["sections"].get(part) == replay["why"]["sections"].get(part)
    assert live["why"]["first"] == replay["why"]["first"]


def test_curves_are_the_same_in_the_end(twins):
    live, replay = (shown["series"] for shown in twins[TICKS - 1])
    assert [tick - 1 for tick in live.pop("tick")[1:]] == replay.pop(
        "tick"
    )  # a recording has no state before
    live.pop("light", None), replay.pop("light", None)  # at the next tick, and at this one
    lines, again = dict(curves(live)), dict(curves(replay))
    assert lines.keys() == again.keys()
    for name, values in lines.items():
        pairs = zip(values[1:], again[name], strict=True)
        known = [(a, b) for a, b in pairs if a is not None or b is not None]
        assert [a is None for a, _ in known] == [b is None for _, b in known], name
        assert [a for a, _ in known] == pytest.approx([b for _, b in known], rel=2e-3, abs=1e-5), name


def curves(message, name=()):
    """Each curve of a message "series" by its name."""
    for key, value in message.items():
        if isinstance(value, dict):
            yield from curves(value, (*name, key))
        elif isinstance(value, list):
            yield (*name, key), value
