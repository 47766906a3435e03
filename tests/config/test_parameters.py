"""Parameters of a user's own systems, sensors and reporters: { use = "module:name", … }."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import pytest
from pydantic import Field

from ecs_eco import System, World, component, f32, u8
from ecs_eco.analysis.runs import load_series
from ecs_eco.components import Metabolism
from ecs_eco.config import load
from ecs_eco.config.knobs import parameters
from ecs_eco.engine.errors import ConfigError
from ecs_eco.record import fork, resume, run_to_folder

MINE = '''
from typing import Annotated

from pydantic import Field

from ecs_eco import System
from ecs_eco.components import Metabolism

class Feast(System):
    """Everybody gains."""

    needs = (Metabolism,)

    def __init__(self, gain: Annotated[float, Field(ge=0)] = 0.25, rounds: int = 1, who: str = "moss"):
        self.gain, self.rounds, self.who = gain, rounds, who

    def update(self, table, world):
        if table.name == self.who:
            table[Metabolism].energy[table.alive] += self.gain * self.rounds

class Nothing(System):
    def process(self, *_):
        pass

def above(world, *, limit: float):
    return float((world.table("moss")[Metabolism].energy > limit).sum())

def constant(world, table, seekers, out, first, value: float = 0.5):
    out[:, first] = value
'''
MOSS = {"count": 3, "body": {"radius": 0.1}, "metabolism": {"energy": 0.5}}
WORLD = {
    "format": 1,
    "name": "garden",
    "ticks": 4,
    "code": ["mine.py"],
    "space": {"size": [9.0, 9.0]},
    "species": {"moss": MOSS},
    "systems": [{"use": "mine:Feast", "gain": 0.5}, "mine:Nothing"],
    "reporters": {"rich": {"use": "mine:above", "limit": 1.0}, "mean": "mean(Metabolism.energy)"},
}


@pytest.fixture
def garden(tmp_path: Path) -> Path:
    """A world file with own code beside it, that may run."""
    from ecs_eco.config.edit import as_toml

    (tmp_path / "mine.py").write_text(MINE, encoding="utf-8")
    (tmp_path / "garden.toml").write_text(as_toml(WORLD), encoding="utf-8")
    load(tmp_path / "garden.toml", trust=True)
    return tmp_path / "garden.toml"


def mean(world: World) -> list[float]:
    return load_series(world.series()).of("moss", "mean").tolist()


def test_a_system_and_a_reporter_get_their_parameters(garden: Path) -> None:
    world = World.from_config(garden).run(2)
    assert mean(world) == [1.0, 1.5]
    assert load_series(world.series()).of("moss", "rich").tolist() == [0, 3]


def test_parameters_are_set_by_the_name_of_the_system_or_its_number(garden: Path) -> None:
    for key in ("systems.Feast.gain", "systems.0.gain"):
        config = load(garden, [f"{key}=0.125"])
        assert mean(World.from_config(config).run(2)) == [0.625, 0.75]
    assert load(garden, ["systems.Feast.rounds=2"]).systems[0].parameters == {"gain": 0.5, "rounds": 2}
    assert load(garden, {"reporters.rich.limit": 0.1}).reporters["rich"].parameters == {"limit": 0.1}


def test_parameters_are_part_of_the_hash_and_loading_what_was_resolved_gives_it_again(garden: Path) -> None:
    config = load(garden)
    assert load(garden, ["systems.Feast.gain=0.25"]).config_hash != config.config_hash
    again = load(config.resolved(), places=[garden.parent])
    assert again.config_hash == config.config_hash


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("systems.Feast.gian=1", ["not a parameter of Feast", 'did you mean "gain"?', "rounds: int = 1"]),
        ("systems.Fest.gain=1", ["no entry Fest", "0 to 1, or Feast, Nothing", 'did you mean "Feast"?']),
        ("systems.Feast.gain=much", ["systems.Feast.gain", "a valid number"]),
        ("systems.Feast.gain=-1", ["greater than or equal to 0"]),
        ("systems.Feast.gain=nan", ["a finite number"]),
        ("systems.Feast.rounds=1.5", ["a valid integer (rounds: int = 1)"]),
        ("systems.Feast.who=3", ["a valid string"]),
        ("systems.Nothing.gain=1", ["not a parameter of Nothing", "it takes no parameters"]),
        ('systems.Feast.use="mine:Fest"', ["mine has no function Fest", 'did you mean "Feast"?']),
        ("systems.Feast.use=1", ["wrong type"]),
        ('reporters.rich={ use = "mine:above" }', ["reporters.rich.limit", "is missing", "limit: float"]),
        ("reporters.mean.limit=1", ["reporters.mean has no subkeys"]),
    ],
)
def test_a_wrong_parameter_is_refused_with_what_is_allowed(
    garden: Path, change: str, words: list[str]
) -> None:
    with pytest.raises(ConfigError) as error:
        load(garden, [change])
    for word in words:
        assert word in str(error.value)


def test_a_system_without_parameters_gets_its_first_from_outside(garden: Path) -> None:
    world = World.from_config(load(garden, {"systems": ["mine:Feast"]})).run(1)
    assert mean(world) == [0.75]
    world.intervene({"kind": "set", "set": {"systems.Feast.gain": 1.0}})
    assert mean(world.run(1)) == [0.75, 1.75]


def test_an_intervention_changes_a_parameter_and_checkpoints_keep_it(garden: Path, tmp_path: Path) -> None:
    config = load(garden, {"interventions": [{"at": 1, "kind": "set", "set": {"systems.Feast.gain": 0.25}}]})
    world = World.from_config(config).run(3)
    assert mean(world) == [1.0, 1.25, 1.5]
    world.save(tmp_path / "w.safetensors")
    again = World.restore(tmp_path / "w.safetensors")
    assert again.digest() == world.digest() == world.copy().digest()
    assert mean(again.run(1)) == mean(world.run(1)) == [1.0, 1.25, 1.5, 1.75]


def test_parameters_decide_the_future_and_are_part_of_the_digest(garden: Path) -> None:
    one, other = (World.from_config(load(garden, [f"systems.Feast.gain={gain}"])) for gain in (0.5, 0.25))
    assert one.digest() != other.digest()


def test_a_parameter_that_a_system_does_not_keep_is_refused_while_it_lives() -> None:
    class Hidden(System):
        def __init__(self, rate: float = 1.0) -> None:
            self.secret = rate

        def process(self, *_: Any) -> None:
            pass

    data = {k: v for k, v in WORLD.items() if k not in ("code", "reporters")}
    world = World.from_config(data | {"systems": [{"use": Hidden, "rate": 2.0}]})
    world.intervene({"kind": "set", "set": {"systems.Hidden.rate": 3.0}})
    with pytest.raises(ConfigError, match="Hidden has no attribute rate"):
        world.run(1)


def test_a_dataclass_takes_parameters() -> None:
    @dataclass(eq=False)
    class Feast(System):
        gain: Annotated[float, Field(ge=0)] = 0.25
        needs = (Metabolism,)

        def update(self, table: Any, world: Any) -> None:
            table[Metabolism].energy[table.alive] += self.gain

    data = {k: v for k, v in WORLD.items() if k not in ("code", "reporters")}
    world = World.from_config(data | {"systems": [{"use": Feast, "gain": 0.25}]}).run(1)
    assert world.table("moss")[Metabolism].energy[0] == 0.75
    with pytest.raises(ConfigError, match="greater than or equal to 0"):
        World.from_config(data | {"systems": [{"use": Feast, "gain": -1.0}]})


def test_runs_forks_and_resumed_runs_have_the_parameters(garden: Path, tmp_path: Path) -> None:
    run_to_folder(load(garden), 1, 2, tmp_path / "run", report=False)
    fork(tmp_path / "run", tmp_path / "fork", 2, ["systems.Feast.gain=0.0"], 4, report=False)
    resume(tmp_path / "run", 4, report=False)
    whole, forked = (load_series(tmp_path / name).of("moss", "mean").tolist() for name in ("run", "fork"))
    assert whole == [1.0, 1.5, 2.0, 2.5]
    assert forked == [1.5, 1.5]


def test_a_range_of_a_parameter_is_searched(garden: Path, tmp_path: Path) -> None:
    from ecs_eco.lab import search

    found = search(
        load(garden),
        tmp_path / "found",
        {
            'search.ranges."systems.Feast.gain"': [0.25, 1.0],
            "search.objective": "mean",
            "search.ticks": 2,
            "search.world_seeds": 1,
            "search.confirm": {"world_seeds": 1, "training_seeds": 1},
        },
        trials=2,
        workers=1,
        report=False,
    )
    assert 0.25 <= found["best"][0]["values"]["systems.Feast.gain"] <= 1.0
    with pytest.raises(ConfigError, match=r'no .Fest. in systems; expected: 0, 1, Feast, Nothing; .*"Feast"'):
        load(garden, {'search.ranges."systems.Fest.gain"': [0.25, 1.0]})


def test_the_page_lists_parameters_that_may_change(garden: Path) -> None:
    rows = {row["key"]: row["value"] for row in parameters(load(garden))}
    assert rows["systems.0.gain"] == 0.5
    assert rows["reporters.rich.limit"] == 1.0


SEEING = MOSS | {
    "sensors": [{"kind": "custom", "function": {"use": "mine:constant", "value": 0.75}}],
    "actions": {"turn": ["left", "none"]},
    "locomotion": {"speed": {"still": 0.0}, "turn": 0.1},
}


def test_a_sensor_gets_its_parameters_also_new_ones_while_it_lives(garden: Path) -> None:
    world = World.from_config(load(garden, {"species.moss": SEEING})).run(1)
    nerves = world.table("moss").species.nerves
    assert nerves.channels == ("constant",)
    assert nerves.x[:, 0].tolist() == [0.75] * 3
    world.intervene({"kind": "set", "set": {"species.moss.sensors.constant.function.value": 0.25}})
    world.run(1)
    assert nerves.x[:, 0].tolist() == [0.25] * 3


@component
class Health:
    """How someone is."""

    state: u8 = 0  # well, ill
    fever: f32 = 0.0  # [K]


def test_own_sensors_lethal_limits_and_formulas_take_fields_of_own_components() -> None:
    moss = SEEING | {
        "components": [Health],
        "reflex": {"formulas": {"left": "Health.state > 0"}},
        "sensors": [
            {"kind": "own", "property": "Health.state"},
            {"kind": "property", "property": "Health.fever", "range": 4.0},
        ],
        "lethal": [{"property": "Health.fever", "max": 2.0}],
    }
    data = {k: v for k, v in WORLD.items() if k not in ("code", "systems", "reporters")}
    world = World.from_config(data | {"species": {"moss": moss}, "reporters": {"ill": "mean(Health.state)"}})
    table = world.table("moss")
    assert table.species.nerves.channels == ("Health_state", "any_Health_fever")
    table[Health].state[:2] = 1, 1
    table[Health].fever[1] = 3.0
    world.run(1)
    assert sorted(table.species.nerves.x[:, 0].tolist()) == [0, 1, 1]
    assert table.n == 2
    assert world.causes[-1] == "Health.fever too high"
    assert load_series(world.series()).of("moss", "ill").tolist() == [0.5]


@pytest.mark.parametrize(
    ("change", "near"),
    [
        ({"sensors": [{"kind": "own", "property": "Health.stat"}]}, "Health.state"),
        ({"lethal": [{"property": "Health.fevr", "max": 1.0}]}, "Health.fever"),
        ({"reflex": {"formulas": {"left": "Helth.state"}}}, "Health_state"),
        (
            {"sensors": [{"kind": "property", "property": "Health.fevr", "range": 2.0, "of": "moss"}]},
            "Health.fever",
        ),
    ],
)
def test_a_field_that_is_not_there_is_refused_with_the_nearest(change: dict[str, Any], near: str) -> None:
    moss = SEEING | {"components": [Health], "sensors": [{"kind": "own", "property": "Health.state"}]}
    moss |= change
    data = {k: v for k, v in WORLD.items() if k not in ("code", "systems", "reporters")}
    with pytest.raises(ConfigError, match=f'did you mean "{near}"'):
        load(data | {"species": {"moss": moss}})
