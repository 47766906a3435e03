"""Files that are whole or as they were before."""

import errno
import os
import stat

import numpy as np
import pytest
from safetensors import SafetensorError
from safetensors.numpy import load_file

from ecs_eco.engine import files


def _names(folder):
    return sorted(p.name for p in folder.iterdir())


def test_a_file_is_written_as_bytes_or_as_text(tmp_path):
    assert files.write(tmp_path / "a", b"\x00\xff").read_bytes() == b"\x00\xff"
    assert files.write(str(tmp_path / "b"), "größer\n").read_text(encoding="utf-8") == "größer\n"
    assert _names(tmp_path) == ["a", "b"]


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_a_file_is_as_it_was_where_writing_fails(tmp_path, monkeypatch, error):
    files.write(tmp_path / "a", "old")

    def full(_):
        raise error

    monkeypatch.setattr(files.os, "fsync", full)
    with pytest.raises(type(error)):
        files.write(tmp_path / "a", "new")
    assert (tmp_path / "a").read_text() == "old"
    assert _names(tmp_path) == ["a"]


def test_an_error_names_the_file_and_not_the_one_beside_it(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        files.write(tmp_path / "nowhere" / "a", "new")
    assert caught.value.filename == str(tmp_path / "nowhere" / "a")
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError, match="folder") as caught:
        files.write(tmp_path / "folder", "new")
    assert caught.value.filename == str(tmp_path / "folder")
    assert _names(tmp_path) == ["folder"]


@pytest.mark.skipif(os.name != "posix", reason="modes are of POSIX")
@pytest.mark.parametrize(("umask", "mode"), [(0o022, 0o644), (0o077, 0o600), (0o002, 0o664)])
def test_the_umask_gives_the_mode(tmp_path, umask, mode):
    before = os.umask(umask)
    try:
        files.write(tmp_path / "text", "x")
        files.write_tensors(tmp_path / "tensors", {"a": np.arange(3)})
    finally:
        os.umask(before)
    assert {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("text", "tensors")} == {mode}


def test_a_full_disk_is_an_os_error_for_tensors_too(tmp_path, monkeypatch):
    def full(*_, **__):
        raise SafetensorError("Error while serializing: I/O error: No space left on device (os error 28)")

    monkeypatch.setattr("safetensors.numpy.save_file", full)
    with pytest.raises(OSError, match="No space left on device") as caught:
        files.write_tensors(tmp_path / "w.safetensors", {"a": np.arange(3)})
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, str(tmp_path / "w.safetensors"))
    assert _names(tmp_path) == []


def test_tensors_are_written_with_their_metadata(tmp_path):
    path = files.write_tensors(tmp_path / "w.safetensors", {"a": np.arange(3.0)}, {"seal": "x"})
    assert load_file(path)["a"].tolist() == [0.0, 1.0, 2.0]
    assert b'"seal":"x"' in path.read_bytes()


def test_a_half_written_file_is_known_by_its_name(tmp_path):
    with files.writing(tmp_path / "manifest.json") as beside:
        assert files.written_beside(beside) == "manifest.json"
        assert _names(tmp_path) == [beside.name]
    for other in ("notes.tmp", ".notes.tmp", "manifest.tmp", ".manifest.json.1234",
                  ".manifest.json.ecs-eco-12-ab.tmp"):
        assert files.written_beside(tmp_path / other) is None
