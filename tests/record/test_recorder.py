from types import SimpleNamespace

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Genome, Metabolism, Nervous, Position
from ecs_eco.genomes import Alphabet
from ecs_eco.record import Recorder
from ecs_eco.record.ledger import COUNTS_ROW, LEDGER
from ecs_eco.testing import arrange

SIGNS = np.array([1, 1, 1, -1, -1, -1, -1])


class Sink(dict):
    """Blocks by kind, as they come."""

    def __call__(self, kind, columns):
        self.setdefault(kind, []).append(columns)

    def column(self, kind, name):
        return np.concatenate([block[name] for block in self[kind]])


def of(species, series, column):
    """Return the values of a column of a series in the rows of one species, tick by tick."""
    return [value for name, value in zip(series["species"], series[column], strict=True) if name == species]


def _recorded(menagerie, ticks=60, **options):
    world = World.from_config(menagerie(), policies="untrained", record=False)
    sink = Sink()
    recorder = Recorder(world, sink, **options)
    founders = [
        (0, name, u, 0)
        for name in sorted(recorder.names)  # in the order of tables
        for u in sorted(world.tables[name].uid[world.tables[name].rows()].tolist())
    ]
    lives = {"births": founders, "deaths": []}
    world.on_birth.append(
        lambda t, rows, parents, _: lives["births"].extend(
            (world.tick, t.name, u, p) for u, p in zip(t.uid[rows].tolist(), parents.tolist(), strict=True)
        )
    )
    world.on_death.append(
        lambda t, rows: lives["deaths"].extend(
            (world.tick, t.name, int(t.uid[r]), int(t.cause[r]), int(t.killer[r])) for r in rows
        )
    )
    world.run(ticks)
    recorder.flush()
    lives = {kind: [life for life in events if life[1] in recorder.names] for kind, events in lives.items()}
    return world, recorder, sink, lives


def test_a_tick_of_two_deer_by_hand(meadow):
    world = meadow(metabolism={"energy": 0.5, "basal": 0.125}, options={"record": False})
    arrange(world, "deer", x=[5, 15], y=5, energy=[0.5, 0.0625])
    arrange(world, "grass", x=[5, 1], y=[5, 1], energy=0.5)
    Recorder(world)
    world.spawn("deer", Metabolism(energy=0.75), Position(x=1, y=18))
    world.run(1)  # the spawned one comes to life at once: it burns; one eats, one starves
    series = world.series().to_pydict()
    grass, deer = ({k: v[i] for k, v in series.items()} for i in (0, 1))
    assert [grass[k] for k in ("species", "n", "births", "deaths")] == ["grass", 1, 0, 1]
    assert [deer[k] for k in ("species", "n", "births", "deaths")] == ["deer", 2, 1, 1]
    assert [deer[k] for k in LEDGER] == [0.5625, 0.75, 0.25, 0.3125, 0, 0, 1.25]
    assert [grass[k] for k in LEDGER] == [1.0, 0, 0, 0, 0, 0.5, 0.5]
    assert (deer["energy_mean"], grass["energy_mean"]) == (0.625, 0.5)
    assert deer["happiness_mean"] == pytest.approx((0.5 + 0.75) / 2)  # felt before the meal
    assert (deer["died: starved"], grass["died: starved"], grass["died: eaten by deer"]) == (1, 0, 1)


def test_the_ledger_closes_and_numbers_add_up_in_a_world_of_everything(menagerie):
    world = World.from_config(menagerie(), policies="untrained").run(150)
    series = world.series().to_pydict()
    flows = np.array([series[k] for k in LEDGER])
    assert np.abs(SIGNS @ flows).max() < 1e-6 * np.abs(flows).sum(axis=0).max()
    assert (flows[1:6] != 0).any(axis=1).all()  # every flow flows
    assert flows[0, 3:].tolist() == flows[6, :-3].tolist()
    assert len(series["tick"]) == 150 * 3
    assert series["tick"][:6] == [0, 0, 0, 1, 1, 1]
    assert series["species"] == ["moss", "ram", "lynx"] * 150  # in the order of the file


def test_births_are_endowed_with_what_the_parents_gave(menagerie):
    world = World.from_config(menagerie(), policies="untrained").run(150)
    series = world.series().to_pydict()
    ram = np.array([s == "ram" for s in series["species"]])
    assert np.array(series["endowed"])[ram] == pytest.approx(np.array(series["given"])[ram], abs=1e-6)
    assert np.array(series["births"])[ram].sum() > 3


def test_every_birth_and_death_is_recorded_once(menagerie):
    world, recorder, sink, lives = _recorded(menagerie)
    names = np.array(recorder.names)
    births = list(
        zip(
            sink.column("births", "tick"),
            names[sink.column("births", "species")],
            sink.column("births", "uid"),
            sink.column("births", "parent"),
            strict=True,
        )
    )
    deaths = list(
        zip(
            sink.column("deaths", "tick"),
            names[sink.column("deaths", "species")],
            sink.column("deaths", "uid"),
            sink.column("deaths", "cause"),
            sink.column("deaths", "killer"),
            strict=True,
        )
    )
    assert births == lives["births"]
    assert deaths == lives["deaths"]
    assert len(births) > 20
    assert len(deaths) > 20
    n_founders = 150 + 40 + 8
    assert (sink.column("series", "births").sum(), sink.column("series", "deaths").sum()) == (
        len(births) - n_founders,
        len(deaths),
    )
    ages = sink.column("deaths", "age")
    born = dict(
        zip(sink.column("births", "uid").tolist(), sink.column("births", "tick").tolist(), strict=True)
    )
    expected = [(t - born.get(int(u), 0)) * world.dt for t, _, u, _, _ in deaths]
    assert ages.tolist() == expected


def test_blocks_change_nothing(menagerie):
    world, _, small, _ = _recorded(menagerie, block=7)
    _, _, large, _ = _recorded(menagerie, block=1000)
    assert [len(b["tick"]) for b in small["series"]] == [21] * 8 + [12]
    for kind in ("series", "births", "deaths"):
        for name in large[kind][0]:
            both = [
                np.concatenate([b.get(name, np.zeros(len(b["tick"]), int)) for b in sink[kind]])
                for sink in (small, large)
            ]
            assert (both[0] == both[1]).all(), name
    plain = World.from_config(menagerie(), policies="untrained").run(60)
    assert plain.digest() == world.digest()  # nor does it matter who records


def test_snapshots_are_of_everyone_in_the_order_of_uids(menagerie):
    world, recorder, sink, _ = _recorded(menagerie, ticks=21, snapshot_every=10)
    assert sorted(set(sink.column("snapshots", "tick").tolist())) == [0, 10, 20]
    last = sink.column("snapshots", "tick") == 20
    for s, name in enumerate(recorder.names):
        table = world.tables[name]
        rows = table.by_uid()
        mine = last & (sink.column("snapshots", "species") == s)
        assert (sink.column("snapshots", "uid")[mine] == table.uid[rows]).all()
        assert (sink.column("snapshots", "x")[mine] == table[Position].x[rows]).all()
        assert (sink.column("snapshots", "energy")[mine] == table[Metabolism].energy[rows]).all()


def test_deaths_and_births_between_ticks_belong_to_the_next_and_keep_the_books(menagerie):
    world = World.from_config(menagerie(), policies="untrained").run(5)
    for name in ("ram", "moss"):
        table = world.tables[name]
        for uid in table.uid[table.by_uid()][:3].tolist():
            world.kill(uid)
    world.flush()
    world.spawn("ram", Metabolism(energy=0.5), Position(x=1, y=1), n=2)
    world.flush()
    world.run(5)
    series = world.series().to_pydict()
    flows = np.array([series[k] for k in LEDGER])
    assert np.abs(SIGNS @ flows).max() < 1e-5
    ram = np.array(series["species"]) == "ram"
    assert np.array(series["died: culled"])[ram].tolist() == [0] * 5 + [3] + [0] * 4
    n = np.array(series["n"])[ram]
    assert (np.diff(n) == (np.array(series["births"]) - np.array(series["deaths"]))[ram][1:]).all()


def test_what_happens_around_a_flush_is_neither_lost_nor_told_too_early(meadow):
    world, sink = meadow(options={"record": False}), Sink()
    recorder = Recorder(world, sink)
    world.run(2)
    world.kill(int(world.tables["deer"].uid[0]))
    world.flush()
    recorder.flush()
    assert "deaths" not in sink  # it belongs to the tick to come
    world.run(1)
    recorder.flush()
    assert sink.column("series", "tick").tolist() == [0, 0, 1, 1, 2, 2]
    series = {
        "species": [recorder.names[s] for s in sink.column("series", "species")],
        "deaths": sink.column("series", "deaths"),
    }
    assert of("deer", series, "deaths") == [0, 0, 1]
    assert of("grass", series, "deaths") == [0, 0, 0]
    assert sink.column("deaths", "tick").tolist() == [2]


def test_causes_that_become_known_late_have_a_column_with_zeros_before(meadow):
    world = meadow()
    world.run(2)
    world.recorder.flush()
    world.kill(int(world.tables["deer"].uid[0]), "struck by lightning")
    world.run(1)
    series = world.series().to_pydict()
    assert of("deer", series, "died: struck by lightning") == [0, 0, 1]
    assert of("grass", series, "died: struck by lightning") == [0, 0, 0]


def test_a_species_without_metabolism_or_nerves_is_counted_all_the_same():
    world = World((10, 10))
    world.add_table("stone", Position)
    world.spawn("stone", n=3)
    Recorder(world)
    world.run(2)
    series = world.series().to_pydict()
    assert series["n"] == [3, 3]
    assert series["births"] == [3, 0]
    assert series["stock_after"] == [0, 0]


def test_a_species_that_died_out_has_rows_of_zeros(meadow):
    world = meadow()
    for uid in world.tables["deer"].uid[:2].tolist():
        world.kill(uid)
    world.run(3)
    series = world.series().to_pydict()
    assert of("deer", series, "n") == [0, 0, 0]
    assert of("deer", series, "energy_mean") == [0, 0, 0]
    assert np.isfinite(series["happiness_mean"]).all()


def test_the_happiness_of_a_single_one_in_the_smallest_of_tables_is_recorded():
    world = World((10, 10))
    table = world.add_table("hermit", Position, Metabolism, Nervous, capacity=1, dims={"actions": 1})
    world.spawn("hermit", Nervous(happiness=0.75))
    world.flush()
    Recorder(world)
    world.run(1)
    assert (table.capacity, world.series().to_pydict()["happiness_mean"]) == (1, [0.75])


def _flock(letters=None, n=3):
    """A world of one species with a genome of two loci; its recorder keeps events."""
    world = World((10, 10))
    table = world.add_table("finch", Position, Genome, dims={"loci": 2})
    if letters is not None:
        table.species.heredity = SimpleNamespace(layout=SimpleNamespace(alphabet=Alphabet(letters)))
    world.spawn("finch", n=n)
    world.flush()
    table[Genome].loci[table.by_uid()[1]] = 1, 3
    return world, table, Recorder(world, keep_events=True)


def test_founders_and_newborn_are_recorded_with_their_genomes():
    world, table, recorder = _flock()
    world.run(1)
    table.request(
        np.array([2, 1], np.uint64),
        {(Genome, "loci"): np.array([[1, 2], [0, 3]], np.uint8)},
        np.array([1, 0], np.uint64),
    )
    world.run(1)
    births = recorder.events("births")
    assert births["uid"].tolist() == [1, 2, 3, 4, 5]
    assert births["tick"].tolist() == [0, 0, 0, 1, 1]
    assert births["parent"].tolist() == [0, 0, 0, 2, 1]
    assert births["parent2"].tolist() == [0, 0, 0, 1, 0]
    assert births["genome"].tolist() == [b"AA", b"CT", b"AA", b"CG", b"AT"]
    assert {len(column) for column in births.values()} == {5}


@pytest.mark.parametrize(("letters", "expected"), [("01", ["00", "1?", "00"]), ("αβγδ", ["αα", "βδ", "αα"])])
def test_genomes_are_written_in_the_letters_of_their_own_alphabet(letters, expected):
    _, _, recorder = _flock(letters)
    assert recorder.events("births")["genome"].astype(str).tolist() == expected


def test_events_in_memory_are_those_that_a_sink_gets(menagerie):
    _, _, sink, _ = _recorded(menagerie)
    world = World.from_config(menagerie(), policies="untrained", record=False)
    kept = Recorder(world, keep_events=True, block=7)
    world.run(60)
    for kind in ("births", "deaths"):
        events = kept.events(kind)
        assert list(events) == list(sink[kind][0])
        assert all((events[name] == sink.column(kind, name)).all() for name in events)


def test_the_living_are_founders_of_a_recording_that_begins_late(meadow):
    world = meadow(options={"record": False})
    world.run(3)
    world.spawn("deer", Metabolism(energy=0.5))
    world.flush()
    recorder = Recorder(world, keep_events=True)
    births = recorder.events("births")
    lives = zip((recorder.names[s] for s in births["species"]), births["uid"], births["tick"], strict=True)
    assert list(lives) == [("deer", 1, 0), ("deer", 2, 0), ("deer", 5, 3), ("grass", 3, 0), ("grass", 4, 0)]


def test_events_that_nobody_kept_are_no_events_of_a_world_without_deaths(meadow):
    world = meadow()
    with pytest.raises(RuntimeError, match="keep_events=True"):
        world.recorder.events("births")
    with pytest.raises(ValueError, match="keep_events is True, but a sink receives the events"):
        Recorder(world, Sink(), keep_events=True)
    world = meadow(options={"record": False})
    deaths = Recorder(world, keep_events=True).events("deaths")
    assert {len(column) for column in deaths.values()} == {0}
    assert {"tick", "uid", "cause"} <= set(deaths)


def test_a_recording_of_before_births_were_refused_goes_on(meadow):
    world = meadow().run(3)
    world.recorder.flush()
    state = world.recorder.state()
    page = state["page/counts"]
    former = state | {"page/counts": np.delete(page, COUNTS_ROW.names.index("refused"), axis=-1)}
    del former["series/refused"]
    world.recorder.load(former)
    world.run(2)
    assert world.series()["refused"].to_pylist() == [0] * 2 * 5


def test_a_recording_of_tables_in_another_order_goes_on(menagerie, tmp_path):
    world = World.from_config(menagerie(), policies="untrained", record=False)
    tables, config = list(world.tables.items()), world.config
    world.tables.clear()
    world.tables.update(reversed(tables))
    world.config = config.model_copy(update={"species": dict(reversed(config.species.items()))})
    recorder = Recorder(world, keep_events=True)
    world.config = config
    world.run(20)
    world.save(tmp_path / "former.safetensors")
    other = World.restore(tmp_path / "former.safetensors")
    assert recorder.names == ["lynx", "ram", "moss"]
    assert other.recorder.names == ["moss", "ram", "lynx"]
    other.recorder.keeps = True

    former, now = world.series().to_pydict(), other.series().to_pydict()
    for column in former:
        for name in recorder.names:
            assert of(name, now, column) == of(name, former, column), (column, name)
    for kind in ("births", "deaths"):
        was, events = recorder.events(kind), other.recorder.events(kind)
        assert len(was["uid"]) > 0
        assert [other.recorder.names[s] for s in events["species"]] == [
            recorder.names[s] for s in was["species"]
        ]
    rows = [r.learning.series("actions").to_pylist() for r in (recorder, other.recorder)]
    assert len(rows[0]) > 0
    assert rows[1] == rows[0]

    later = other.run(5).series().to_pydict()
    flows = np.array([later[k] for k in LEDGER])
    assert flows[0, 3:].tolist() == flows[6, :-3].tolist()  # also where the one recording follows the other
