"""Alleles taken out in forks: effects that are known by hand, and results that nothing else changes."""

import json
import shutil
from types import SimpleNamespace

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Policy
from ecs_eco.config import load
from ecs_eco.engine.errors import ForeignFile, RecordingError
from ecs_eco.explain import Edit, driver, take_out, taken_out, write_explanation
from ecs_eco.explain.followed import Followed
from ecs_eco.explain.taken_out import world_at
from ecs_eco.record import run_to_folder
from ecs_eco.record.seal import read_manifest, write_manifest
from tests.explain.newts import VARIABLE, WORLD, recorded

HUNGRY = Edit("newt", "letter", "hunger", 0, "B")
FERTILE = Edit("newt", "letter", "fertile", 1, "B")


@pytest.fixture(scope="module")
def pond(tmp_path_factory):
    return recorded(tmp_path_factory.mktemp("newts") / "run", ticks=3, checkpoint_every=1, keep=9)


def whole(taken, measure, **of):
    """Return an effect that is the same in all forks."""
    value, low, high = taken.effect(measure, **of)
    assert low == high == value
    return value


def test_the_effect_on_lives_is_as_reckoned_by_hand(pond):
    # a full store is enough for 4 ticks or, without the allele, for 8; newts die in the last of them
    taken = take_out(pond, HUNGRY, "A", tick=0, forks=3, workers=1, ticks=20)
    assert taken.lasted.tolist() == [8, 8, 8]
    assert np.ptp(taken.n, axis=1).max() <= 1
    assert whole(taken, "survival") == 4.0
    assert taken.control("survival").value == 3.0
    assert taken.control("died: starved").value == 1.0
    assert whole(taken, "alive") == 0.0
    assert taken.effect("births").value > 0  # fertile newts bear a young in each tick
    assert set(taken.doses) == {1, 2}
    frame = taken.to_pandas()
    assert frame[frame.measure == "survival"].effect.tolist() == [4.0, 4.0, 4.0]


def test_in_reverse_the_effect_is_the_opposite(pond):
    taken = take_out(pond, HUNGRY, tick=0, forks=2, workers=1, ticks=20, reverse=True)
    assert whole(taken, "survival") == -4.0
    assert taken.doses == {}


def test_births_of_two_alleles_interact(pond):
    taken = take_out(pond, [HUNGRY, FERTILE], ["A", "A"], tick=0, forks=4, workers=1, ticks=20)
    assert taken.n.shape == (4, 4)
    assert (taken.means["births"][:, 2:] == 0).all()  # without fertility, no young, whether hungry or not
    # one young per tick, on average: without hunger, 7 instead of 3
    assert taken.control("births").value == pytest.approx(3, abs=1)
    assert taken.effect("births").value == pytest.approx(4, abs=1)
    assert taken.effect("births", of="second") == taken.effect("births", of="both")
    assert taken.effect("births", of="interaction").value == pytest.approx(-taken.effect("births").value)


def test_a_fork_that_ends_early_counts_what_happened_until_then(pond):
    taken = take_out(pond, HUNGRY, "A", tick=0, forks=2, workers=1, ticks=6)
    assert whole(taken, "alive") == 1.0
    assert whole(taken, "survival") == 3.0


def test_the_dose_is_the_number_of_copies_removed(tmp_path):
    world = WORLD | {"species": {"newt": WORLD["species"]["newt"] | {"genome": VARIABLE}}}
    run = recorded(tmp_path / "run", ticks=1, world=world)
    taken = take_out(run, Edit("newt", "copies", "hunger", value="2"), "1", tick=0, forks=2, workers=1)
    assert taken.doses == {}
    assert taken.effect("survival").value >= 0


def test_a_stopped_call_continues_and_workers_do_not_matter(pond, monkeypatch):
    def files(**how):
        taken = take_out(pond, HUNGRY, "A", tick=1, forks=3, ticks=5, seed=7, **how)
        (place,) = [p.parent for p in pond.glob("explain/*/what.json") if json.loads(p.read_text())[-1] == 7]
        return taken, place, [p.read_bytes() for p in sorted(place.glob("fork-*"))]

    first, place, written = files(workers=1)
    (place / "fork-0001.json").unlink()
    done = []
    again, _, same = files(workers=2, progress=lambda n, of: done.append((n, of)))
    assert same == written
    assert done == [(3, 3)]
    for path in place.glob("fork-*"):
        path.unlink()
    assert files(workers=2)[2] == written
    monkeypatch.setattr(taken_out, "run_fork", None)
    assert files()[0].to_pandas().equals(first.to_pandas())
    assert again.n.tolist() == first.n.tolist()


def test_a_fork_of_another_mode_or_a_changed_file_is_not_taken_for_done(pond, monkeypatch):
    def take():
        return take_out(pond, HUNGRY, "A", tick=1, forks=2, ticks=5, seed=8, workers=1)

    def places():
        return {p.parent for p in pond.glob("explain/*/what.json") if json.loads(p.read_text())[-1] == 8}

    take()
    (place,) = places()
    first, second = (place / f"fork-000{i}.json" for i in range(2))
    whole = first.read_text()
    content = json.loads(whole)
    first.write_text(whole.replace('"lasted": ', '"lasted": 1'))
    with pytest.raises(RecordingError, match=r"fork-0000\.json: is damaged or was changed"):
        take()
    for key, value, said in (
        ("lasted", None, "lasted: Input should be"),
        ("means", {"births": [0.0, 1.0, 2.0]}, "contains another fork"),
        ("doses", {"x": {}}, "doses"),
    ):
        write_manifest(place, content | {key: value}, first.name)
        with pytest.raises(RecordingError, match=rf"fork-0000\.json: .*{said}"):
            take()
    first.write_bytes(second.read_bytes())
    with pytest.raises(ForeignFile, match=r"fork-0000\.json: contains another fork"):
        take()
    first.write_text(whole)
    monkeypatch.setattr(taken_out, "portable", SimpleNamespace(mode=lambda: "other"))
    monkeypatch.setattr(taken_out, "_on_executor", lambda *_: (number for number in ()))
    with pytest.raises(FileNotFoundError):  # none of the forks is taken over
        take()
    assert len(places()) == 2


def test_no_fork_is_written_through_a_link_that_leads_out(pond, tmp_path):
    run = shutil.copytree(pond, tmp_path / "run", ignore=shutil.ignore_patterns("explain"))
    (tmp_path / "mine").mkdir()
    (run / "explain").symlink_to(tmp_path / "mine")
    with pytest.raises(ForeignFile, match=r"run/explain: is a link that leads out of .*run"):
        take_out(run, HUNGRY, "A", tick=1, forks=2, ticks=5)
    with pytest.raises(ForeignFile, match=r"run/explain: is a link that leads out of .*run"):
        write_explanation(run, forks=0)
    assert list((tmp_path / "mine").iterdir()) == []


def test_following_changes_nothing_and_a_repeated_tick_is_the_recorded_one(pond):
    manifest = read_manifest(pond)
    for name in ("checkpoints", "explain"):  # repeated from the start
        for path in pond.glob(f"{name}/tick-*2.safetensors"):
            path.unlink()
    world, base = world_at(pond, manifest, 2)
    assert world.digest() == World.from_config(WORLD, seed=1, record=False).run(2).digest()
    again = World.restore(base, record=False)
    table = again.table("newt")
    Followed(again, table, table.uid[table.by_uid()]).run(2, {})
    assert again.digest() == world.run(2).digest()


def test_weights_at_birth_are_those_of_the_run(tmp_path):
    config = load("reflexes", {"species.goat.reproduction.age_min": 1.0, "species.goat.count": 40})
    run_to_folder(config, seed=2, ticks=40, out=tmp_path / "run", report=False, checkpoint_every=10, keep=9)
    world = World.from_config(config, seed=2, record=False)
    table = world.table("goat")
    born = {}

    def note(of, rows, *_):
        if of is table:
            born.update(zip(of.uid[rows].tolist(), of[Policy].weights[rows].copy(), strict=True))

    note(table, table.rows())
    world.on_birth.append(note)
    world.run(36)
    rows = table.rows()
    learned = table[Policy].weights[rows]
    assert any((learned[i] != born[uid]).any() for i, uid in enumerate(table.uid[rows].tolist()))
    taken = take_out(tmp_path / "run", Edit("goat", "policy"), tick=36, forks=2, ticks=2, workers=1)
    assert taken.n.sum(axis=1).tolist() == [table.n, table.n]
    (path,) = tmp_path.glob("run/explain/*born-goat*")
    weights = taken_out._read_weights(path)
    assert set(weights) == set(table.uid[rows].tolist())
    assert all((weights[uid] == born[uid]).all() for uid in weights)
    base = tmp_path / "run" / "explain" / "tick-000000000036.safetensors"
    followed, alone = (World.restore(base, record=False) for _ in range(2))
    goats = followed.table("goat")
    Followed(followed, goats, goats.uid[goats.by_uid()]).run(2, {})
    assert followed.digest() == alone.run(2).digest()
    actions = sum(taken.control(f"action: speed.{name}").value for name in ("walk", "eat"))
    assert 0.9 < actions <= 1.0  # a goat that touches red grass may be unable to eat


def test_the_driver_is_the_allele_with_the_largest_clear_effect(pond):
    each = [
        take_out(pond, Edit("newt", "letter", locus=at, value="B"), "A", tick=1, forks=3, ticks=20, workers=1)
        for at in range(3)
    ]
    assert driver(each) is each[1]
    assert each[0].effect().low > 0  # hunger lowers births, so it drives no rise
    assert driver(each[::2]) is None
    assert driver(each[2:], "survival") is None
    assert driver(each, "survival") is each[0]


def test_bad_input_is_refused(pond, tmp_path):
    with pytest.raises(ValueError, match=r"tick.*from 0 to 3"):
        take_out(pond, HUNGRY, "A", tick=4, workers=1)
    with pytest.raises(ValueError, match="3 alleles and 3 replacements; expected 1 or 2"):
        take_out(pond, [HUNGRY] * 3, tick=2, workers=1)
    with pytest.raises(ValueError, match="0 living newt can be changed at tick 2; expected 2 or more"):
        take_out(pond, Edit("newt", "value", "hunger", value="9"), "0.125", tick=2, workers=1)
    with pytest.raises(FileNotFoundError, match="is not a run folder"):
        take_out(tmp_path, HUNGRY)
