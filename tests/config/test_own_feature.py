"""A custom feature from an outside file: checked, changed, inherited, kept and swept as shipped ones are."""

from multiprocessing.reduction import ForkingPickler

import pytest

from ecs_eco import World
from ecs_eco.components import Sensor
from ecs_eco.config import load
from ecs_eco.config.features.eggs import Eggs
from ecs_eco.config.features.feature import Feature, features_of, of_each
from ecs_eco.config.json_schema import json_schema
from ecs_eco.config.models.species import Species
from ecs_eco.config.notes import notes
from ecs_eco.config.notes_on_ticks import notes_on_ticks
from ecs_eco.engine.errors import ConfigError
from ecs_eco.runs.run import resume, run_to_folder

CODE = '''
import numpy as np

from ecs_eco import System, component, f32
from ecs_eco.components import Metabolism
from ecs_eco.config import FREE, Feature, NonNegative, Section, Share, about, quantity
from ecs_eco.config.features.feature import Cost
from ecs_eco.engine.errors import Problem
from ecs_eco.genomes.own_values import own_value


@component
class Wear:
    """How worn the teeth are."""

    depth: f32 = 0.0


class Gnaw(System):
    """Teeth wear with time, and worn teeth cost energy."""

    needs = (Wear, Metabolism)
    phase = "metabolise"
    asked_for = staticmethod(lambda table: table.species.teeth is not None)

    def update(self, table, world):
        teeth, rows = table.species.teeth, table.rows()
        wear = np.broadcast_to(own_value(table, "teeth.wear", np.float32(teeth.wear)), table.high)
        table[Wear].depth[rows] += wear[rows] * np.float32(world.dt)
        table[Metabolism].energy[rows] -= np.float32(teeth.cost * world.dt)
        table[Metabolism].burnt[rows] += np.float32(teeth.cost * world.dt)


class Teeth(Section, change=FREE):
    """Teeth that wear."""

    wear: Share = quantity("depth lost", "1/s", own=True)
    cost: NonNegative = quantity("energy that chewing burns", "energy/s", 0.0)
    adult: NonNegative = quantity("depth at which they are worn", "1", 5.0, own="a test of reasons")


class Chewing(Feature, after="body"):
    """Members have teeth."""

    teeth: Teeth | None = about("their teeth; absent: none", None)
    systems = (Gnaw,)

    @staticmethod
    def brings(species):
        if species.teeth is not None:
            yield None, Wear

    @staticmethod
    def feels(species):
        if species.teeth is not None:
            yield "worn", "Wear.depth"

    @staticmethod
    def costs(species):
        if species.teeth is not None:
            yield Cost(("teeth", "cost"), species.teeth.cost, owed=True)

    @staticmethod
    def meets(species):
        if species.teeth is not None:
            yield "teeth", "cat", 0.0

    @staticmethod
    def problems(species, config, key):
        if species.teeth is not None and species.teeth.cost > species.metabolism.energy_max:
            yield Problem((*key, "teeth", "cost"), "more than it can hold", species.teeth.cost, "less")
'''
GENE = '{ name = "enamel", trait = "teeth.wear", letters = 8, low = 0.25, high = 0.75 }'
WORLD = f"""
format = 1
name = "burrow"
code = ["teeth.py"]
space = {{ size = [60.0, 60.0] }}
reporters = {{ worn = "mean(Wear.depth)" }}

[species.rat]
count = 20
body = {{ radius = 0.25 }}
metabolism = {{ energy = 1.0, energy_max = 1.0 }}
teeth = {{ wear = 0.5, cost = 0.0009765625 }}
genome = {{ alphabet = "01", genes = [{GENE}], mutate = {{ indpb = 0.0 }} }}
reproduction = {{ kind = "asexual", rate = 0.05, energy_min = 0.5, energy_given = 0.25 }}

[species.cat]
count = 2
body = {{ radius = 0.5 }}
"""


@pytest.fixture
def burrow(tmp_path):
    (tmp_path / "teeth.py").write_text(CODE, encoding="utf-8")
    path = tmp_path / "burrow.toml"
    path.write_text(WORLD, encoding="utf-8")
    return path


def column(world, name, field):
    table = world.table("rat")
    component = next(c for c in table.columns if c.__name__ == name)
    return getattr(table[component], field)[table.by_uid()]


def test_its_keys_are_in_the_world_its_component_in_the_table_and_its_system_in_the_tick(burrow):
    world = World.from_config(burrow, trust=True).run(4)
    assert list(type(world.config.species["rat"]).model_fields)[5:7] == ["body", "teeth"]
    assert world.config.species["cat"].teeth is None
    assert "Gnaw" in [type(system).__name__ for system in world.systems]
    assert "Wear" not in [c.__name__ for c in world.table("cat").columns]
    deep = column(world, "Wear", "depth")
    assert (deep[:20] >= 1.0).all()
    assert (deep[:20] <= 3.0).all()
    assert world.measure("worn")["rat"] == pytest.approx(deep.mean(), rel=1e-6)


def test_without_trust_its_keys_are_taken_as_they_are_and_likely_slips_are_named(burrow):
    teeth = burrow.parent / "teeth.py"
    teeth.write_text(CODE + "# a text that nobody has allowed\n", encoding="utf-8")
    assert load(burrow).species["rat"].model_extra == {"teeth": {"wear": 0.5, "cost": 0.0009765625}}
    with pytest.raises(ConfigError, match=r"species.rat.boddy.*\n.*unknown key.*\"body\""):
        load(burrow, {"species.rat.boddy": 1})


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        (
            "teeth.wears",
            0.5,
            r'--set: species.rat.teeth.wears = 0.5\n.*wear, cost, adult; did you mean "wear"',
        ),
        (
            "teeth.wear",
            2.0,
            r"--set: species.rat.teeth.wear = 2.0\n.*out of range; expected: at most 1 \(depth lost",
        ),
        ("teeth", 3, r"--set: species.rat.teeth = 3\n.*wrong type; expected: a table \(their teeth"),
        ("teehts", {"wear": 0.5}, r'species.rat.teehts.*\n.*unknown key.*did you mean "teeth"'),
        ("teeth.cost", 9.0, r"species.rat.teeth.cost = 9.0\n.*more than it can hold"),
        ("genome.genes.0.trait", "teeth.adult", r"no gene can code for it: a test of reasons"),
    ],
)
def test_slips_are_refused_with_their_place_and_the_nearest_right_name(burrow, key, value, words):
    with pytest.raises(ConfigError, match=words):
        load(burrow, {f"species.rat.{key}": value}, trust=True)


def test_newborn_inherit_what_a_gene_codes_for(burrow):
    world = World.from_config(burrow, trust=True, seed=2)
    founders = set(column(world, "Traits", "value")[:, 0].tolist())
    world.run(30)
    assert world.tables["rat"].n > 20
    assert set(column(world, "Traits", "value")[:, 0].tolist()) <= founders
    assert len(founders) > 3


def test_members_sense_and_die_of_a_property_that_it_adds(burrow):
    given = {
        "species.rat.lethal": [{"property": "worn", "max": 2.5}],
        "species.rat.sensors": [{"kind": "own", "property": "worn", "scale": 4.0}],
        "species.rat.reproduction": None,
    }
    world = World.from_config(load(burrow, given, trust=True)).run(2)
    depth = column(world, "Wear", "depth")
    world.run(1)
    rats = world.table("rat")
    assert (rats[Sensor].readings[rats.by_uid()][:, 0] == depth / 4).all()
    world.run(2)
    assert 0 < world.tables["rat"].n < 20
    assert (column(world, "Wear", "depth") < 2.5).all()


def test_what_it_costs_and_what_its_members_meet_are_looked_at(burrow):
    assert any("its energy can fall below 0 (teeth.cost)" in note for note in notes(load(burrow, trust=True)))
    fast = {"species.cat.locomotion": {"speed": {"run": 9.0}}, "species.cat.actions": {"speed": ["run"]}}
    (note,) = notes_on_ticks(load(burrow, fast, trust=True))
    assert note.startswith("species.rat.teeth: rat and cat move up to 9 m past each other in a tick")
    with pytest.raises(ConfigError, match=r"species.rat.teeth.cost.*\n.*too little for energies up to"):
        load(burrow, {"species.rat.teeth.cost": 1e-9}, trust=True)


def test_a_living_world_takes_new_values_and_a_checkpoint_and_a_pickle_keep_them(burrow, tmp_path):
    world = World.from_config(burrow, trust=True).run(3)
    world.intervene({"kind": "set", "set": {"species.rat.teeth.cost": 0.001953125}})
    world.run(2)
    assert world.table("rat").species.teeth.cost == 0.001953125
    world.save(tmp_path / "tick-5")
    again = World.restore(tmp_path / "tick-5", trust=True)
    assert again.digest() == world.digest()
    assert again.run(3).digest() == world.run(3).digest()
    passed_on = ForkingPickler.loads(bytes(ForkingPickler.dumps(world.config)))
    assert passed_on.config_hash == world.config.config_hash
    assert passed_on.species["rat"].teeth == world.config.species["rat"].teeth


def test_the_schema_of_a_world_has_its_keys_with_units(burrow):
    schema = json_schema(type(load(burrow, trust=True)))
    wear = schema["$defs"]["Teeth"]["properties"]["wear"]
    assert (wear["unit"], wear["maximum"]) == ("1/s", 1.0)
    assert "teeth" in schema["$defs"]["Species"]["properties"]
    assert "teeth" not in json_schema()["$defs"]["Species"]["properties"]


def test_it_may_be_handed_over_in_python(burrow):
    config = load(burrow, trust=True)
    (feature,) = [f for f in features_of(type(config.species["rat"])) if f.__name__ == "Chewing"]
    data = config.model_dump() | {"code": [], "reporters": {}}
    world = World.from_config(data, features=[feature]).run(2)
    other = World.from_config(burrow, trust=True).run(2)
    assert (column(world, "Wear", "depth") == column(other, "Wear", "depth")).all()


def test_a_run_goes_on_and_a_sweep_takes_its_keys(burrow, tmp_path):
    from ecs_eco.lab import run_sweep

    run_to_folder(
        load(burrow, {"species.rat.teeth.wear": 0.25}, trust=True),
        ticks=3,
        out=tmp_path / "run",
        seed=1,
        report=False,
    )
    assert resume(tmp_path / "run", 5, report=False, trust=True)["ticks"] == 5
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'world = "burrow.toml"\nticks = 3\nworld_seeds = 1\n[grid]\nspecies.rat.teeth.cost = [0.0, 0.5]\n',
        encoding="utf-8",
    )
    outcome = run_sweep(plan, tmp_path / "sweep", workers=1, trust=True)
    assert outcome.whole
    assert sorted(outcome.done) == [0, 1]


def test_shipped_features_are_found_in_the_order_of_keys_and_asked_in_turn():
    names = [feature.__name__ for feature in features_of(Species)]
    assert "Eggs" in names
    assert len(names) == len(set(names))
    egg = Species.model_validate(
        {"count": 1, "body": {"radius": 0.1}, "hatch": {"into": "hen", "incubation": 9.0}}
    )
    assert list(of_each(egg, "becomes")) == ["hen"]
    assert list(of_each(egg, "causes", ("species", "egg"))) == [(("species", "egg", "hatch"), "hatched")]
    assert list(of_each(egg, "times")) == [("hatch.incubation", 9.0)]
    assert list(Feature.problems(egg, None, ())) == []
    assert issubclass(Species, Eggs)
