"""Results are of today's studies, and what is called registered was registered before."""

import importlib
import json
import shutil
import subprocess

import pytest

from studies.common.registration import FOLDER, registration
from studies.common.study import RESULTS

NAMES = sorted(
    path.stem
    for path in RESULTS.glob("*.json")
    if "verdicts" in json.loads(path.read_text()) and "." not in path.stem
)


def read(name):
    return json.loads((RESULTS / f"{name}.json").read_text())


@pytest.mark.parametrize("name", NAMES)
def test_a_result_is_of_the_study_as_it_is_today(name):
    study = importlib.import_module(f"studies.{name}").STUDY
    assert study.whole_config_hash() == read(name)["config_hash"], "run it again: it has changed"


@pytest.mark.parametrize("name", NAMES)
def test_only_what_was_registered_is_called_so(name):
    result = read(name)
    called = {line["registered"]: line for line in result["verdicts"] if "registered" in line}
    if "registration" not in result:
        assert not called
        return
    file = registration(name)
    assert result["registration"]["sha256"] == file.sha256
    assert set(called) == set(file.hypotheses)  # none is left out, however it ended
    for key, line in called.items():
        of = file.hypotheses[key]
        assert (line["statement"], line["goal"]) == (of["statement"], of["goal"])


@pytest.mark.parametrize("name", [name for name in NAMES if "registration" in read(name)])
def test_a_registration_is_older_than_its_first_result(name):
    result = read(name)
    registered = result["registration"]["commit"]
    if shutil.which("git") is None or not _in_history(registered):
        pytest.skip("no history of the sources is here, or none that goes back so far")
    # in this history, whatever became of the branch on which a case was run; a study may have been registered anew
    of = result["registration"]["sha256"]
    brought = _git("log", f"-S{of}", "--format=%H", "--", f"{name}.json").stdout.split()
    for commit in [*filter(_in_history, result["commits"]), *brought]:
        assert not _git("merge-base", "--is-ancestor", registered, commit).returncode, commit


def _in_history(commit):
    return not _git("merge-base", "--is-ancestor", commit, "HEAD").returncode


def _git(*words):
    return subprocess.run(
        ["git", *words], cwd=RESULTS, check=False, capture_output=True, text=True, timeout=60
    )


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.toml")))
def test_what_is_registered_can_be_read_and_its_statistics_exist(name):
    for of in registration(name).hypotheses.values():
        module, function = of["statistic"].split(":")
        assert callable(getattr(importlib.import_module(module), function))
