"""ecs-eco doctor: what it says, and its exit codes."""

import pytest
from typer.testing import CliRunner

from ecs_eco.cli import app
from ecs_eco.testing import self_test
from ecs_eco.testing.self_test import Case, Outcome
from ecs_eco.testing.target import target

NAME = "predator-prey, learning"


@pytest.fixture
def doctor(monkeypatch):
    """The command, with a self-test that came to what is asked for."""

    def called(digest="a" * 64, two_threads="a" * 64, resumed="a" * 64, release=None):
        monkeypatch.setattr(self_test, "cases", lambda: [Case("predator-prey", True)])
        monkeypatch.setattr(self_test, "examine", lambda case: Outcome(case, digest, two_threads, resumed))
        monkeypatch.setattr(self_test, "released", lambda: release or {})
        result = CliRunner().invoke(app, ["doctor", "--quiet"])
        return result.exit_code, result.output

    return called


def test_it_says_what_results_depend_on():
    result = CliRunner().invoke(app, ["doctor", "--no-test"])
    assert result.exit_code == 0, result.output
    here = target()
    for word in (
        "ecs-eco",
        here.cpu,
        here.torch,
        *here.versions.values(),
        "cache",
        "mode 0700",
        "owner",
        "GB",
        "browser",
        "threads",
        "tested with numba",
    ):
        assert word in result.output, word
    assert "Self-test" not in result.output


def test_results_as_released_are_exit_code_0(doctor):
    code, output = doctor(release={target().key: {NAME: "a" * 64}})
    assert code == 0
    assert "and agree with the release" in output
    assert "aaaaaaaaaaaa" in output


def test_an_unknown_target_is_said_and_exit_code_0(doctor):
    code, output = doctor()
    assert code == 0
    assert "Unknown target" in output
    assert target().key in output
    assert "same with one thread, with two, and from a checkpoint." in output


def test_other_results_than_those_of_the_release_are_exit_code_1(doctor):
    code, output = doctor(release={target().key: {NAME: "b" * 64}})
    assert code == 1
    assert f"Results differ from those of the release on this kind of machine: {NAME}" in output


@pytest.mark.parametrize("other", ["two_threads", "resumed"])
def test_results_that_depend_on_threads_or_checkpoints_are_exit_code_1(doctor, other):
    for release in (None, {target().key: {NAME: "a" * 64}}):
        code, output = doctor(**{other: "c" * 64}, release=release)
        assert code == 1
        assert f"depend on threads or checkpoints: {NAME}" in output


def test_a_cache_that_is_not_used_is_said_with_the_reason(monkeypatch, tmp_path):
    from ecs_eco.compiled import jit
    from ecs_eco.compiled.kernel_folder import Folder

    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(0o777)
    monkeypatch.setattr(jit, "FOLDER", Folder(tmp_path / "cache"))
    result = CliRunner().invoke(app, ["doctor", "--no-test"])
    assert result.exit_code == 0, result.output
    assert "NOT USED" in result.output
    assert "mode 0777" in result.output
