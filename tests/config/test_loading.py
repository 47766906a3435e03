"""World files: values, names of sensors, overrides, and hashes."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

import ecs_eco
from ecs_eco.config import WorldConfig, for_training, load
from ecs_eco.config.models.sensors import name_sensors
from ecs_eco.config.shipped import shipped
from ecs_eco.engine.errors import ConfigError, Problem, nearest
from ecs_eco.inputs.section import Section

SMALL: dict[str, Any] = {
    "format": 1,
    "name": "small",
    "space": {"size": [20.0, 20.0]},
    "fields": {"smoke": {"cell": 1.0}},
    "species": {"moss": {"count": 3, "body": {"radius": 0.1}}},
}


def small(**species: Any) -> dict[str, Any]:
    """The small world with changes to its one species."""
    return SMALL | {"species": {"moss": SMALL["species"]["moss"] | species}}


# loading


@pytest.mark.parametrize("name", shipped())
def test_shipped_worlds_load(name: str) -> None:
    config = load(name)
    assert config.name == name
    assert for_training(config).dims == config.dims


def test_a_world_is_found_by_name_by_path_and_by_folder() -> None:
    path = shipped()["predator-prey"]
    hashes = {load(w).config_hash for w in ("predator-prey", "predator_prey", path, str(path), path.parent)}
    assert len(hashes) == 1


def test_the_numbers_of_the_file_arrive() -> None:
    text = tomllib.loads(shipped()["predator-prey"].read_text())
    wolf = load("predator-prey").species["wolf"]
    given = text["species"]["wolf"]
    assert wolf.count == given["count"]
    assert wolf.diet[0].chance == given["diet"][0]["chance"]
    assert wolf.locomotion is not None
    assert wolf.locomotion.speed == given["locomotion"]["speed"]
    assert wolf.happiness is not None
    assert wolf.happiness.minimum == given["happiness"]["minimum"]


def test_what_is_left_out_has_its_default_and_is_resolved() -> None:
    config = load(SMALL)
    moss = config.resolved()["species"]["moss"]
    assert (config.dt, config.space.edges, config.seed) == (1.0, "torus", 1)
    assert moss["metabolism"] == {
        "energy": 1.0,
        "energy_max": 1.0,
        "basal": 0.0,
        "photosynthesis": 0.0,
        "handling_time": 0.0,
    }
    assert moss["policy"]["kind"] == "none"
    assert moss["reproduction"] is None


def test_hyperparameters_are_explicit_where_a_policy_learns() -> None:
    config = load("predator-prey")
    from ecs_eco.learning import PPO

    assert PPO(**config.species["deer"].ppo).horizon == 64
    assert set(config.species["deer"].ppo) == set(PPO.__dataclass_fields__)
    assert config.species["grass"].ppo == {}


@pytest.mark.parametrize("world", shipped())
def test_the_resolved_world_loads_as_the_same_world(world: str) -> None:
    config = load(world)
    again = load(json.loads(json.dumps(config.resolved())))
    assert again.resolved() == config.resolved()
    assert again.config_hash == config.config_hash


def test_the_hash_tells_worlds_apart() -> None:
    hashes = {
        load(SMALL, change).config_hash for change in ([], ["species.moss.count=4"], ["dt=0.5"], ["seed=2"])
    }
    assert len(hashes) == 4
    assert load(SMALL, ["dt=1"]).config_hash == load(SMALL, ["dt=1.0"]).config_hash == load(SMALL).config_hash


def test_a_dict_is_not_changed_by_loading_it() -> None:
    before = json.dumps(SMALL)
    load(SMALL, ["species.moss.count=4", "fields.smoke.decay=0.5"])
    assert json.dumps(SMALL) == before


def test_a_loaded_world_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="frozen"):
        load(SMALL).species["moss"].count = 5  # type: ignore[misc]


def test_whole_numbers_are_numbers_and_true_is_none() -> None:
    assert load(small(body={"radius": 1})).species["moss"].body.radius == 1.0
    for value in (True, "1", math.nan, math.inf, 1e31, None):
        with pytest.raises(ConfigError):
            load(small(body={"radius": value}))


def test_files_are_named_from_the_folder_of_the_world(tmp_path: Path) -> None:
    world = tmp_path / "here" / "world.toml"
    world.parent.mkdir()
    text = (
        'format = 1\nname = "w"\nspace = { size = [9, 9] }\n[species.x]\ncount = 1\nbody = { radius = 1 }\n'
    )
    world.write_text(text)
    assert load(world).file("x.safetensors") == world.parent / "x.safetensors"
    assert load(load(world), ["dt=2"]).folder == world.parent


def test_training_sets_its_values_and_only_then() -> None:
    config = load("predator-prey")
    training = for_training(config)
    assert config.species["grass"].reproduction is not None
    assert training.species["grass"].reproduction is not None
    assert config.species["grass"].reproduction.rate > 0
    assert training.species["grass"].reproduction.rate == 0
    assert training.species["deer"].sensors == config.species["deer"].sensors
    assert training.species["deer"].ppo != config.species["deer"].ppo
    same = {"count": 1, "ppo": config.species["deer"].ppo}
    assert training.species["deer"].model_copy(update=same) == config.species["deer"].model_copy(update=same)
    assert training.folder == config.folder


def test_training_leaves_out_ppo_of_a_species_that_has_no_network() -> None:
    config = load("predator-prey", {"species.deer.policy": {"kind": "none"}, "species.deer.ppo": {}})
    assert for_training(config).species["wolf"].ppo == for_training(load("predator-prey")).species["wolf"].ppo


def sections(model: type[Section]) -> set[type[Section]]:
    """The model and all models within it."""
    models = {model}
    stack = [f.annotation for f in model.model_fields.values()]
    while stack:
        kind = stack.pop()
        stack += list(getattr(kind, "__args__", ()))
        if isinstance(kind, type) and issubclass(kind, Section) and kind not in models:
            models.add(kind)
            stack += [f.annotation for f in kind.model_fields.values()]
    return models


def test_every_field_is_described_and_every_number_has_a_unit() -> None:
    for model in sections(WorldConfig):
        assert model.__doc__
        for name, field in model.model_fields.items():
            if name == "kind" and field.description is None:
                continue
            assert field.description, f"{model.__name__}.{name}"
            if field.annotation in (float, float | None):
                extra = field.json_schema_extra
                assert isinstance(extra, dict), f"{model.__name__}.{name}"
                assert extra["unit"], f"{model.__name__}.{name}"


# values from outside


@pytest.mark.parametrize(
    ("change", "read"),
    [
        ("species.deer.reproduction.rate=0.02", lambda c: c.species["deer"].reproduction.rate == 0.02),
        ("species.deer.birth_rate=0.02", lambda c: c.species["deer"].reproduction.rate == 0.02),
        ("species.wolf.diet.0.chance = 0.25", lambda c: c.species["wolf"].diet[0].chance == 0.25),
        ("space.edges=walls", lambda c: c.space.edges == "walls"),
        ('space.edges="walls"', lambda c: c.space.edges == "walls"),
        ("species.deer.policy.learn=true", lambda c: c.species["deer"].policy.learn),
        ("species.deer.ppo.horizon=32", lambda c: c.species["deer"].ppo["horizon"] == 32),
        ("terrain.hills={amplitude=2, scale=10}", lambda c: c.terrain.hills.amplitude == 2),
        ("ambient.temperature=280", lambda c: c.ambient.temperature == 280),
        ('training.set."species.deer.count"=7', lambda c: for_training(c).species["deer"].count == 7),
        ("species.wolf.happiness.formula='energy = 1'", None),
        (
            "species.wolf.happiness.formula='energy * (1 == 1)'",
            lambda c: "==" in c.species["wolf"].happiness.formula,
        ),
    ],
)
def test_values_are_set_by_dotted_keys(change: str, read: Any) -> None:
    if read is None:
        with pytest.raises(ConfigError, match="not an expression"):
            load("predator-prey", [change])
    else:
        assert read(load("predator-prey", [change]))


def test_a_dict_of_values_does_the_same_as_texts() -> None:
    by_text = load("predator-prey", ["species.deer.count=5", "space.edges=walls"])
    by_dict = load("predator-prey", {"species.deer.count": 5, "space.edges": "walls"})
    assert by_text.config_hash == by_dict.config_hash != load("predator-prey").config_hash


def test_a_whole_species_can_be_set() -> None:
    config = load(SMALL, {"species.fern": {"count": 2, "body": {"radius": 0.2}}})
    assert list(config.species) == ["moss", "fern"]


def test_the_last_of_two_values_holds() -> None:
    assert load(SMALL, ["species.moss.count=4", "species.moss.count=5"]).species["moss"].count == 5


# names of sensors


def sqrt(world, table, seekers, out, first):
    """A sense of one's own, for its name."""


SENSORS = [
    {"kind": "own", "property": "energy"},
    {"kind": "nearest", "target": "moss", "range": 2.0},
    {"kind": "smell", "field": "smoke"},
    {"kind": "smell", "field": "smoke", "at": [0.0, 1.0]},
    {"kind": "smell", "field": "smoke", "name": "tail"},
    {"kind": "touch", "target": "wall"},
    {"kind": "rays", "count": 2, "range": 1.0, "targets": ["moss", "wall"], "report": "per_ray"},
    {"kind": "light"},
    {"kind": "custom", "function": sqrt, "width": 2},
]


def test_channels_are_named_after_what_is_sensed() -> None:
    moss = load(small(sensors=SENSORS)).species["moss"]
    assert moss.channels(2) == (
        *("energy", "moss_forward", "moss_left", "moss_near", "smoke_1", "smoke_2", "tail", "touch_wall"),
        *("rays_moss_1", "rays_moss_2", "rays_wall_1", "rays_wall_2", "light", "sqrt_1", "sqrt_2"),
    )


def test_a_volume_adds_up_to_the_directions() -> None:
    config = load(small(sensors=SENSORS[:2]) | {"space": {"size": [20.0, 20.0, 9.0]}})
    assert config.species["moss"].channels(3) == (
        "energy",
        "moss_forward",
        "moss_left",
        "moss_up",
        "moss_near",
    )


def test_the_plain_name_of_a_smell_is_all_its_noses() -> None:
    readings = load(small(sensors=SENSORS)).species["moss"].readings(2)
    assert readings["smoke"] == (4, 5, 6)
    assert readings["smoke_2"] == (5,)
    assert readings["moss_near"] == (3,)


def test_naming_twice_changes_nothing() -> None:
    sensors = load(small(sensors=SENSORS)).species["moss"].sensors
    assert name_sensors(list(sensors)) == sensors


def test_actions_are_found_by_plain_and_by_full_name() -> None:
    rows = load("predator-prey").species["deer"].action_rows()
    assert rows["run"] == rows["speed.run"] == 2
    assert rows["none"] == rows["turn.none"] == 4
    assert rows["eat"] == 6


# errors


def test_problems_know_source_line_and_key(tmp_path: Path) -> None:
    world = tmp_path / "w.toml"
    world.write_text(
        'format = 1\nname = "w"\n[space]\nsize = [9, 9]\n[species.x]\ncount = -1\nbody = { radius = 1 }\n'
    )
    with pytest.raises(ConfigError) as caught:
        load(world, ["dt=-1"])
    places = {(p.source, p.line, p.path, p.value) for p in caught.value.problems}
    assert places == {("w.toml", 6, "species.x.count", -1), ("--set", None, "dt", -1)}


def test_problems_within_and_between_sections_are_told_together() -> None:
    wrong = small(emits={"smok": 1.0}) | {"fields": {"smoke": {"cell": 1.0, "decay": -1.0}}}
    with pytest.raises(ConfigError) as caught:
        load(wrong)
    assert {p.path for p in caught.value.problems} == {"fields.smoke.decay", "species.moss.emits.smok"}


def test_a_config_error_is_a_value_error_that_survives_a_process() -> None:
    error = ConfigError([Problem(("a", 0), "wrong", 1, "2", "b", "f.toml", 3)], "title")
    again, arguments = error.__reduce__()
    copy = again(*arguments)  # type: ignore[operator, misc]
    assert isinstance(copy, ValueError)
    assert (
        str(copy) == str(error) == 'title\nf.toml, line 3: a.0 = 1\n  wrong; expected: 2; did you mean "b"?'
    )


@pytest.mark.parametrize(
    ("name", "known", "right"),
    [("dear", ["deer", "wolf"], "deer"), ("Deer", ["deer"], "deer"), ("zzz", ["deer"], ""), ("", [], "")],
)
def test_the_nearest_name_is_found(name: str, known: list[str], right: str) -> None:
    assert nearest(name, known) == right


def test_loading_a_world_loads_neither_torch_nor_numba() -> None:
    code = (
        "import sys; from ecs_eco.config import load; load('predator-prey');"
        "print([m for m in ('torch', 'numba', 'pyarrow', 'matplotlib', 'scipy') if m in sys.modules])"
    )
    root = Path(ecs_eco.__path__[0]).parent
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "[]"
