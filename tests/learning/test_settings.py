import subprocess
import sys
from dataclasses import fields

import pytest

from ecs_eco.learning import PPO
from ecs_eco.learning.aliases import ALIASES


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
    with pytest.raises(ValueError, match="expected") as error:
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
    code = (
        "import sys; from ecs_eco.learning import PPO; PPO(); print('torch' in sys.modules, "
        "'numba' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.split() == [
        "False",
        "False",
    ]


def test_a_brain_thinks_without_torch():
    code = (
        "import sys, numpy; from ecs_eco.learning import Brain, vector_env; "
        "Brain(3, (2,)).forward(numpy.zeros((4, 3))); print('torch' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.split() == [
        "False"
    ]


def test_unknown_name_lists_the_known_ones():
    import ecs_eco.learning

    with pytest.raises(AttributeError, match="Learner"):
        _ = ecs_eco.learning.Lerner


def test_the_words_of_others_are_taken_with_a_hint():
    with pytest.warns(UserWarning, match="PPO: gamma is called discount here"):
        assert PPO(gamma=0.9) == PPO(discount=0.9)
    with pytest.warns(UserWarning, match="is called .* here") as hints:
        ppo = PPO(lr=1e-3, batch_size=64, n_steps=16, ent_coef=0.0)
    assert (ppo.learning_rate, ppo.minibatch_size, ppo.horizon, ppo.entropy_coef) == (1e-3, 64, 16, 0.0)
    assert len(hints) == 4
    assert hints[0].filename == __file__
    assert set(ALIASES.values()) <= {f.name for f in fields(PPO)}
    with pytest.raises(ValueError, match="gamma and discount are the same setting"):
        PPO(gamma=0.9, discount=0.9)
    with pytest.raises(ValueError, match="clip_coef and clip_range are the same setting, clip"):
        PPO(clip_range=0.1, clip_coef=0.1)
    with pytest.raises(TypeError, match=r"unknown setting 'discont'.*discount"):
        PPO(discont=0.9)
