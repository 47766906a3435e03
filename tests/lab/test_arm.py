"""Arms of a comparison: the world as it is, and under each treatment."""

from __future__ import annotations

from pathlib import Path

from ecs_eco.lab.treatments import arms_of


def test_each_treatment_is_an_arm_of_its_own() -> None:
    arms = arms_of(
        "predator-prey", ["seed=4"], ["random-policy", "species.deer.emits.deer_smell=0", "no-wolf"]
    )
    assert [(a.name, a.policies) for a in arms] == [
        ("world", "trained"),
        ("random-policy", "random"),
        ("species.deer.emits.deer_smell-0", "trained"),
        ("no-wolf", "trained"),
    ]
    assert {a.config.seed for a in arms} == {4}
    assert [a.config.species["deer"].emits["deer_smell"] for a in arms] == [1.0, 1.0, 0.0, 1.0]
    assert [a.config.species["wolf"].count > 0 for a in arms] == [True, True, True, False]


def test_a_treatment_may_concern_one_species_or_learning_or_how_a_world_is_built() -> None:
    arms = arms_of("reflexes", [], ["no-reflexes", "learning", "frozen"])
    assert [a.controls for a in arms] == [(), ("no-reflexes",), (), ()]
    assert [a.learn for a in arms] == [None, None, True, False]
    former = arms_of("reflexes", [], ["frozen-learning"])[1]
    assert (former.name, former.learn) == ("frozen", False)
    one = arms_of("predator-prey", [], ["random-policy:deer"])[1]
    assert one.policies == {"deer": "random"}
    assert one.name == "random-policy-deer"


def test_which_policies_an_arm_runs_with() -> None:
    arms = arms_of("predator-prey", [], ["random-policy", "random-policy:deer", "species.deer.count=50"])
    assert [arm.trained_species for arm in arms] == [["deer", "wolf"], [], ["wolf"], ["deer", "wolf"]]
    assert [arm.with_policies(Path("p")).policies for arm in arms[2:]] == [
        {"deer": "random", "wolf": "p"},
        "p",
    ]
