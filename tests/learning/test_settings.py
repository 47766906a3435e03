import subprocess
import sys
from dataclasses import fields

import pytest

from ecs_eco.learning import PPO


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        ("horizon", 0, "a whole number >= 1"),
        ("horizon", 2.5, "a whole number >= 1"),
        ("epochs", True, "a whole number >= 1"),
        ("learning_rate", 0.0, "a finite number > 0"),
        ("learning_rate", float("nan"), "a finite number > 0"),
        ("discount", 1.01, "a finite number >= 0 and <= 1"),
        ("gae_lambda", "0.9", "a finite number >= 0 and <= 1"),
        ("normalise_advantage", 1, "true or false"),
    ],
)
def test_bad_value_is_named_with_what_is_allowed(name, value, allowed):
    with pytest.raises(ValueError, match="allowed") as error:
        PPO(**{name: value})
    assert f"PPO.{name} = {value!r}" in str(error.value)
    assert allowed in str(error.value)


def test_whole_numbers_become_floats_where_floats_are_meant():
    ppo = PPO(discount=1, clip_value=0)
    assert isinstance(ppo.discount, float)
    assert ppo == PPO(discount=1.0)


def test_every_field_is_documented():
    assert all(f.metadata["doc"] for f in fields(PPO))


def test_settings_load_neither_torch_nor_numba():
    code = ("import sys; from ecs_eco.learning import PPO; PPO(); print('torch' in sys.modules, "
            "'numba' in sys.modules)")
    assert (subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.split()
            == ["False", "False"])


def test_a_brain_thinks_without_torch():
    code = ("import sys, numpy; from ecs_eco.learning import Brain, vector_env; "
            "Brain(3, (2,)).forward(numpy.zeros((4, 3))); print('torch' in sys.modules)")
    assert (subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.split()
            == ["False"])


def test_unknown_name_lists_the_known_ones():
    import ecs_eco.learning

    with pytest.raises(AttributeError, match="Learner"):
        _ = ecs_eco.learning.Lerner
