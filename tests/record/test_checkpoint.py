"""Checkpoint files: damaged or foreign ones are refused, old formats migrated; none is half-written."""

import json
import os

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.record import checkpoint


@pytest.fixture(scope="module")
def written(tmp_path_factory, menagerie):
    path = tmp_path_factory.mktemp("written") / "w.safetensors"
    return World.from_config(menagerie(), policies="untrained", learn=True).run(3).save(path)


def test_a_cut_or_changed_file_is_refused_with_its_name(written, tmp_path):
    data, rng = written.read_bytes(), np.random.default_rng(1)
    for cut in (0, 5, 100, len(data) // 2, len(data) - 1):
        bad = tmp_path / "cut.safetensors"
        bad.write_bytes(data[:cut])
        with pytest.raises(CheckpointError, match=r"cut\.safetensors"):
            checkpoint.read(bad)
    meta, arrays = checkpoint.read(written)
    for at in rng.integers(0, len(data), 150):
        bad = bytearray(data)
        bad[at] ^= 1 << rng.integers(8)
        (tmp_path / "flip.safetensors").write_bytes(bad)
        message = ""
        try:
            again = checkpoint.read(tmp_path / "flip.safetensors")
        except CheckpointError as error:
            message = str(error)
        if message:
            assert "flip.safetensors" in message
        else:  # a byte that means nothing
            assert again[0] == meta
            assert all(
                np.array_equal(again[1][k], v, equal_nan=v.dtype.kind == "f") for k, v in arrays.items()
            )


def test_a_file_that_is_another_is_refused(tmp_path):
    from safetensors.numpy import save_file

    save_file({"x": np.zeros(3)}, tmp_path / "weights.safetensors")
    with pytest.raises(CheckpointError, match="is not an ecs-eco checkpoint"):
        checkpoint.read(tmp_path / "weights.safetensors")
    with pytest.raises(CheckpointError, match="no such file"):
        World.restore(tmp_path / "nowhere.safetensors")


def test_another_format_is_migrated_or_refused(written, tmp_path, monkeypatch):
    meta, arrays = checkpoint.read(written)
    monkeypatch.setattr(checkpoint, "FORMAT", 0)
    checkpoint.write(tmp_path / "old.safetensors", {k: v for k, v in meta.items() if k != "format"}, arrays)
    monkeypatch.undo()
    with pytest.raises(CheckpointError, match="has format 0; this version of ecs-eco reads format 3"):
        World.restore(tmp_path / "old.safetensors")
    monkeypatch.setitem(checkpoint.MIGRATIONS, 0, lambda meta, arrays: (meta | {"format": 3}, arrays))
    assert World.restore(tmp_path / "old.safetensors").digest() == World.restore(written).digest()


def test_writing_is_whole_or_not_at_all(menagerie, tmp_path, monkeypatch):
    world = World.from_config(menagerie(), policies="random")
    path = world.save(tmp_path / "w.safetensors")
    before, replace = path.read_bytes(), os.replace

    def fail(source, target):
        if str(target) == str(path):  # kernels that are compiled meanwhile are kept
            raise OSError(28, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="No space left"):
        world.run(1).save(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["w.safetensors"]


def test_the_head_says_what_it_is_without_reading_all(written):
    meta = checkpoint.describe(written)
    assert meta["clock"]["tick"] == 3
    assert meta["config"]["name"] == "menagerie"
    assert json.loads(json.dumps(meta)) == meta
