"""The pages of the environments say what the worlds say."""

import pytest

pytest.importorskip("gymnasium")

from ecs_eco.rl import ENVIRONMENTS
from tools import make_environments as tool


def test_the_pages_are_what_the_worlds_say_and_name_every_environment():
    pages = tool.pages()
    assert pages == {path.name: path.read_text(encoding="utf-8") for path in tool.PAGES.glob("*.md")}
    for name, (world, _) in ENVIRONMENTS.items():
        assert f"[ecs_eco/{name}]" in pages["index.md"]
        assert f'gymnasium.make("ecs_eco/{name}")' in pages[f"{world}.md"]


def test_a_page_lists_channels_options_reward_and_causes_of_death():
    deer = tool.pages()["predator_prey.md"].split("## ecs_eco/Wolf")[0]
    assert "| 3 | `grass_near` | 0 | 1 |" in deer
    assert "| 0 | `speed` | 0 `still`, 1 `walk`, 2 `run` |" in deer
    means = "wolf_smell is the mean of wolf_smell_1 and wolf_smell_2"
    assert f"Happiness is `energy - 0.3 * wolf_smell`, where {means}; it is at least -1." in deer
    assert "starved, too old, eaten by wolf" in deer
