"""The paper's Definitions 1 to 4 in one small world (The Ecosystem Path to AGI, section "Ecosystems")."""

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Biology, Body, Chemistry, Genome, Metabolism, Nervous, Physical, Position
from ecs_eco.genomes import DNA
from ecs_eco.systems import Sense
from ecs_eco.testing import act, arrange, check_world

PROPERTIES = {  # Definition 1: property, component, its unit, the value in this world
    "temperature": (Physical, 311.0),  # [K]
    "pressure": (Physical, 13_000.0),  # [Pa]
    "electric_current": (Physical, 1e-6),  # [A]
    "luminous_intensity": (Physical, 0.02),  # [cd]
    "mass": (Body, 80.0),  # [kg]
    "radius": (Body, 0.5),  # [m] the conformation: a sphere of this radius …
    "x": (Position, None),  # [m] … around its place
    "age": (Biology, 0.0),  # [s]
    "fertility": (Biology, 0.8),  # [0, 1]
    "sex": (Biology, None),  # none, female, male
    "energy": (Metabolism, None),
}
LETHAL = [  # property, deadly value, cause
    ("energy", -0.01, "starved"),
    ("age", 60.0, "too old"),
    ("temperature", 299.0, "too cold"),
    ("temperature", 317.0, "too hot"),
    ("pressure", 2e5, "crushed"),
    ("electric_current", 0.1, "electrocuted"),
    ("luminous_intensity", 1.0, "burst into light"),
    ("fertility", 0.05, "barren"),
    ("hydron", 2e-7, "too acid"),
    ("glucose", 0.0005, "glucose too low"),
    ("oxygen", 0.0, "suffocated"),
]
MORE = [
    {"property": "pressure", "max": 1e5, "cause_above": "crushed"},
    {"property": "electric_current", "max": 0.05, "cause_above": "electrocuted"},
    {"property": "luminous_intensity", "max": 0.5, "cause_above": "burst into light"},
    {"property": "fertility", "min": 0.1, "cause_below": "barren"},
    {"property": "oxygen", "min": 0.001, "cause_below": "suffocated"},
]


@pytest.fixture
def world(menagerie):
    lethal = menagerie()["species"]["ram"]["lethal"] + MORE
    return World.from_config(menagerie(species={"ram": {"lethal": lethal}}), policies="untrained")


@pytest.mark.definition(
    "1 temperature",
    "1 mass",
    "1 pressure",
    "1 current",
    "1 luminosity",
    "1 conformation",
    "1 substances",
    "1 age",
    "1 sex",
    "1 fertility",
    "3 properties",
)
def test_definition_1_every_object_property_has_a_column_and_its_value(world):
    ram = world.tables["ram"]
    rows = ram.rows()
    for name, (component, value) in PROPERTIES.items():
        column = ram.field(component, name)[rows]
        if value is not None:
            assert set(column.tolist()) == {np.float32(value)}, name
    molar = dict(zip(world.substances, ram[Chemistry].molarity[0], strict=True))  # [mol/L]
    assert molar == pytest.approx({"glucose": 0.005, "oxygen": 0.008, "hydron": 4e-8})
    assert set(ram[Biology].sex[rows].tolist()) == {1, 2}  # female, male
    assert set(world.tables["lynx"][Biology].sex[:8].tolist()) == {0}  # none
    x, y = ram[Position].x[rows], ram[Position].y[rows]
    assert ((x >= 0) & (x < 40) & (y >= 0) & (y < 30)).all()


@pytest.mark.definition("2 type", "2 properties")
def test_definition_2_inanimate_objects_have_a_type_and_properties(world):
    boulder = world.tables["boulder"]
    assert boulder.name == "boulder"
    assert boulder[Physical].temperature[:2].tolist() == [275, 275]
    assert boulder[Body].mass[:2].tolist() == [9000, 9000]
    assert boulder[Chemistry].molarity[0].tolist() == pytest.approx([0, 0, 1e-7])
    assert Metabolism not in boulder
    assert Nervous not in boulder
    before = boulder[Position].x[:2].tolist()
    world.run(10)
    assert boulder[Position].x[:2].tolist() == before  # solid, and nothing moves it


@pytest.mark.definition(
    "3 type", "3 actions", "3 reflex", "3 policy", "3 happiness", "3 reflex agents", "3 no nerves"
)
def test_definition_3_an_organism_has_a_nervous_system_of_sensors_actions_and_three_networks(world):
    nerves = world.tables["ram"].species.nerves
    assert len(nerves.channels) == 4 + 2 * 3 + 2 * 3 + 3 + 2 + 1 + 3
    assert [a for _, a in nerves.actions] == ["still", "walk", "run", "left", "none", "right", "eat"]
    assert nerves.reflex is not None
    assert nerves.happiness is not None
    assert nerves.policy
    world.run(1)
    x = nerves.x[:, list(nerves.channels).index("glucose")]
    assert x.tolist() == pytest.approx([0.5] * len(x))
    reflex_agent = world.tables["lynx"].species.nerves
    assert (reflex_agent.policy, reflex_agent.happiness, reflex_agent.reflex is None) == (False, None, False)
    assert world.tables["moss"].species.nerves is None  # plants and bacteria


@pytest.mark.definition("3 sensor property", "3 sensor place")
def test_definition_3_a_sensor_may_be_sensitive_to_any_property_of_bodies_of_any_type(menagerie):
    felt = [name for name in PROPERTIES if name != "x"] + ["volume", "glucose", "oxygen", "hydron"]
    of = {"ram": felt, "boulder": ["temperature", "mass", "radius", "volume", "hydron"], "moss": ["energy"]}
    sensors = [
        {
            "kind": "property",
            "property": name,
            "of": kind,
            "range": 1.0,
            "at": [2.0, -3.0],
            "decay": "inverse_square",
            "scale": 2.0,
        }
        for kind, names in of.items()
        for name in names
    ]
    world = World.from_config(
        menagerie(species={"lynx": {"sensors": sensors, "reflex": None}}), policies="random"
    )
    nerves = arrange(world, "lynx", x=10, y=10, heading=np.pi / 2).species.nerves
    arrange(world, "ram", x=30, y=25)
    for kind, name in ((kind, name) for kind, names in of.items() for name in names):
        table = world.tables[kind]
        row = table.by_uid()[0]
        p, rows = table[Position], table.rows()
        p.x[rows], p.y[rows] = 30, 25
        p.x[row], p.y[row] = 11.8, 11.9  # 0.7 m from the sensors, which are at (11.8, 11.2)
        table.version += 1
        act(world, Sense)
        x = nerves.reading(f"{kind}_{name}", nerves.x)
        value = (
            4 / 3 * np.pi * table[Body].radius[row] ** 3
            if name == "volume"
            else table[Chemistry].molarity[row, world.substances.index(name)]
            if name in world.substances
            else table.field(PROPERTIES[name][0], name)[row]
        )
        distance = max(0.7, table[Body].radius[row])
        assert x.tolist() == pytest.approx([value / distance**2 / 2] * len(x), rel=1e-4), (kind, name)


@pytest.mark.definition("3 genome")
def test_definition_3_a_genome_is_a_string_over_a_finite_alphabet(world):
    world = World()
    table = world.add_table("bacterium", Genome, Physical, dims={"loci": 4})
    world.spawn("bacterium", Genome(loci=DNA.encode("ACGT")))
    world.flush()
    assert DNA.decode(table[Genome].loci[0]) == "ACGT"


@pytest.mark.parametrize(("name", "value", "cause"), LETHAL)
@pytest.mark.definition("3 staying alive")
def test_definition_3_each_property_that_leaves_its_interval_kills_by_a_cause_of_its_own(
    world, name, value, cause
):
    ram = world.tables["ram"]
    uid = int(ram.uid[ram.by_uid()][3])
    _, row = world.locate(uid)
    ram[Metabolism].digesting[row] = 2  # no meal of this tick saves it
    if name in world.substances:
        ram[Chemistry].molarity[row, world.substances.index(name)] = value
    else:
        component = PROPERTIES[name][0]
        ram.field(component, name)[row] = value
    died = []
    world.on_death.append(
        lambda t, rows: died.extend(
            (int(t.uid[r]), world.causes[t.cause[r] - 1]) for r in rows if t.name == "ram"
        )
    )
    carcasses = world.tables["carcass"].n
    world.run(1)
    assert (uid, cause) in died
    assert [c for u, c in died if u == uid] == [cause]
    natural = [c for _, c in died if not c.startswith("eaten")]
    assert world.tables["carcass"].n == carcasses + len(natural)


@pytest.mark.definition("3 remains")
def test_a_carcass_holds_the_bodys_substances_and_is_no_organism(world):
    ram = world.tables["ram"]
    uid = int(ram.uid[ram.by_uid()][0])
    _, row = world.locate(uid)
    ram[Chemistry].molarity[row] = [0.004, 0.003, 2e-7]
    ram[Physical].temperature[row] = 305
    place = ram[Position].x[row], ram[Position].y[row]
    world.kill(uid, "fell")
    world.flush()
    carcass = world.tables["carcass"]
    assert carcass[Chemistry].molarity[0].tolist() == pytest.approx([0.004, 0.003, 2e-7])
    assert carcass[Physical].temperature[0] == 305
    assert (carcass[Body].mass[0], carcass[Position].x[0], carcass[Position].y[0]) == (80, *place)
    assert Biology not in carcass
    assert carcass.uid[0] != uid


@pytest.mark.definition("4 space", "4 objects", "4 organisms")
def test_definition_4_an_ecosystem_is_a_space_with_objects_and_organisms(menagerie, world):
    assert world.space.size == (40, 30)
    arrange(world, "ram", temperature=np.linspace(298, 318, 40))
    world.run(3)
    deaths = world.series().to_pydict()
    assert sum(deaths["died: too cold"]) >= 3
    assert sum(deaths["died: too hot"]) >= 3
    check_world(menagerie(), ticks=20)
