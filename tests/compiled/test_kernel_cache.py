"""Compiled kernels on disk: nobody else's are loaded, damaged ones are compiled again,
and a full disk stops nothing."""

import errno
import os
import runpy
import stat
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from ecs_eco.compiled import jit, kernel_cache as module, kernel_folder
from ecs_eco.compiled.kernel_cache import KernelCache
from ecs_eco.compiled.kernel_folder import Folder, why_not_private
from ecs_eco.compiled.numba_version import plain

pytestmark = pytest.mark.skipif(plain(), reason="public numba compiles")

KERNEL = """
from ecs_eco.compiled.jit import njit

@njit
def triple(x):
    return 3 * x

value = triple(2.0)
hits, misses = (sum(found.values()) for found in (triple.stats.cache_hits, triple.stats.cache_misses))
"""

pytestmark = pytest.mark.skipif(os.name != "posix", reason="owners and modes of files are those of POSIX")


@pytest.fixture
def start(tmp_path, monkeypatch):
    """Import a kernel and call it, as a new process would: whether it was found or compiled,
    and what was warned of."""
    script = tmp_path / "kernel.py"
    script.write_text(KERNEL)

    def starts():
        monkeypatch.setattr(jit, "FOLDER", Folder(tmp_path / "cache" / "kernels-1"))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            namespace = runpy.run_path(str(script))
        assert namespace["value"] == 6.0
        return ("found" if namespace["hits"] else "compiled"), [str(warning.message) for warning in caught]

    starts.cache, starts.script = tmp_path / "cache", script
    starts.files = lambda: sorted(starts.cache.glob("kernels-*/*"))
    return starts


def process(tmp_path, before="", **more):
    """The same in a process of its own; what it wrote to stderr."""
    (tmp_path / "kernel.py").write_text(KERNEL)
    code = (
        f"{before}\nimport runpy; found = runpy.run_path({str(tmp_path / 'kernel.py')!r}); "
        "print(found['value'], found['hits'])"
    )
    environment = {**os.environ, "ECS_ECO_CACHE": str(tmp_path / "cache"), **more}
    namespace = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=300
    )
    assert namespace.returncode == 0, namespace.stderr
    value, hits = namespace.stdout.split()
    assert value == "6.0"
    return ("found" if hits == "1" else "compiled"), namespace.stderr


def test_a_kernel_is_compiled_once(start):
    assert start() == ("compiled", [])
    assert start() == ("found", [])
    (file,) = start.files()
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert stat.S_IMODE(file.parent.stat().st_mode) == 0o700
    assert stat.S_IMODE(start.cache.stat().st_mode) == 0o700


def test_a_changed_source_is_compiled_anew(start):
    start()
    start.script.write_text(KERNEL.replace("3 * x", "2 * x + x"))
    assert start() == ("compiled", [])


@pytest.mark.slow
def test_other_switches_of_the_compiler_are_other_kernels(tmp_path):
    assert process(tmp_path) == ("compiled", "")
    assert process(tmp_path, NUMBA_BOUNDSCHECK="1") == ("compiled", "")
    assert process(tmp_path) == ("found", "")


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: content[: len(content) // 2],
        lambda content: content[:-1],
        lambda content: content[:10],
        lambda content: content + b"x",
        lambda content: bytes(len(content)),
        lambda content: content[:-500] + bytes([content[-500] ^ 1]) + content[-499:],
        lambda content: bytes([content[0] ^ 1]) + content[1:],
        lambda content: b"\x80\x04N." * 100,
    ],
    ids=[
        "emptied",
        "half",
        "a byte less",
        "ten bytes",
        "a byte more",
        "zeros",
        "a bit of the code",
        "of the seal",
        "a pickle",
    ],
)
def test_a_damaged_file_is_compiled_again_without_a_word(start, damage):
    start()
    (file,) = start.files()
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    assert start() == ("compiled", [])
    assert start() == ("found", [])
    assert len(start.files()) == 1


def test_a_file_under_the_name_of_another_kernel_is_not_taken(start):
    start()
    start.script.write_text(KERNEL.replace("3 * x", "3.0 * x"))
    start()
    one, two = start.files()
    for file, other in ((one, two.read_bytes()), (two, one.read_bytes())):
        file.write_bytes(other)
    assert start() == ("compiled", [])


def test_nothing_that_is_no_file_of_ours_is_opened(start):
    start()
    (file,) = start.files()
    for put in (os.mkfifo, os.mkdir, lambda path: os.symlink("/dev/zero", path)):
        file.rename(aside := file.with_suffix(".aside"))
        put(file)
        with pytest.raises(OSError):  # noqa: PT011 (which one depends on what it is)
            module._read(file)
        file.rmdir() if file.is_dir() and not file.is_symlink() else file.unlink()
        aside.rename(file)


def test_a_full_disk_stops_no_kernel_and_leaves_nothing_half_written(start, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(module.os, "replace", fails(errno.ENOSPC))
        where, (warning,) = start()
    assert where == "compiled"
    assert "compiled kernels are not cached" in warning
    assert "No space left" in warning
    assert start.files() == []
    assert start() == ("compiled", [])


def fails(number):
    def full(*_):
        raise OSError(number, os.strerror(number))

    return full


@pytest.mark.slow
def test_a_process_that_may_write_no_more_bytes_goes_on(tmp_path):
    where, warning = process(
        tmp_path, "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))"
    )
    assert where == "compiled"
    assert warning.count("RuntimeWarning") == 1
    assert "File too large" in warning
    assert list(tmp_path.glob("cache/*/*")) == []


@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o770, 0o733])
def test_a_folder_that_others_may_write_to_is_not_used(start, mode, monkeypatch):
    start()
    (file,) = start.files()
    file.parent.chmod(mode)
    if mode == 0o770:  # a group of others
        monkeypatch.setattr(kernel_folder, "_is_own_group", lambda gid: False)
    written = file.stat().st_mtime_ns
    where, (warning,) = start()
    assert where == "compiled"
    assert f"others can write to {file.parent}" in warning
    assert "ECS_ECO_CACHE" in warning
    assert file.stat().st_mtime_ns == written


@pytest.mark.parametrize("mode", [0o755, 0o750, 0o711])
def test_a_folder_that_others_may_only_look_into_is_closed(start, mode):
    start()
    folder = start.files()[0].parent
    folder.chmod(mode)
    assert start() == ("found", [])
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_a_link_in_the_place_of_the_folder_is_not_followed(start, tmp_path):
    start()
    folder = start.files()[0].parent
    folder.rename(tmp_path / "elsewhere")
    folder.symlink_to(tmp_path / "elsewhere")
    where, (warning,) = start()
    assert where == "compiled"
    assert f"{folder} is a link" in warning


def test_a_folder_above_that_others_may_write_to_is_refused_unless_its_files_stay_their_owners(tmp_path):
    inner = tmp_path / "open" / "cache"
    inner.mkdir(parents=True, mode=0o700)
    inner.chmod(0o700)
    assert why_not_private(inner) == ""
    inner.parent.chmod(0o777)
    assert why_not_private(inner) == f"others can write to {inner.parent} (mode 0777)"
    inner.parent.chmod(0o1777)  # as /tmp: nobody else may rename or remove what is ours
    assert why_not_private(inner) == ""
    link = tmp_path / "link"
    link.symlink_to(inner.parent)
    assert why_not_private(link / "cache") == ""
    inner.parent.chmod(0o777)
    assert why_not_private(link / "cache") == f"others can write to {inner.parent} (mode 0777)"


def test_a_folder_of_another_user_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: tmp_path.stat().st_uid + 1)
    assert "belongs to user" in why_not_private(tmp_path)


def test_a_file_of_another_user_is_not_read(tmp_path, monkeypatch):
    (tmp_path / "kernel.nbc").write_bytes(b"")
    monkeypatch.setattr(os, "geteuid", lambda: tmp_path.stat().st_uid + 1)
    with pytest.raises(PermissionError, match="not ours"):
        module._read(tmp_path / "kernel.nbc")


def test_a_folder_that_cannot_be_made_is_said_once_and_kernels_run(tmp_path):
    (tmp_path / "file").write_text("")
    folder = Folder(tmp_path / "file" / "cache")
    with pytest.warns(RuntimeWarning, match="not cached.*Not a directory") as caught:
        assert not folder.usable()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not folder.usable()
        assert not folder.writable()
    assert len(caught) == 1


def test_a_group_of_the_user_alone_is_nobody_else(monkeypatch):
    import grp
    import pwd
    from types import SimpleNamespace

    monkeypatch.setattr(pwd, "getpwuid", lambda uid: SimpleNamespace(pw_name="ada"))
    for name, members, own in (
        ("ada", [], True),
        ("ada", ["ada"], True),
        ("ada", ["eve"], False),
        ("users", [], False),
    ):
        monkeypatch.setattr(
            grp,
            "getgrgid",
            lambda gid, name=name, members=members: SimpleNamespace(gr_name=name, gr_mem=members),
        )
        assert kernel_folder._is_own_group(5) is own


def test_a_kernel_without_a_source_file_is_compiled_and_not_kept():
    from ecs_eco import njit

    namespace: dict[str, object] = {"njit": njit}
    exec("@njit\ndef triple(x):\n    return 3 * x", namespace)
    assert namespace["triple"](2) == 6
    assert not isinstance(namespace["triple"].kept, KernelCache)


@pytest.mark.slow
def test_a_kernel_of_a_script_that_is_called_after_the_script_has_run(tmp_path):
    script = tmp_path / "kernel.py"
    script.write_text(
        "import os\nfrom ecs_eco import njit\n@njit\ndef triple(x):\n    return 3 * x\n"
        "early = triple(1) if 'EARLY' in os.environ else 3\n"
    )
    starter = f"import runpy\nprint(runpy.run_path({str(script)!r})['triple'](2))"
    for early in ({}, {}, {"EARLY": "1"}, {}):  # the third leaves a kernel of the module <run_path>
        done = subprocess.run(
            [sys.executable, "-c", starter],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, **early, "ECS_ECO_CACHE": str(tmp_path / "cache")},
        )
        assert (done.stdout, done.stderr) == ("6\n", "")


def test_disabled_compilation_leaves_plain_python():
    process_ = subprocess.run(
        [
            sys.executable,
            "-c",
            "from ecs_eco.systems.move import njit\n@njit\ndef f(x):\n    return x\nprint(f(7))",
        ],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert process_.stdout == "7\n"


LINKED = "ecs_eco.compiled.libm"  # parts of functions that `linking` keeps


def test_all_kernels_of_the_package_are_kept_in_it():
    import importlib

    from numba.core.dispatcher import Dispatcher

    from ecs_eco.compiled.kernel import called_by_python

    root, n_kernels = Path(module.__file__).parents[1], 0
    for path in root.rglob("*.py"):
        if "njit" in path.read_text() and path.name not in ("jit.py", "kernel_folder.py", "__init__.py"):
            name = ".".join(("ecs_eco", *path.relative_to(root).with_suffix("").parts))
            for kernel in map(called_by_python, vars(importlib.import_module(name)).values()):
                if isinstance(kernel, Dispatcher) and kernel.py_func.__module__ != LINKED:
                    assert isinstance(kernel.kept, KernelCache), (
                        f"{name}.{kernel.py_func.__name__}: compiled by numba's own njit"
                    )
                    n_kernels += 1
    assert n_kernels > 50


def test_which_error_it_was_is_said(tmp_path):
    folder = Folder(tmp_path / "cache")
    assert folder.writable()
    with pytest.warns(RuntimeWarning, match="Disk quota exceeded"):
        folder.stop_writing(OSError(errno.EDQUOT, os.strerror(errno.EDQUOT)))
    assert folder.usable()
    assert not folder.writable()
