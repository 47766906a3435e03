"""ecs-eco cache: show, warm and clear."""

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.compiled import kernel_folder
from ecs_eco.worlds import first_start


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with two kernels, and that of another version with one."""
    here, other = tmp_path / "kernels-2", tmp_path / "kernels-1"
    for path in (here / "a.nbc", here / "b.nbc", here / "lamb.warm", other / "a.nbc", other / "a.claim"):
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(bytes(500_000))
    monkeypatch.setattr(kernel_folder, "cache_folder", lambda: here)
    return here


def invoke(*words, code=0):
    done = CliRunner().invoke(app, ["cache", *words])
    assert done.exit_code == code, done.output + repr(done.exception)
    return done.output


def test_show_counts_kernels_of_this_version_and_of_others(folder):
    shown = invoke("show")
    assert f"{folder}\n  2 kernels, 1.0 MB\n  complete for lamb\n" in shown
    assert f"{folder.with_name('kernels-1')}, from another version" in shown
    assert "1 kernels, 0.5 MB" in shown


def test_clear_removes_what_is_ours_and_nothing_else(folder):
    (folder / "mine.txt").write_text("kept")
    assert "1 kernels removed" in invoke("clear", "--others")
    assert not folder.with_name("kernels-1").exists()
    assert (folder / "a.nbc").exists()
    said = invoke("clear")
    assert "2 kernels removed" in said
    assert f"{folder} was not removed" in said
    assert [path.name for path in folder.iterdir()] == ["mine.txt"]
    assert "0 kernels removed" in invoke("clear")


def test_warm_compiles_what_is_listed_of_the_worlds_that_are_named(folder, monkeypatch):
    asked = []
    monkeypatch.setattr(first_start, "warm", lambda worlds, processes, bar: asked.append((worlds, processes)))
    assert "0 kernels compiled, 2 in total in" in invoke("warm", "lamb", "--workers", "3", "--quiet")
    invoke("warm", "--workers", "1")
    assert asked[0] == (["lamb"], 3)
    assert asked[1] == (sorted(first_start.shipped()), 1)


def test_an_unknown_world_is_refused_before_anything_is_compiled(folder, monkeypatch):
    monkeypatch.setattr(first_start, "warm", lambda *_: pytest.fail("compiled"))
    assert "lamb" in invoke("warm", "lamp", code=2)
