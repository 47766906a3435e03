import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.analysis.lineage import Lineage
from ecs_eco.components import Position
from ecs_eco.engine.errors import RecordingError
from ecs_eco.record import fork, run_to_folder
from ecs_eco.record.recorder import Recorder
from ecs_eco.view.genealogy import Genealogy
from ecs_eco.view.interpolate import STATE, Chapter
from ecs_eco.view.parts import Cache
from ecs_eco.view.recording import Recording

TICKS, EVERY = 60, 7
SPECIES = ("moss", "ram", "lynx")


@pytest.fixture(scope="session")
def run(menagerie, tmp_path_factory):
    """A recorded run, and where everybody was at the end of each of its ticks."""
    out = tmp_path_factory.mktemp("recorded") / "run"
    run_to_folder(
        menagerie(),
        seed=7,
        ticks=TICKS,
        out=out,
        policies="untrained",
        learn=True,
        report=False,
        snapshot_every=EVERY,
        checkpoint_every=20,
        record="focal=5",
    )
    world, truth = World.from_config(menagerie(), seed=7, policies="untrained", learn=True, record=False), []
    Recorder(world)
    for _ in range(TICKS):
        world.run(1)
        tables = {name: world.tables[name] for name in SPECIES}
        truth.append(
            {
                n: (t.uid[r := t.by_uid()].copy(), t[Position].x[r], t[Position].y[r])
                for n, t in tables.items()
            }
        )
    return out, truth


@pytest.fixture
def recording(run):
    return Recording(run[0])


def test_who_is_there_is_exact_at_every_tick(recording, run):
    assert (recording.first, recording.last) == (0, TICKS - 1)
    for tick in [*range(TICKS), 3, 58, 20]:
        for name in SPECIES:
            assert recording.organisms(tick, name).uid.tolist() == run[1][tick][name][0].tolist()


def test_places_are_those_of_the_snapshots_and_near_in_between(recording, run):
    for tick in range(TICKS):
        for name in SPECIES:
            crowd, (_, x, y) = recording.organisms(tick, name), run[1][tick][name]
            if tick % EVERY == 0:
                assert (crowd.x.tolist(), crowd.y.tolist()) == (x.tolist(), y.tolist())
            # nobody runs faster than 2.5 m a tick, or is pushed farther
            assert np.abs(crowd.x - x).max(initial=0) < 2 * 2.5 * EVERY
    moss = [np.abs(recording.organisms(t, "moss").x - run[1][t]["moss"][1]).max() for t in range(TICKS)]
    assert max(moss) < 1e-5  # who does not move is where it was born


def test_those_in_the_focal_sample_are_exact_at_every_tick(recording, run):
    seen = 0
    for tick in range(TICKS):
        detail = recording.details["ram"].between(tick, tick, ("uid",))
        crowd, (uid, x, _) = recording.organisms(tick, "ram"), run[1][tick]["ram"]
        mine = np.isin(uid, detail["uid"])
        seen += mine.sum()
        assert crowd.x[mine].tolist() == x[mine].tolist()
        assert crowd.exact[mine].all()
    assert seen > 3 * TICKS


def test_numbers_are_those_of_the_series(recording, run):
    for tick in (0, 33, TICKS - 1):
        assert recording.numbers(tick) == {name: len(run[1][tick][name][0]) for name in SPECIES}
        assert [recording.curves["n"][name][tick] for name in SPECIES] == [
            len(run[1][tick][name][0]) for name in SPECIES
        ]


def test_bins_hold_all_births_and_deaths(recording):
    lineage = Lineage.read(recording.path)
    assert recording.curves["deaths"].sum() == (lineage.died >= 0).sum() == recording.deaths.rows > 5
    assert recording.curves["births"].sum() == len(lineage) - (150 + 40 + 8)  # those at the start


def test_lives_are_those_of_the_lineage(recording):
    lineage, genealogy = Lineage.read(recording.path), Genealogy(recording)
    assert recording.born(lineage.uid).tolist() == lineage.born.tolist()
    for i in range(0, len(lineage), 5):
        uid = int(lineage.uid[i])
        facts = genealogy.facts(uid)
        death = facts["died"]
        assert (facts["born"], facts["species"], [0, *facts["parents"]][-1]) == (
            lineage.born[i],
            lineage.species[i],
            lineage.parent[i],
        )
        assert (death or {"tick": -1, "cause": ""})["tick"] == lineage.died[i]
        assert (death or {"tick": -1, "cause": ""})["cause"] == lineage.cause[i]
        assert facts["children"] == lineage.uid[lineage.parent == uid].tolist()
        assert facts["generation"] == lineage.generation()[i]  # all have one parent at most
    assert genealogy.birth(10**9) is None


def test_a_fork_begins_where_it_was_forked(run, tmp_path):
    fork(run[0], tmp_path / "fork", from_tick=25, until=40, report=False)
    recording = Recording(tmp_path / "fork")
    assert (recording.first, recording.last) == (25, 39)
    for tick in range(25, 40):
        for name in SPECIES:
            assert recording.organisms(tick, name).uid.tolist() == run[1][tick][name][0].tolist()
    ram = recording.organisms(25, "ram")
    assert recording.born(ram.uid).max() <= 25
    assert recording.born(ram.uid).min() == 0


def test_a_run_in_which_all_die_out_is_shown_to_its_end(menagerie, tmp_path):
    config = menagerie(
        land_use=[],
        interventions=[{"kind": "cull", "at": 9, "species": name, "share": 1.0} for name in SPECIES],
    )
    config["species"]["moss"]["reproduction"] = None
    run_to_folder(
        config, seed=7, ticks=30, out=tmp_path / "run", policies="random", report=False, snapshot_every=4
    )
    recording = Recording(tmp_path / "run")
    assert [sum(recording.organisms(t, n).uid.size for n in SPECIES) > 0 for t in (0, 8, 9, 10, 29)] == [
        True,
        True,
        False,
        False,
        False,
    ]
    assert recording.numbers(29) == dict.fromkeys(SPECIES, 0)
    assert [i["tick"] for i in recording.interventions()] == [9, 9, 9]


def test_a_run_of_no_tick_is_refused(menagerie, tmp_path):
    run_to_folder(menagerie(), ticks=0, out=tmp_path / "run", policies="random", report=False)
    with pytest.raises(RecordingError, match="contains no recorded tick"):
        Recording(tmp_path / "run")


def test_a_damaged_part_is_refused_by_its_name_when_it_is_needed(menagerie, tmp_path):
    run_to_folder(
        menagerie(), seed=7, ticks=20, out=tmp_path / "run", policies="random", report=False, snapshot_every=5
    )
    part = tmp_path / "run" / "snapshots" / "part-00000.parquet"
    data = bytearray(part.read_bytes())
    data[len(data) // 3] ^= 1
    part.write_bytes(data)
    recording = Recording(tmp_path / "run")
    assert recording.numbers(3)["ram"] > 0
    with pytest.raises(RecordingError, match=r"snapshots/part-00000\.parquet: is damaged"):
        recording.organisms(3, "ram")


def test_only_what_is_asked_for_is_read(run):
    recording = Recording(run[0])
    recording.numbers(3)
    assert {key[2] for key in recording._cache.columns} == {"tick", "species", "n"}
    recording.organisms(30, "ram")
    assert {key[0].parent.name for key in recording._cache.columns} == {
        "series",
        "births",
        "deaths",
        "snapshots",
        "details-ram",
    }
    spans = {
        key[0]: group.ticks
        for parts in (recording.births, recording.deaths, recording.snapshots)
        for group in parts.groups
        for key in recording._cache.columns
        if key[0] == group.path
    }
    assert spans
    assert all(first <= 35 and last >= 28 for first, last in spans.values())  # parts of the chapter alone


def test_the_cache_forgets_the_oldest_columns(tmp_path):
    cache = Cache(budget=100)
    for name in "abcd":
        cache.put((tmp_path, 0, name), np.zeros(5))
    assert ([key[2] for key in cache.columns], cache.size) == (["c", "d"], 80)


# --- a chapter by hand --------------------------------------------------------------------------------------


def _rows(*rows):
    """Rows of (tick, uid, species, x, y, z, heading, energy, happiness)."""
    table = np.array(rows, float).reshape(-1, 9)
    out = {name: table[:, i].astype(np.float32) for i, name in enumerate(("tick", "uid", "species", *STATE))}
    return out | {name: table[:, i].astype(int) for i, name in enumerate(("tick", "uid", "species"))}


NONE = _rows()


def test_a_walker_is_on_a_straight_line_between_snapshots():
    before, after = _rows((0, 1, 0, 2, 4, 0, 0.0, 0.5, 1.0)), _rows((4, 1, 0, 6, 8, 0, 1.0, 0.9, 0.0))
    crowd = Chapter(0, 4, before, after, NONE, NONE, (20.0, 20.0), True).organisms(1, 0)
    assert [crowd.x[0], crowd.y[0], crowd.heading[0], crowd.energy[0], crowd.happiness[0]] == pytest.approx(
        [3, 5, 0.25, 0.6, 0.75]
    )


@pytest.mark.parametrize(
    ("torus", "x", "heading"), [(True, [19.0, 19.5, 0.0, 0.5], -0.1), (False, [19.0, 14.5, 10.0, 5.5], -0.1)]
)
def test_around_a_torus_the_way_is_the_shorter_one(torus, x, heading):
    before, after = _rows((0, 1, 0, 19, 0, 0, 6.0, 0, 0)), _rows((4, 1, 0, 1, 0, 0, 0.5, 0, 0))
    chapter = Chapter(0, 4, before, after, NONE, NONE, (20.0, 20.0), torus)
    assert [chapter.organisms(t, 0).x[0] for t in range(4)] == pytest.approx(x, abs=1e-5)
    turned = chapter.organisms(2, 0).heading[0]
    assert turned == pytest.approx(6.0 + (0.5 + 2 * np.pi - 6.0) / 2, abs=1e-5)  # the shorter way, too


def test_who_dies_goes_where_it_died_and_is_there_no_longer():
    before, deaths = _rows((0, 1, 0, 0, 0, 0, 0, 1.0, 0)), _rows((4, 1, 0, 8, 0, 0, 0, 0.0, 0))
    chapter = Chapter(0, 10, before, NONE, NONE, deaths, (20.0, 20.0), True)
    assert [chapter.organisms(t, 0).x.tolist() for t in (0, 1, 3, 4, 9)] == [[0.0], [2.0], [6.0], [], []]
    assert chapter.organisms(3, 0).energy[0] == pytest.approx(0.25)


def test_who_is_born_comes_from_where_it_was_born():
    births, after = _rows((6, 3, 1, 5, 5, 0, 0, 0.25, 0)), _rows((10, 3, 1, 9, 5, 0, 2.0, 0.65, 1.5))
    chapter = Chapter(0, 10, _rows((0, 1, 0, 0, 0, 0, 0, 0, 0)), after, births, NONE, (20.0, 20.0), True)
    assert chapter.organisms(5, 1).uid.size == 0
    born, later = chapter.organisms(6, 1), chapter.organisms(8, 1)
    assert (born.x[0], born.exact[0], later.x[0], later.exact[0]) == (5.0, True, 7.0, False)
    assert (born.heading[0], born.happiness[0]) == (2.0, 1.5)  # not recorded at a birth: as it is seen next
    assert later.energy[0] == pytest.approx(0.45)
