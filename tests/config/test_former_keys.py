"""Keys are also read by the names that they once had, and notes give the present ones."""

import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.config.edit import edited
from ecs_eco.config.loading import changed
from ecs_eco.config.notes import notes
from ecs_eco.engine.errors import ConfigError
from ecs_eco.genomes import Layout
from ecs_eco.genomes.models import Gene
from tests.conftest import MENAGERIE, merge

FELL = """
format = 1
name = "fell"
space = { size = [9.0, 9.0] }

[species.moss]
count = 2
body = { radius = 0.25 }

[species.moss.metabolism]
energy = 0.5
growth = { value = 0.05, search = [0.01, 0.1] }
"""


@pytest.fixture
def fell(tmp_path):
    def write(text=FELL):
        (tmp_path / "fell.toml").write_text(text)
        return tmp_path / "fell.toml"

    return write


def test_a_world_by_former_names_is_the_world_by_present_names(fell):
    former, present = load(fell()), load(fell(FELL.replace("growth", "photosynthesis")))
    assert former.species["moss"].metabolism.photosynthesis == 0.05
    assert former.resolved() == present.resolved()
    assert former.config_hash == present.config_hash
    assert [*former.search.ranges] == ["species.moss.metabolism.photosynthesis"]


def test_a_note_gives_the_present_name(fell):
    note = "species.moss.metabolism.photosynthesis is the present name of growth"
    assert note in notes(load(fell()))
    assert note not in notes(load(fell(FELL.replace("growth", "photosynthesis"))))
    assert note in notes(load(fell(FELL.replace("growth", "basal")), ["species.moss.metabolism.growth=0.1"]))


def test_a_value_is_set_by_either_name_whichever_the_file_has(fell):
    for text in (FELL, FELL.replace("growth", "photosynthesis")):
        for word in ("growth", "photosynthesis"):
            config = load(fell(text), {f"species.moss.metabolism.{word}": 0.07})
            assert config.species["moss"].metabolism.photosynthesis == 0.07
    table = load(fell(), {"species.moss.metabolism": {"growth": 0.02}})
    assert table.species["moss"].metabolism.photosynthesis == 0.02


def test_a_living_world_is_changed_by_a_former_name(fell):
    world = World.from_config(fell())
    world.intervene({"kind": "set", "at": 0, "set": {"species.moss.metabolism.growth": 0.09}})
    world.run(1)
    assert world.config.species["moss"].metabolism.photosynthesis == 0.09
    now = changed(world.config, {"species.moss.metabolism.growth": 0.01})
    assert now.species["moss"].metabolism.photosynthesis == 0.01


def test_a_problem_of_a_former_name_has_its_line(fell):
    with pytest.raises(ConfigError) as error:
        load(fell(FELL.replace("value = 0.05", "value = -1.0")))
    assert "line 12: species.moss.metabolism.photosynthesis = -1.0" in str(error.value)


def test_a_key_by_both_names_is_refused(fell):
    with pytest.raises(ConfigError, match=r"photosynthesis = 0\.02\s+is given twice: also .* growth"):
        load(fell(FELL + "photosynthesis = 0.02\n"))


def test_the_text_of_a_file_keeps_its_former_name_when_the_value_changes():
    key = ("species", "moss", "metabolism", "photosynthesis")
    assert edited(FELL, {key: 0.08}) == FELL.replace("value = 0.05", "value = 0.08")


def test_a_gene_codes_for_a_trait_by_its_former_name():
    genes = [{"name": "rest", "trait": "metabolism.digestion", "letters": 2, "low": 1.0, "high": 2.0}]
    former = load(merge(MENAGERIE, {"species": {"lynx": {"genome": {"genes": genes}}}}))
    assert former.species["lynx"].genome.genes[0].trait == "metabolism.handling_time"
    genes[0]["trait"] = "metabolism.handling_time"
    present = load(merge(MENAGERIE, {"species": {"lynx": {"genome": {"genes": genes}}}}))
    assert former.config_hash == present.config_hash


def test_reproduction_that_was_called_simplified_is_asexual_at_any_place():
    way = {"rate": 0.02, "energy_min": 0.6, "energy_given": 0.3, "spacing": 2.0}
    former = load(merge(MENAGERIE, {"species": {"lynx": {"reproduction": way | {"kind": "simplified"}}}}))
    asexual = way | {"kind": "asexual", "place": "anywhere"}
    present = load(merge(MENAGERIE, {"species": {"lynx": {"reproduction": asexual}}}))
    assert former.config_hash == present.config_hash
    note = 'species.lynx.reproduction: write kind = "asexual", place = "anywhere" for simplified'
    assert note in notes(former)
    assert note not in notes(present)


def test_a_former_kind_is_not_suggested():
    way = {"kind": "simple", "rate": 0.02, "energy_min": 0.6, "energy_given": 0.3}
    with pytest.raises(ConfigError) as error:
        load(merge(MENAGERIE, {"species": {"lynx": {"reproduction": way}}}))
    assert 'unknown kind; expected: asexual, spread, sexual; did you mean "asexual"?' in str(error.value)


def test_hyperparameters_have_their_former_names_in_the_hash_alone():
    former, present = (
        load(merge(MENAGERIE, {"species": {"ram": {"ppo": {name: 0.03}}}}))
        for name in ("entropy", "entropy_coef")
    )
    assert former.species["ram"].ppo["entropy_coef"] == 0.03
    assert former.config_hash == present.config_hash
    assert "species.ram.ppo: entropy is called entropy_coef here" in notes(former)


def test_sections_in_python_take_former_names():
    assert Gene(name="size", letters=1, low=0.0, high=3.0, dominance="mean").expression == "mean"
    assert Layout([Gene(name="size", letters=1, low=0.0, high=3.0)], dominance="mean").expression == "mean"
