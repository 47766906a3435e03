import json

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.analysis.learning import write_training
from ecs_eco.config import load
from ecs_eco.engine.errors import ConfigError
from ecs_eco.lab.pretraining import against_random, mean_weights, pretrain


@pytest.fixture(scope="module")
def trained(menagerie, tmp_path_factory):
    out = tmp_path_factory.mktemp("policies")
    shown = []
    changes = {"training": {"average": 0.5, "set": {"species.moss.reproduction.seed_rain": 0.2}}}
    result = pretrain(
        menagerie(**changes), seed=5, ticks=40, out=out, progress=lambda *at: shown.append(at), points=4
    )
    return result, out, shown


def test_policies_learn_and_are_written_with_their_curves(trained, menagerie):
    result, out, shown = trained
    assert shown == [(10, 40), (20, 40), (30, 40), (40, 40)]
    assert list(result["policies"]) == ["ram"]
    assert set(result["curves"]) == {"moss", "ram", "lynx"}
    assert result["curves"]["ram"]["tick"] == [10, 20, 30, 40]
    assert all(len(v) == 4 and np.isfinite(v).all() for v in result["curves"]["ram"].values())
    assert result["reports"]["ram"]["n_transitions"] == 12 * 40
    written = json.loads((out / "training.json").read_text())
    assert (written["ticks"], written["seed"], written["curves"]) == (40, 5, result["curves"])
    assert sorted(p.name for p in out.iterdir()) == ["ram.safetensors", "training.json"]


def test_each_update_and_how_often_actions_are_done_are_kept(trained):
    result, out, _ = trained
    learnt, acts = result["learning"]["ram"], result["actions"]["ram"]
    assert learnt["tick"] == sorted(learnt["tick"])
    assert learnt["entropy"][-1] == pytest.approx(result["reports"]["ram"]["entropy"], rel=1e-6)
    assert acts["tick"] == [10, 20, 30]
    speeds = [shares for name, shares in acts.items() if name.startswith("speed.")]
    assert len(speeds) > 1
    assert np.sum(speeds, axis=0) == pytest.approx(1)  # of a group with a neutral action one is always done
    assert json.loads((out / "training.json").read_text())["learning"] == result["learning"]


@pytest.mark.slow
def test_trained_policies_are_measured_beside_random_ones_and_shown(trained, menagerie, tmp_path):
    result, out, _ = trained
    changes = {"training": {"average": 0.5, "set": {"species.moss.reproduction.seed_rain": 0.2}}}
    found = against_random(load(menagerie(**changes)), out, seed=5, ticks=5, seeds=2)
    assert set(found) == {"ram"}
    for of in found["ram"].values():
        assert of["difference"][0] == pytest.approx(of["trained"][0] - of["random"][0])
        assert of["difference"][1] <= of["difference"][0] <= of["difference"][2]
    page = write_training({**result, "against_random": found}, tmp_path).read_text()
    assert "Comparison with random policies" in page
    assert {p.name for p in (tmp_path / "figures").iterdir()} == {
        "learning.svg",
        "actions-0.svg",
        "actions-1.svg",
    }


def test_a_world_takes_up_the_policies_of_a_folder(trained, menagerie):
    result, out, _ = trained
    world = World.from_config(menagerie(), policies=str(out))
    state = world.tables["ram"].species.nerves.brain.state()
    assert all(np.array_equal(state[k], v) for k, v in result["policies"]["ram"].items())
    other = World.from_config(menagerie(), policies={"ram": "untrained"})
    assert any((other.tables["ram"].species.nerves.brain.state()[k] != v).any() for k, v in state.items())


def test_training_changes_the_weights_and_the_same_seed_gives_the_same(trained, menagerie):
    result, _, _ = trained
    changes = {"training": {"average": 0.5, "set": {"species.moss.reproduction.seed_rain": 0.2}}}
    again = pretrain(menagerie(**changes), seed=5, ticks=40, points=4)
    assert all(np.array_equal(v, again["policies"]["ram"][k]) for k, v in result["policies"]["ram"].items())
    fresh = (
        World.from_config(menagerie(**changes), seed=5, policies="untrained")
        .tables["ram"]
        .species.nerves.brain.state()
    )
    assert all((v != fresh[k]).any() for k, v in result["policies"]["ram"].items() if k.endswith("weight"))


def test_training_shorter_than_a_rollout_leaves_the_policies_as_they_were(menagerie, tmp_path):
    result = pretrain(menagerie(), ticks=3, out=tmp_path)
    fresh = World.from_config(menagerie(), policies="untrained").tables["ram"].species.nerves.brain.state()
    assert all(np.array_equal(v, fresh[k]) for k, v in result["policies"]["ram"].items())
    assert (tmp_path / "training.json").is_file()


def test_the_mean_of_weights_is_that_of_each_number():
    one, two = {"w": np.array([1, 2], np.float32)}, {"w": np.array([2, 6], np.float32)}
    assert mean_weights([one, two])["w"].tolist() == [1.5, 4]
    assert mean_weights([one, two])["w"].dtype == np.float32


def test_what_an_update_could_not_say_is_written_as_null(menagerie, tmp_path):
    dead = {
        "happiness": {"formula": "0 * energy", "minimum": 0.0},
        "lethal": [],
        "ppo": {"gae_lambda": 0.0, "discount": 0.0},
    }
    result = pretrain(menagerie(species={"ram": dead}), ticks=30, out=tmp_path)
    assert json.loads((tmp_path / "training.json").read_text())["reports"] == result["reports"]


@pytest.mark.parametrize("renew", [0, 3])
def test_numbers_ramp_while_training(menagerie, renew):
    ramp = [{"key": "species.ram.metabolism.basal", "values": [0.0, 0.02], "duration": 0.5}]
    config = load(menagerie(training={"ramp": ramp, "renew": renew}))
    assert [config.training.ramp[0].at(share) for share in (0.0, 0.25, 0.5, 0.9)] == [0.0, 0.01, 0.02, 0.02]
    seen = []

    def look(done, _):
        seen.append(
            (done, sum(s.metabolism.basal for n, s in worlds[-1].config.species.items() if n == "ram"))
        )

    worlds, made = [], World.from_config

    def build(*args, **options):
        worlds.append(made(*args, **options))
        return worlds[-1]

    World.from_config = build
    try:
        pretrain(config, seed=5, ticks=8, progress=look, points=4)
    finally:
        World.from_config = made
    assert seen == [(2, 0.0), (4, 0.01), (6, 0.02), (8, 0.02)]


@pytest.mark.parametrize(
    ("ramp", "named"),
    [
        ({"key": "species.ram.count", "values": [1.0, 2.0]}, "training.ramp.0"),
        ({"key": "species.ram.diet.0.chance", "values": [0.5, 3.0]}, "training.ramp.0.values.1"),
        ({"key": "species.rem.diet.0.chance", "values": [0.5, 1.0]}, "training.ramp.0.key"),
        ({"key": "dt", "values": [0.5, 1.0]}, "training.ramp.0.key"),
    ],
)
def test_a_ramp_of_what_cannot_change_is_refused(menagerie, ramp, named):
    with pytest.raises(ConfigError) as error:
        load(menagerie(training={"ramp": [ramp]}))
    assert named in str(error.value)
