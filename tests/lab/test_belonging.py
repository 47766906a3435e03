"""Files of another archipelago, island, barrier or mode are refused by name, and nothing is removed."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ecs_eco.analysis.archipelago import load_islands, write_archipelago
from ecs_eco.engine.errors import CheckpointError, ForeignFile, RecordingError
from ecs_eco.lab.archipelago import Archipelago, advance
from ecs_eco.record import checkpoint, container, seal
from ecs_eco.record.archipelago import FILE, Manifest
from tests.lab.newts import written

BARRIER = "tick-000000000008.safetensors"


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two archipelagos of other seeds, at tick 8 of 12."""
    place = tmp_path_factory.mktemp("two")
    for seed in (1, 2):
        made = Archipelago.from_config(str(written(place)), seed, 12, place / f"seed-{seed}")
        made.run(until=8, report=False)
    return place


def _exports(mine: Path, other: Path) -> str:
    shutil.copy(other / "islands/east/exports" / BARRIER, mine / "islands/east/exports" / BARRIER)
    return rf"{BARRIER}: contains migrants from another archipelago"


def _neighbour(mine: Path, other: Path) -> str:
    shutil.copy(mine / "islands/east/exports" / BARRIER, mine / "islands/south/exports" / BARRIER)
    return rf"{BARRIER}: contains migrants from another island"


def _island(mine: Path, other: Path) -> str:
    shutil.rmtree(mine / "islands/east")
    shutil.copytree(other / "islands/east", mine / "islands/east")
    return rf"east/exports/{BARRIER}: contains migrants from another archipelago"


def _manifest(mine: Path, other: Path) -> str:
    shutil.copy(other / FILE, mine / FILE)
    return r"manifest\.json: does not belong to the island"


def _link(mine: Path, other: Path) -> str:
    shutil.rmtree(mine / "islands/east")
    (mine / "islands/east").symlink_to(other / "islands/east")
    return rf"east/exports/{BARRIER}: is a link that leads out of"


def _digest(mine: Path, other: Path) -> str:
    whole = container.read(mine, Manifest)
    whole["islands"]["east"]["digest"] = "0" * 64
    container.write(mine, Manifest, whole)
    return rf"{BARRIER}: has a different digest than archipelago\.json records for the island east"


@pytest.mark.parametrize("put", [_exports, _neighbour, _island, _manifest, _link, _digest])
def test_what_is_of_another_archipelago_is_refused(
    put: Callable[[Path, Path], str], two: Path, tmp_path: Path
) -> None:
    mine = shutil.copytree(two / "seed-1", tmp_path / "mine")
    said = put(mine, two / "seed-2")
    before = _content(mine)
    with pytest.raises(ForeignFile, match=said):
        Archipelago(mine).run(until=12, report=False)
    assert before.items() <= _content(mine).items()


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("uid", lambda a: np.stack([a, a], 1), "newt/uid: is not a migrants file"),
        ("born", lambda a: np.stack([a, a], 1), "newt/born: is not a migrants file"),
        ("to", lambda a: np.stack([a, a], 1), "newt/to: is not a migrants file"),
        ("columns/Metabolism.energy", lambda a: a * np.float32(np.nan), "Metabolism.energy is nan"),
        ("columns/Metabolism.energy", lambda a: a + np.float32(np.inf), "Metabolism.energy is inf"),
    ],
)
def test_changed_migrants_are_refused(
    two: Path, tmp_path: Path, name: str, change: Callable[[np.ndarray], np.ndarray], said: str
) -> None:
    mine = shutil.copytree(two / "seed-1", tmp_path / "mine")
    file = mine / "islands/east/exports" / BARRIER
    meta, arrays = checkpoint.read(file)
    checkpoint.write(file, meta, arrays | {f"newt/{name}": change(arrays[f"newt/{name}"])})
    with pytest.raises(CheckpointError, match=rf"east.*{said}|a migrant that arrives at tick 8: .*{said}"):
        Archipelago(mine).run(until=12, report=False)


def _content(folder: Path) -> dict[Path, bytes]:
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*.safetensors")}


def test_an_island_that_is_further_than_the_others_is_shown_up_to_their_tick(
    two: Path, tmp_path: Path
) -> None:
    mine = shutil.copytree(two / "seed-1", tmp_path / "mine")
    before = load_islands(mine)
    advance(str(mine), "north", 8, 12)
    islands = load_islands(mine)
    assert [len(s.ticks) for s in islands.series.values()] == [8, 8, 8]
    assert islands.moves.tolist() == before.moves.tolist()
    write_archipelago(mine)


def test_one_of_the_other_mode_is_refused(two: Path, tmp_path: Path) -> None:
    mine = shutil.copytree(two / "seed-1", tmp_path / "mine")
    whole = container.read(mine, Manifest) | {"mode": "portable"}
    container.write(mine, Manifest, whole | {"hash": container._hash(whole, Manifest)})
    with pytest.raises(ForeignFile, match=r"archipelago\.json: was computed in the portable mode"):
        Archipelago(mine).run(until=12, report=False)


def test_a_number_of_islands_means_islands_with_numbers(two: Path, tmp_path: Path) -> None:
    whole = container.read(two / "seed-1", Manifest)
    whole["config"]["archipelago"]["islands"] = 7
    container.write(tmp_path, Manifest, whole | {"hash": container._hash(whole, Manifest)})
    assert list(Archipelago(tmp_path).islands) == [f"island_{i}" for i in range(1, 8)]


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("tick", "8", "tick: Input should be a valid integer"),
        ("ticks", -1, "ticks: "),
        ("islands", [], "islands: "),
        (
            "config",
            {"archipelago": {"islands": {"../victim": {}, "b": {}}, "migration_interval": 4}},
            r"config\.archipelago\.islands",
        ),
        ("config", {"terrain": "x"}, r"config\.terrain"),
        ("config", None, "config: "),
        ("seed", 3, "hash: does not match the plan"),
        ("extra", 1, "extra: "),
    ],
)
def test_a_manifest_with_wrong_values_is_refused_by_key(
    two: Path, tmp_path: Path, key: str, value: object, said: str
) -> None:
    content = json.loads((two / "seed-1" / FILE).read_text())
    content[key] = content[key] | value if key == "config" and isinstance(value, dict) else value
    seal.write_manifest(tmp_path, content, FILE)
    with pytest.raises(RecordingError, match=rf"archipelago\.json: {said}"):
        Archipelago(tmp_path)
