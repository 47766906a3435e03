"""Alternative names for PPO's hyperparameters, used by Stable-Baselines3, CleanRL and papers."""

from __future__ import annotations

from collections.abc import Iterable

FORMER = {"entropy": "entropy_coef", "minibatch": "minibatch_size"}  # our former names → current names
ALIASES = FORMER | {  # their name → ours
    "gamma": "discount",
    "lr": "learning_rate",
    "batch_size": "minibatch_size",
    "n_steps": "horizon",
    "num_steps": "horizon",
    "n_epochs": "epochs",
    "update_epochs": "epochs",
    "lam": "gae_lambda",
    "ent_coef": "entropy_coef",
    "vf_coef": "value_weight",
    "clip_range": "clip",
    "clip_coef": "clip",
    "clip_range_vf": "clip_value",
    "norm_adv": "normalise_advantage",
    "normalize_advantage": "normalise_advantage",
    "adam_eps": "adam_epsilon",
}


def resolve(given: Iterable[str]) -> dict[str, str]:
    """Replace each alias among the settings with our name. Raises ValueError if a setting is given under two
    names."""
    names = list(given)
    known = {word: ALIASES[word] for word in names if word in ALIASES}
    for i, (word, name) in enumerate(known.items()):
        twice = name if name in names else next((w for w in [*known][:i] if known[w] == name), "")
        if twice:
            raise ValueError(f"{word} and {twice} are the same setting, {name}: pass only one")
    return known


def hint(word: str) -> str:
    """Return a hint for an accepted alias: the name of the setting in this package."""
    return f"{word} is called {ALIASES[word]} here"
