"""What `ecs-eco doctor` examines: threads, checkpoints, and the digests of the release."""

import json
import re

from ecs_eco.compiled import portable
from ecs_eco.testing.self_test import DIGESTS, Case, Outcome, cases, differing, released
from ecs_eco.testing.target import COMPUTING, instructions, target

HERE = target()


def test_every_shipped_world_is_examined_learning_and_not():
    from ecs_eco.config.shipped import shipped

    assert {(case.world, case.learn) for case in cases()} == {
        (world, learn) for world in shipped() for learn in (False, True)
    }


def test_the_digests_of_the_release_are_those_of_the_cases_there_are():
    content = json.loads(DIGESTS.read_text())
    assert set(content) == {"release", "targets"}
    for key, part in content["targets"].items():
        assert set(part) == {"target", "digests"}
        assert set(part["digests"]) == {case.name for case in cases()}
        assert all(re.fullmatch("[0-9a-f]{64}", digest) for digest in part["digests"].values())
        assert part["target"]["cpu"] in key


def test_a_target_is_named_by_processor_and_versions():
    assert target() == HERE
    assert instructions()[1] in HERE.key
    for name in COMPUTING:
        assert f"{name} {HERE.versions[name]}" in HERE.key


def test_what_differs_from_the_release_is_named_and_unknown_targets_are_unknown(monkeypatch):
    known = {HERE.key: {"a, learning": "1", "b, learning": "2"}}
    monkeypatch.setattr("ecs_eco.testing.self_test.released", lambda: known)
    outcomes = [
        Outcome(Case(name, True), digest, digest, digest)
        for name, digest in (("a", "1"), ("b", "3"), ("c", "4"))
    ]
    assert differing(outcomes, HERE) == ["b, learning", "c, learning"]
    assert differing(outcomes[:1], HERE) == []
    assert differing(outcomes, HERE._replace(cpu="abacus")) is None
    monkeypatch.undo()
    assert isinstance(released(), dict)


def test_compilation_switched_off_is_another_target(monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    assert target().key != HERE.key


def test_the_portable_target_of_any_machine_is_one_of_the_release(monkeypatch):
    """Its line is the key under which digests are stored; versions may be newer than the stored ones."""
    monkeypatch.setattr(portable, "_on", True)
    here = target()._replace(system="x86_64")
    stored = [key.partition(";")[0] for key in released()]
    assert here.key.partition(";")[0] in stored
