"""What a world file may not say of sexual reproduction."""

import pytest

from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.systems import Mate
from tests.systems.couples import WAY


@pytest.mark.parametrize(
    ("changes", "key", "what", "allowed"),
    [
        ({"sex": "female"}, "sex", "there are no mates", "random, or none"),
        ({"sex": "male"}, "sex", "there are no mates", "random, or none"),
        (
            {"reproduction": {"reach": 10.1}},
            "reproduction.reach",
            "larger than half the width of the torus",
            "at most 10 m",
        ),
        ({"reproduction": {"reach": -1.0}}, "reproduction.reach", "", "at least 0"),
        ({"reproduction": {"chance": 1.1}}, "reproduction.chance", "", "at most 1"),
        ({"reproduction": {"father_share": -0.1}}, "reproduction.father_share", "", "at least 0"),
        (
            {"reproduction": {"father_share": 1.0, "litter": 4}},
            "reproduction.father_share",
            "no father can pay",
            "less than 1, or",
        ),
        (
            {"reproduction": {"energy_given": 1.0}},
            "reproduction.energy_given",
            "no mother can pay",
            "less than 1",
        ),
        (
            {"reproduction": {"energy_given": 1.1}},
            "reproduction.energy_given",
            "more than energy_max",
            "at most 1",
        ),
        (
            {"reproduction": {"energy_min": 1.1}},
            "reproduction.energy_min",
            "more than energy_max",
            "at most 1",
        ),
        ({"reproduction": {"consent": "all"}}, "reproduction.consent", "", "both, one, none"),
        ({"reproduction": {"choice": "richer"}}, "reproduction.choice", "", 'did you mean "richest"'),
        ({"reproduction": {"gestation": -1.0}}, "reproduction.gestation", "", "at least 0"),
        ({"reproduction": {"rest": -1.0}}, "reproduction.rest", "", "at least 0"),
        ({"reproduction": {"father_rest": -1.0}}, "reproduction.father_rest", "", "at least 0"),
        ({"reproduction": {"litter": 0}}, "reproduction.litter", "", "at least 1"),
        ({"reproduction": {"litter": 1.5}}, "reproduction.litter", "", "whole number"),
        ({"reproduction": {"place": "far"}}, "reproduction.place", "", "near, anywhere"),
        (
            {"reproduction": {"dispersal": 10.1}},
            "reproduction.dispersal",
            "larger than half the width of the torus",
            "at most 10 m",
        ),
        (
            {"reproduction": {"dispersal": 1.0}},
            "reproduction.dispersal",
            "the mother's own body",
            "more than 1 m",
        ),
        ({"reproduction": {"spacing": 2.0}}, "reproduction.spacing", "closer than this", "less than 2 m"),
        ({"reproduction": {"rate": 0.1}}, "reproduction.rate", "unknown key", "energy_min"),
        (
            {"reproduction": None, "actions": {"mate": ["mate"]}},
            "actions.mate",
            "not reproduce sexually",
            'kind = "sexual"',
        ),
        ({"actions": {"mate": ["meet"]}}, "actions.mate.0", "no action with this name", "mate"),
    ],
)
def test_what_cannot_be_is_refused(meadow, changes, key, what, allowed):
    with pytest.raises(ConfigError) as refused:
        _couples_config(meadow, **changes)
    assert len(refused.value.problems) == 1, refused.value
    problem = refused.value.problems[0]
    assert problem.path == f"species.deer.{key}"
    assert what in problem.what
    assert allowed in str(problem)


def _couples_config(meadow, reproduction=(), **changes):
    way = None if reproduction is None else WAY | dict(reproduction)
    return meadow(**{"sex": "random", "reproduction": way} | changes)


def test_the_mate_action_needs_reproduction_that_is_sexual_or_a_system_of_ones_own(meadow):
    way = {"kind": "asexual", "rate": 0.1, "energy_min": 0.5, "energy_given": 0.25}
    with pytest.raises(
        ConfigError,
        match=r"species.deer.actions.mate = .*\n.*expected: "
        r'reproduction.kind = "sexual", or remove this action group',
    ):
        meadow(reproduction=way, actions={"mate": ["mate"]})
    config = meadow(reproduction=way).config.model_dump()
    config["species"]["deer"]["actions"]["mate"] = ["mate"]
    assert "mate" in load(config, systems=[Courting]).species["deer"].actions


class Courting(Mate):
    """A system of one's own that carries out the action."""

    acts = ("mate",)


def test_what_is_left_out_has_its_default(meadow):
    way = (
        meadow(sex="random", reproduction={"kind": "sexual", "energy_min": 0.5, "energy_given": 0.25})
        .config.species["deer"]
        .reproduction
    )
    assert way.model_dump(exclude={"kind", "energy_min", "energy_given"}) == {
        "father_share": 0.0,
        "reach": 0.0,
        "chance": 1.0,
        "consent": "both",
        "choice": "nearest",
        "gestation": 0.0,
        "rest": 0.0,
        "father_rest": 0.0,
        "place": "near",
        "dispersal": None,
        "age_min": 0.0,
        "litter": 1,
        "spacing": 0.0,
    }
