"""What a study says before it is run: read, refused where it lacks something, and kept with the result."""

import json
import subprocess

import pytest

from studies.common.registration import registration
from studies.common.study import Study, verdict

FILE = """
name = "drift"
claim = "Genes drift."
ticks = 100
seeds = { world = [1, 2] }
[arms.plain]
[hypotheses.lost]
statement = "runs that lose an allele"
statistic = "studies.drift:lost"
replicate = "world seed"
goal = "most"
"""


def written(folder, text=FILE):
    (folder / "drift.toml").write_text(text)
    return folder


def git(folder, *words):
    subprocess.run(
        ["git", "-c", "user.name=A", "-c", "user.email=a@b", *words],
        cwd=folder,
        check=True,
        capture_output=True,
        timeout=60,
    )


def test_a_hypothesis_is_decided_in_its_own_words(tmp_path):
    drift = registration("drift", written(tmp_path))
    line = drift.verdict("lost", "2 of 2", True)
    assert line == {
        "statement": "runs that lose an allele",
        "value": "2 of 2",
        "goal": "most",
        "met": True,
        "registered": "lost",
    }
    assert drift.arms == {"plain": {}}
    with pytest.raises(ValueError, match="no hypothesis 'loss'; registered are lost; did you mean 'lost'"):
        drift.verdict("loss", 0, False)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('goal = "most"', ""), "hypotheses.lost.goal is missing"),
        (("ticks = 100", ""), "ticks is missing"),
        (("studies.drift:lost", "lost"), "expected module:function"),
        (('name = "drift"', 'name = "drifts"'), "name is 'drifts'; expected 'drift'"),
        (('name = "drift"', "name = drift"), "drift.toml"),
    ],
)
def test_a_file_that_lacks_something_is_refused(tmp_path, change, words):
    with pytest.raises(ValueError, match=words):
        registration("drift", written(tmp_path, FILE.replace(*change)))


def test_a_name_that_is_not_there_is_refused_with_the_nearest(tmp_path):
    with pytest.raises(ValueError, match="did you mean 'drift'"):
        registration("drfit", written(tmp_path))


def test_what_is_registered_is_committed_before_a_study_runs(tmp_path):
    git(tmp_path, "init", "-q")
    drift = registration("drift", written(tmp_path))
    study = Study(
        name="drift",
        claim="Genes drift.",
        config={"ticks": 1},
        cases=[{"seed": 1}],
        run=lambda config, case: {"lost": 1},
        registered=drift,
        summarise=lambda cases: [
            drift.verdict("lost", "1 of 1", True),
            verdict("beside it", 1, "reported", True),
        ],
    )
    with pytest.raises(RuntimeError, match="commit it before you run"):
        study.execute(results=tmp_path)
    git(tmp_path, "add", "drift.toml")
    git(tmp_path, "commit", "-qm", "what will be found")
    result = study.execute(results=tmp_path)
    assert result["registration"]["sha256"] == drift.sha256
    assert len(result["registration"]["commit"]) == 40
    assert [line.get("registered") for line in result["verdicts"]] == ["lost", None]
    assert result["config"]["registered"] == drift.sha256
    written(tmp_path, FILE + "# changed\n")
    with pytest.raises(RuntimeError, match="commit it before you run"):
        study.execute(results=tmp_path)


def test_another_registration_makes_all_cases_stale(tmp_path):
    git(tmp_path, "init", "-q")
    ran = []

    def study():
        drift = registration("drift", tmp_path)
        git(tmp_path, "add", "drift.toml")
        git(tmp_path, "commit", "-qm", "registered")
        return Study(
            name="drift",
            claim="Genes drift.",
            config={},
            cases=[{"seed": 1}],
            registered=drift,
            run=lambda config, case: ran.append(1) or {},
            depends=lambda config, case: {},
            summarise=lambda cases: [drift.verdict("lost", 1, True)],
        )

    written(tmp_path)
    study().execute(results=tmp_path)
    written(tmp_path, FILE.replace("most", "all"))
    study().execute(results=tmp_path)
    assert len(ran) == 2
    assert json.loads((tmp_path / "drift.json").read_text())["verdicts"][0]["goal"] == "all"
