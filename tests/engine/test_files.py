"""Files that are whole or as they were before."""

import errno
import os
import re
import signal
import stat
import subprocess

import numpy as np
import pytest
from safetensors.numpy import load_file

from ecs_eco.engine import files
from ecs_eco.engine.processes import python


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


LIMITED = """
import resource, signal, sys
import numpy as np
from ecs_eco.engine import files
signal.signal(signal.SIGXFSZ, signal.SIG_DFL if sys.argv[2] == "killed" else signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))
files.write_tensors(sys.argv[1], {"a": np.zeros(5_000)})
"""


def limited(path, how):
    """A process that writes more tensors than it may."""
    return subprocess.run(
        python(LIMITED.strip().replace("\n", "; "), str(path), how),
        capture_output=True,
        text=True,
        timeout=60,
    )


@pytest.mark.skipif(os.name != "posix", reason="limits are of POSIX")
def test_a_process_that_is_killed_while_it_writes_tensors_leaves_a_file_of_a_known_name(tmp_path):
    assert limited(tmp_path / "w.safetensors", "killed").returncode == -signal.SIGXFSZ
    (half,) = tmp_path.iterdir()
    assert files.written_beside(half) == "w.safetensors"


@pytest.mark.skipif(os.name != "posix", reason="limits are of POSIX")
def test_a_disk_that_is_full_is_an_os_error_of_the_file_for_tensors_too(tmp_path):
    done = limited(tmp_path / "w.safetensors", "refused")
    assert re.search(r"OSError: .*too large: '.*w\.safetensors'", done.stderr), done.stderr
    assert _names(tmp_path) == []


def test_tensors_are_read_by_the_library_as_they_were(tmp_path):
    kinds = ("?", "u1", "i1", "i2", "u2", "f2", "i4", "u4", "f4", "f8", "i8", "u8")
    arrays = {f"{kind} ü": np.arange(6).reshape(2, 3).astype(kind) for kind in kinds}
    arrays |= {
        "none": np.zeros((0, 3), np.float32),
        "one": np.array(7.5),
        "big": np.arange(3, dtype=">i4"),
        "turned": np.arange(6.0).reshape(2, 3).T,
    }
    path = files.write_tensors(tmp_path / "w.safetensors", arrays, {"b": "ü", "a": "1"})
    read = load_file(path)
    assert set(read) == set(arrays)
    for name, array in arrays.items():
        assert (read[name].dtype, read[name].shape) == (array.dtype.newbyteorder("="), array.shape)
        assert np.array_equal(read[name], array)
    others = dict(reversed(arrays.items()))
    assert path.read_bytes() == files.write_tensors(tmp_path / "x", others, {"a": "1", "b": "ü"}).read_bytes()


def test_tensors_are_written_with_their_metadata(tmp_path):
    path = files.write_tensors(tmp_path / "w.safetensors", {"a": np.arange(3.0)}, {"seal": "x"})
    assert load_file(path)["a"].tolist() == [0.0, 1.0, 2.0]
    assert b'"seal":"x"' in path.read_bytes()


def test_a_half_written_file_is_known_by_its_name(tmp_path):
    with files.writing(tmp_path / "manifest.json") as beside:
        assert files.written_beside(beside) == "manifest.json"
        assert _names(tmp_path) == [beside.name]
    for other in (
        "notes.tmp",
        ".notes.tmp",
        "manifest.tmp",
        ".manifest.json.1234",
        ".manifest.json.ecs-eco-12-ab.tmp",
    ):
        assert files.written_beside(tmp_path / other) is None
