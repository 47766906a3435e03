"""Who is watched and dies keeps its last state."""

import pytest

from ecs_eco.components import Metabolism
from ecs_eco.record.recorder import Recorder
from ecs_eco.view.live import Live
from tests.view.parks import small


@pytest.fixture
def live():
    return Live(small())


def starving(live, k=0):
    """The uid of a deer that dies in the next tick."""
    deer = live.world.tables["deer"]
    row = deer.by_uid()[k]
    deer[Metabolism].energy[row] = 1e-9
    return int(deer.uid[row])


def test_the_last_tick_of_one_that_is_watched_is_kept_as_full_details_have_it(live):
    world, details = live.world, []
    live.organism(int(world.tables["deer"].uid[world.tables["deer"].by_uid()[0]]))
    recorder = Recorder(
        world, lambda kind, columns: details.append((kind, columns)), snapshot_every=1, record="full"
    )
    world.run(3)
    uid = starving(live)
    live.organism(uid)
    before = live.organism(uid)
    world.run(2)
    recorder.flush()
    dead = live.organism(uid)
    assert (dead["alive"], dead["as_of"], dead["died"]["tick"], dead["died"]["cause"]) == (
        False,
        3,
        3,
        "starved",
    )
    assert (dead["species"], dead["sex"], dead["genome"]) == ("deer", before["sex"], before["genome"])
    assert dead["note"] == "State in its last tick, 3."
    rows = [
        {n: column[k] for n, column in columns.items()}
        for kind, columns in details
        if kind == "details-deer"
        for k in range(len(columns["uid"]))
        if columns["uid"][k] == uid
    ]
    assert [row["tick"] for row in rows] == [0, 1, 2, 3]
    last = rows[-1]
    assert dead["nerves"] != before["nerves"]
    for sensor in dead["nerves"]["sensors"]:
        assert sensor["value"] == pytest.approx(last[f"sensor: {sensor['name']}"], abs=1e-6)
    for act in dead["nerves"]["actions"]:
        assert act["decision"] == last[f"decision: {act['group']}.{act['name']}"]
    assert dead["place"][:2] == pytest.approx([last["x"], last["y"]], abs=1e-5)


def test_its_state_stays_the_same_as_time_goes_on(live):
    world = live.world
    world.run(2)
    uid = starving(live)
    live.organism(uid)
    world.run(1)
    dead = live.organism(uid)
    world.run(3)
    assert live.organism(uid) == dead
    assert dead["trace"]["tick"][-1] <= 2


def test_of_one_that_nobody_watched_only_its_record_is_known(live):
    live.world.run(2)
    uid = starving(live)
    live.world.run(1)
    dead = live.organism(uid)
    assert (dead["detail"], dead["nerves"], dead["alive"]) == ("record", None, False)


def test_who_lives_again_after_going_back_is_alive_and_dies_again_with_the_same_state(live):
    world = live.world
    live.ring.look()
    while not (died := [uid for uid in live._traces if live.genealogy.died(uid)]):
        for uid in world.tables["deer"].uid[world.tables["deer"].rows()].tolist()[:1]:
            live.organism(uid)
            live.world.intervene({"kind": "cull", "species": "deer", "uids": [uid], "cause": "removed"})
            live.ring.acts.append(
                (world.tick, {"kind": "cull", "species": "deer", "uids": [uid], "cause": "removed"})
            )
        world.run(1)
    then = live.organism(died[0])
    tick = world.tick
    live.handle({"kind": "seek", "tick": 0})
    assert live.organism(died[0])["alive"]
    assert "as_of" not in live.organism(died[0])
    world.intervene({"kind": "cull", "species": "deer", "uids": [died[0]], "cause": "removed"})
    world.run(tick)
    again = live.organism(died[0])
    assert (again["died"], again["nerves"], again["place"]) == (then["died"], then["nerves"], then["place"])


def test_watching_who_dies_changes_nothing():
    worlds = [small(), small()]
    live = Live(worlds[0])
    for tick in range(25):
        deer = worlds[0].tables["deer"]
        for uid in deer.uid[deer.rows()][:8].tolist():
            live.organism(uid)
        for world in worlds:
            if tick == 12:
                world.intervene({"kind": "cull", "species": "deer", "share": 0.5})
            world.run(1)
    assert worlds[0].digest() == worlds[1].digest()
    assert live.last_states
