"""Numbers that would take all of the memory, or hours, are refused before anything is made of them."""

from __future__ import annotations

import copy
import re
from typing import Any

import pytest

from ecs_eco.config import load
from ecs_eco.config.memory import in_words, machine_memory, needs, require_memory
from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import ConfigError
from ecs_eco.record.recorder import Recorder
from ecs_eco.space import Space

GOAT: dict[str, Any] = {
    "count": 10,
    "body": {"radius": 0.1},
    "locomotion": {"speed": {"walk": 1.0}},
    "sensors": [{"kind": "own", "property": "energy"}],
    "actions": {"speed": ["walk"]},
    "default_action": {"speed": "walk"},
    "happiness": {"formula": "energy", "minimum": 0.0},
    "policy": {"kind": "shared", "hidden": [8]},
}
WORLD = {"format": 1, "name": "w", "space": {"size": [40.0, 30.0]}, "species": {"goat": GOAT}}


def world(changes: dict[str, Any]) -> Any:
    return load(copy.deepcopy(WORLD), changes)


def refused(changes: dict[str, Any]) -> str:
    with pytest.raises(ConfigError) as error:
        require_memory(world(changes), 8e9)
    return str(error.value)


@pytest.mark.parametrize(
    ("changes", "place", "what"),
    [
        (
            {"space.cell": 1e-9},
            "space.cell = 1e-09",
            "the neighbor index would have 1.2e+21 cells; expected: at least 0.018 m (4,000,000 cells), or remove",
        ),
        (
            {"species.goat.policy.hidden": [4096] * 8},
            "species.goat.policy.hidden = [4096",
            "117,485,570 weights; expected: at most 10,000,000",
        ),
        (
            {"species.goat.policy.hidden": []},
            "species.goat.policy.hidden = []",
            'at least one hidden layer; expected: a list such as [8], or policy.kind = "individual"',
        ),
        (
            {"species.goat.policy": {"kind": "individual", "hidden": [2048, 2048]}},
            "species.goat.policy.hidden",
            "needs about 12.9 GB",
        ),
        (
            {"species.goat.policy.kind": "individual", "species.goat.ppo.horizon": 10**9},
            "species.goat.ppo.horizon",
            "needs about",
        ),
        (
            {"species.goat.count": 50_000_000},
            "species.goat.count = 50000000",
            "needs about 12.6 GB; expected: a value small enough for 8 GB",
        ),
        (
            {"objects.rock": {"count": 50_000_000, "body": {"radius": 0.1}}},
            "objects.rock.count",
            "needs about 8 GB",
        ),
        (
            {"species.goat.lethal": [{"property": "energy", "min": 0.0, "cause_below": "x" * 61}]},
            "lethal.0.cause_below",
            "at most 60 characters",
        ),
        ({"title": "x" * 201}, "title", "at most 200 characters"),
        ({"description": "x" * 20_001}, "description", "at most 20000 characters"),
    ],
)
def test_too_much_is_refused_with_its_key_and_what_it_comes_to(
    changes: dict[str, Any], place: str, what: str
) -> None:
    text = refused(changes)
    assert place in text
    assert what in text


@pytest.mark.parametrize(
    ("what", "size"),
    [("index", [1e4, 1e4, 10.0]), ("field", [1e4, 1e4, 0.01]), ("map", [40.0, 30.0]), ("ground", [1e4, 1e4])],
)
def test_the_smallest_width_of_cells_is_told(what: str, size: list[float]) -> None:
    def check(width: float) -> None:
        grass: dict[str, Any] = {"count": 1, "body": {"radius": 1e-5}}
        config = {"format": 1, "name": "w", "space": {"size": size}, "species": {"grass": grass}}
        if what == "index":
            config["space"] = {"size": size, "cell": width}
        elif what == "field":
            config["fields"] = {"smell": {"cell": width}}
        elif what == "map":
            config["terrain"] = {"cell": width}
        else:
            grass["reproduction"] = {"kind": "spread", "rate": 0.1, "spacing": width}
        load(config)

    with pytest.raises(ConfigError) as error:
        check(1e-7)
    told = re.search(rf"the (neighbor )?{what} would have .*; expected: at least (\S+) m", str(error.value))
    assert told is not None
    check(float(told[2]))
    with pytest.raises(ConfigError, match="too small"):
        check(0.9 * float(told[2]))


def test_fields_that_fit_alone_are_refused_together() -> None:
    fields = {f"f{i}": {"cell": 0.004} for i in range(20)}
    assert "it needs about 18 GB of memory at its start; available: 8 GB" in refused({"fields": fields})


def test_a_world_with_more_than_128_species_is_refused() -> None:
    plant = {"count": 1, "body": {"radius": 0.1}}
    assert len(world({"species": {f"s{i}": plant for i in range(128)}}).species) == 128
    assert "at most 128 entries" in refused({"species": {f"s{i}": plant for i in range(129)}})


def test_a_recorder_of_more_than_128_species_is_refused() -> None:
    by_hand = World((9.0, 9.0))
    for i in range(129):
        by_hand.add_table(f"s{i}", capacity=1)
    with pytest.raises(ValueError, match="129 species; expected at most 128"):
        Recorder(by_hand)


def test_more_than_255_causes_of_death_are_refused_at_the_first_too_many() -> None:
    culls = [{"kind": "cull", "at": 1, "species": "goat", "count": 1, "cause": f"c{i}"} for i in range(255)]
    assert 'interventions.254.cause = "c254"\n  too many causes of death; expected: at most 255' in refused(
        {"interventions": culls}
    )
    world({"interventions": culls[:254]})


def test_a_world_that_does_not_fit_is_refused_before_it_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ecs_eco.config.memory.machine_memory", lambda: 1000.0)
    with pytest.raises(ConfigError, match="available: 1 kB"):
        World.from_config(world({}))


def test_cells_that_no_whole_number_counts_are_made_larger() -> None:
    assert Space((1e9, 1e9), cell=1e-9).n_cells <= 4_000_000
    assert Space((40.0, 30.0), cell=5e-324).n_cells <= 4_000_000
    assert Space((40.0, 30.0), cell=1.0).shape == (40, 30, 1)


def test_an_ordinary_world_needs_little() -> None:
    assert sum(size for _, size in needs(world({}))) < 5e6
    assert machine_memory() > 1e8


def test_sizes_are_told_in_words() -> None:
    assert [in_words(x) for x in (5, 12_345, 3.21e9, 1e20)] == ["5 bytes", "12.3 kB", "3.21 GB", "1e+05 PB"]


@pytest.mark.parametrize("file", ["/proc/self/mem", "/dev/zero", "/proc/none", "x" * 5000])
def test_files_of_weights_that_cannot_be_read_are_refused(file: str) -> None:
    with pytest.raises(ConfigError, match=r"species\.goat\.policy\.file"):
        world({"species.goat.policy.file": file})


def test_what_is_no_file_of_weights_is_refused_when_the_world_is_built() -> None:
    with pytest.raises(ConfigError, match=r"species\.goat\.policy = .?/proc/self/status"):
        World.from_config(world({"species.goat.policy.file": "/proc/self/status"}))
