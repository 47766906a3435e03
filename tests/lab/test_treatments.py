"""Treatments: what each changes, and what is said where a world has nothing for it."""

from multiprocessing.reduction import ForkingPickler
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ecs_eco import World
from ecs_eco.cli import app
from ecs_eco.config import WorldConfig, load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab.comparison import Comparison
from ecs_eco.lab.treatments import TREATMENTS, NotApplicable, arms_of, check_training, find
from ecs_eco.life import treatments as at_build
from ecs_eco.view.inspect import state_of

SMALL = {
    "species.phytoplankton.count": 60,
    "species.copepod.count": 20,
    "species.krill.count": 6,
    "space.size": [16.0, 16.0, 16.0],
}


def treated(config: WorldConfig, name: str) -> WorldConfig:
    return find(name, config).apply_to(config)


@pytest.fixture(scope="module")
def sea():
    return load("diel-migration", SMALL)


def test_light_is_constant_or_comes_half_a_day_late(sea):
    for name, kind in (("constant-light", "constant"), ("inverted-light", "inverted")):
        assert treated(sea, name).sun.kind == kind
    with pytest.raises(NotApplicable, match="constant already"):
        treated(load(sea, {"sun.kind": "constant"}), "constant-light")
    with pytest.raises(NotApplicable, match="there is no sun"):
        treated(load("predator-prey"), "constant-light")


def test_without_a_species_there_is_none_in_life_or_in_training(sea):
    none = treated(sea, "no-krill")
    for training in (False, True):
        world = World.from_config(none, policies="untrained", training=training, learn=False).run(3)
        assert world.tables["krill"].n == 0
        assert world.tables["copepod"].n > 0
    assert treated(sea, "no-phytoplankton").species["phytoplankton"].reproduction.immigration == 0
    with pytest.raises(ConfigError, match="no such treatment"):
        find("no-whale", sea)


def test_noses_that_are_off_read_nothing_while_the_smell_is_there(sea):
    read = {}
    for name, config in (("on", sea), ("off", treated(sea, "no-smell"))):
        world = World.from_config(config, policies="untrained", seed=3, learn=False).run(12)
        table = world.tables["copepod"]
        nerves = table.species.nerves
        smells = [i for i, c in enumerate(nerves.channels) if "smell" in c]
        assert len(smells) == 4
        assert world.fields["krill_smell"].value.max() > 0.1
        seen = [state_of(world, int(uid))["nerves"] for uid in table.uid[table.by_uid()]]
        read[name] = max(abs(float(s["sensors"][i]["value"])) for s in seen for i in smells)
    assert read["on"] > 0.05
    assert read["off"] < 1e-20


def test_happiness_with_and_without_light_are_each_others_way_back(sea):
    lit = treated(sea, "energy-and-light")
    assert lit.species["copepod"].happiness.formula == "energy - 0.3 * light"
    assert treated(lit, "energy-only").species["copepod"].happiness.formula == "energy"
    with pytest.raises(NotApplicable, match="depends on light; energy-and-light"):
        treated(sea, "energy-only")
    with pytest.raises(NotApplicable, match="senses light"):
        treated(lit, "energy-and-light")


def test_individual_brains_are_inherited_as_learned():
    config = treated(load("predator-prey"), "individual-brains")
    world = World.from_config(config, seed=1, policies="untrained").run(80)
    deer = world.tables["deer"]
    assert {config.species[name].policy.inherit for name in ("deer", "wolf")} == {"learned"}
    uids = deer.uid[deer.rows()].tolist()
    weights = [next(world.policy("deer", uid).parameters()).detach().numpy() for uid in uids[:2]]
    assert not np.array_equal(*weights)
    with pytest.raises(NotApplicable, match="no species shares a policy"):
        treated(config, "individual-brains")


def compare(*words: str) -> str:
    done = CliRunner().invoke(app, ["compare", *words])
    assert done.exit_code == 2, done.output + repr(done.exception)
    return " ".join(done.output.split())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["diel-migration", "--treatment", "constant-ligth"], 'did you mean "constant-light"'),
        (["diel-migration", "--treatment", "no-krlil"], 'did you mean "no-krill"'),
        (
            ["diel-migration", "--treatment", "energy-only"],
            "no species has a happiness.formula that depends on light",
        ),
        (["diel-migration", "--treatment", "energy-and-light"], "changes only learning"),
        (["predator-prey", "--treatment", "inverted-light"], "there is no sun"),
        (["island", "--treatment", "individual-brains"], "changes only learning"),
    ],
)
def test_what_a_world_has_nothing_for_is_refused(
    words: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert message in compare(*words)


def test_which_policies_a_world_with_other_values_runs_with():
    arms = arms_of("diel-migration", [], ["no-krill", "random-policy"])
    check_training(arms, 2, retrain=True)
    anew, same = (
        Comparison(Path("out"), arms, 10, [1], [1, 2], retrain).policies_in_words()
        for retrain in (True, False)
    )
    assert anew["no-krill"] == "policies trained again with its own values, from 2 training seeds"
    assert same["no-krill"].endswith("the same as the first arm, from 2 training seeds")
    bundled = Comparison(Path("out"), arms, 10, [1]).policies_in_words()
    assert bundled["no-krill"] == "the world's own policies, the same as the first arm"
    assert bundled["random-policy"] == "untrained policies"


def test_the_table_has_all_treatments_that_are_applied_as_a_world_is_built():
    assert [name for name, treatment in TREATMENTS.items() if treatment.at_build] == list(at_build.TREATMENTS)


@pytest.mark.parametrize("name", [*TREATMENTS, "random-policy:deer", "no-wolf", "dt=0.5"])
def test_a_treatment_goes_to_other_processes_as_it_is(name: str):
    treatment = find(name, load("predator-prey"))
    again = ForkingPickler.loads(ForkingPickler.dumps(treatment))
    assert (again.name, again.policies, again.learn, again.changes_config) == (
        treatment.name,
        treatment.policies,
        treatment.learn,
        treatment.changes_config,
    )
