"""The harness of the studies and the page made of their results, run as a user runs them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SCRIPT = """
import os
from studies.common.study import Study, verdict

def run(config, case):
    with open(os.environ["LOG"], "a") as log:
        log.write(f"{case['seed']}\\n")
    if os.environ.get("FAIL") == str(case["seed"]):
        raise RuntimeError("no luck")
    return {"value": config["scale"] * case["seed"], "missing": float("nan")}

def summarise(cases):
    total = sum(entry["result"]["value"] for entry in cases)
    return {"verdicts": [verdict("the sum | of all", total, "above 10", total > 10)],
            "table": {"head": ["seed", "value"],
                      "rows": [[e["case"]["seed"], e["result"]["value"]] for e in cases]}}

STUDY = Study(name="sums", claim="Sums are large.", config={"scale": float(os.environ.get("SCALE", 2))},
              cases=[{"seed": s} for s in (1, 2, 3, 5)], short_config={"scale": 1}, run=run,
              summarise=summarise)

if __name__ == "__main__":
    STUDY.main()
"""


class Study:
    """A study script in a folder of its own."""

    def __init__(self, folder: Path):
        self.folder, self.result, self.log = folder, folder / "results" / "sums.json", folder / "log"
        (folder / "sums.py").write_text(SCRIPT)

    def run(self, *words: str, **environment: str) -> subprocess.CompletedProcess:
        env = (
            os.environ
            | {"PYTHONPATH": str(ROOT), "LOG": str(self.log), "TMPDIR": str(self.folder)}
            | environment
        )
        if "--short" not in words:
            words = ("--results", str(self.result.parent), *words)
        return subprocess.run(
            [sys.executable, self.folder / "sums.py", *words],
            env=env,
            capture_output=True,
            text=True,
            check=False,
        )

    def ran(self) -> list[int]:
        seeds = [int(x) for x in self.log.read_text().split()] if self.log.exists() else []
        self.log.unlink(missing_ok=True)
        return seeds

    def read(self) -> dict:
        return json.loads(self.result.read_text())


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return Study(tmp_path)


def test_a_result_holds_the_cases_and_where_they_come_from(study: Study) -> None:
    done = study.run()
    assert done.returncode == 0, done.stderr
    assert "met      the sum | of all: 22.0 (goal: above 10)" in done.stdout
    record = study.read()
    assert [entry["result"] for entry in record["cases"]] == [
        {"value": 2.0 * s, "missing": None} for s in (1, 2, 3, 5)
    ]
    assert record["seeds"] == [1, 2, 3, 5]
    assert record["complete"] is True
    assert record["command"] == "python -m studies.sums"
    assert len(record["config_hash"]) == 64
    assert record["versions"]["python"]
    assert [p.name for p in study.result.parent.iterdir()] == ["sums.json"]


@pytest.mark.slow
def test_finished_cases_are_kept_when_one_fails_and_not_run_again(study: Study) -> None:
    failed = study.run(FAIL="3")
    assert failed.returncode == 1
    assert "no luck" in failed.stdout
    assert not study.result.exists()
    assert study.ran() == [1, 2, 3, 5]
    assert study.run().returncode == 0
    assert study.ran() == [3]
    assert study.run().returncode == 0
    assert study.ran() == []
    assert study.run("--fresh").returncode == 0
    assert study.ran() == [1, 2, 3, 5]


def test_a_fresh_run_that_was_interrupted_keeps_no_earlier_case(study: Study) -> None:
    study.run()
    study.ran()
    assert study.run("--fresh", FAIL="3").returncode == 1
    assert study.ran() == [1, 2, 3, 5]
    assert study.run().returncode == 0
    assert study.ran() == [3]  # not the 3 of the first run
    assert study.run().returncode == 0
    assert study.ran() == []


def test_another_configuration_runs_all_cases_again(study: Study) -> None:
    study.run()
    before = study.read()["config_hash"]
    study.ran()
    study.run(SCALE="3")
    assert study.ran() == [1, 2, 3, 5]
    assert study.read()["config_hash"] != before


def test_workers_give_the_same_result(study: Study) -> None:
    study.run()
    alone = study.read()
    done = study.run("--fresh", "--workers", "2")
    assert done.returncode == 0, done.stderr
    together = study.read()
    assert sorted(study.ran()) == [1, 1, 2, 2, 3, 3, 5, 5]
    assert [(e["case"], e["result"]) for e in together["cases"]] == [
        (e["case"], e["result"]) for e in alone["cases"]
    ]


def test_the_short_form_leaves_the_result_alone(study: Study) -> None:
    study.run()
    before = study.result.read_bytes()
    study.ran()
    done = study.run("--short")
    assert done.returncode == 0, done.stderr
    assert study.ran() == [1, 2]
    assert study.result.read_bytes() == before
    (short,) = study.folder.glob("ecs-eco-study-*/sums.short.json")
    assert json.loads(short.read_text())["short"] is True
    assert not list((ROOT / "studies" / "results").glob("sums*"))


def test_misuse_is_refused(study: Study) -> None:
    assert "--workers: expected 1 or more, got 0" in study.run("--workers", "0").stderr
    script = study.folder / "sums.py"
    script.write_text(SCRIPT.replace("(1, 2, 3, 5)", "(1, 2, 1)"))
    assert "the case {'seed': 1} twice" in study.run().stderr
    script.write_text(
        SCRIPT.replace('verdict("the sum | of all", total, "above 10", total > 10)', '{"statment": 1}')
    )
    assert "did you mean 'statement'" in study.run().stderr
    assert study.result.with_suffix(".partial.json").exists()  # the cases are not lost


def sums_page(study: Study) -> str:
    return (study.folder / "docs" / "evidence" / "sums.md").read_text()


def make_page(study: Study, *words: str) -> subprocess.CompletedProcess:
    template = study.folder / "template.md"
    template.write_text("# Evidence\n\n{studies}\n")
    paths = ("--results", study.result.parent, "--docs", study.folder / "docs", "--template", template)
    return subprocess.run(
        [sys.executable, "tools/make_results.py", *map(str, paths), *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_the_page_tells_the_results_and_notices_when_it_is_stale(study: Study) -> None:
    study.run()
    assert make_page(study, "--check").returncode == 1
    assert make_page(study).returncode == 0
    assert make_page(study, "--check").returncode == 0
    page = sums_page(study)
    assert "| passed | the sum \\| of all | 22 | above 10 |" in page
    assert "| cases | 4 |\n| seeds | 1–3, 5 |" in page
    study.run(SCALE="1")
    stale = make_page(study, "--check")
    assert stale.returncode == 1
    assert "run python tools/make_results.py" in stale.stderr
    make_page(study)
    assert "1 of 1 goals passed" in sums_page(study)


def test_the_page_says_when_a_goal_was_not_met_and_when_there_is_nothing(study: Study) -> None:
    study.run(SCALE="0.1")
    make_page(study)
    assert "| **failed** |" in sums_page(study)
    study.result.unlink()
    make_page(study)
    assert not (study.folder / "docs" / "evidence" / "sums.md").exists()
    assert "sums" not in (study.folder / "docs" / "evidence" / "index.md").read_text()


def test_a_result_of_another_form_is_refused_by_name(study: Study) -> None:
    study.result.parent.mkdir()
    study.result.write_text('{"claim": "x"}')
    done = make_page(study)
    assert done.returncode == 1
    assert "sums.json lacks name, complete" in done.stderr


def test_what_was_measured_without_a_claim_is_left_out(study: Study) -> None:
    study.run()
    make_page(study)
    (study.result.parent / "repeated.json").write_text('{"runs": []}')
    assert make_page(study, "--check").returncode == 0


@pytest.mark.slow
def test_the_committed_page_is_what_the_results_say() -> None:
    assert (
        subprocess.run([sys.executable, "tools/make_results.py", "--check"], cwd=ROOT, check=False).returncode
        == 0
    )
