"""Codes of causes of death."""

from ecs_eco.engine.codes import Codes


def test_a_new_cause_becomes_known_when_it_is_asked_for():
    causes = ["culled"]
    codes = Codes(causes)
    assert (codes["starved"], codes["culled"], codes["starved"]) == (2, 1, 2)
    assert causes == ["culled", "starved"]


def test_codes_follow_another_list_once_they_are_cleared():
    causes = ["culled", "starved"]
    codes = Codes(causes)
    assert codes["starved"] == 2
    causes[:] = ["culled", "drowned", "starved"]
    codes.clear()
    assert codes["starved"] == 3
