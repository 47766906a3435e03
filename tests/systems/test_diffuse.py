import math

import pytest

from ecs_eco.components import Chemistry
from ecs_eco.life.matter import NUMBER, stocks
from ecs_eco.systems import Diffuse
from ecs_eco.testing import act, arrange

FIELDS = {
    "fields": {"musk": {"cell": 2.0, "diffusion": 0.5, "decay": 0.0}, "hay": {"cell": 1.0, "decay": 0.5}},
    "dt": 0.5,
}


def test_every_body_emits_its_rate_where_it_is(meadow):
    world = meadow(world=FIELDS, emits={"musk": 3.0}, grass={"emits": {"hay": 4.0, "musk": 1.0}})
    arrange(world, "deer", x=[1, 11], y=[1, 11])
    arrange(world, "grass", x=[5.5, 5.7], y=[3.5, 3.5])
    act(world, Diffuse)
    assert world.fields["musk"].value.sum(dtype=float) == pytest.approx(2 * 1.5 + 2 * 0.5)
    hay = world.fields["hay"].value[0]
    # dc/dt = 4 of each − decay c, over a tick of 0.5 s
    assert hay[3, 5] == pytest.approx(2 * 4 * (1 - 2.718281828 ** (-0.25)) / 0.5, rel=1e-6)
    assert hay.sum() == hay[3, 5]  # it does not diffuse


def test_a_smell_follows_who_moves_and_stays_where_it_was(meadow):
    world = meadow(world=FIELDS, emits={"hay": 2.0})
    for x in (0.5, 9.5):
        arrange(world, "deer", x=x, y=0.5)
        act(world, Diffuse)
    fade = 2.718281828 ** (-0.25)
    assert world.fields["hay"].value[0, 0, [0, 9]].tolist() == pytest.approx(
        [2 * 2 * (1 - fade) / 0.5 * fade, 2 * 2 * (1 - fade) / 0.5]
    )


def test_the_dead_emit_no_more(meadow):
    world = meadow(world=FIELDS, emits={"musk": 2.0})
    world.kill(int(world.tables["deer"].uid[0]))
    world.flush()
    act(world, Diffuse)
    assert world.fields["musk"].value.sum(dtype=float) == pytest.approx(1.0)


# --- smells of what bodies are made of ----------------------------------------------------------------------

SMELLY = {"substances": {"musk": 0.5, "salt": 0.1}}
LITRES = 4000 * math.pi / 3 / 8  # of a deer


def musky(meadow, way, fields=None, **deer):
    world = FIELDS | {"substances": {"musk": "", "salt": ""}, "fields": FIELDS["fields"] | (fields or {})}
    return meadow(world=world, emits={"musk": {"substance": "musk", "rate": 0.02} | way}, **(SMELLY | deer))


@pytest.mark.definition("3 chemical rules")
def test_a_body_smells_in_proportion_to_what_it_is_made_of(meadow):
    world = musky(meadow, {})
    world.tables["deer"][Chemistry].molarity[:2, 0] = [0.5, 0.125]
    act(world, Diffuse)
    assert world.fields["musk"].value.sum(dtype=float) == pytest.approx(0.625 * LITRES * 0.02 * 0.5)
    assert world.tables["deer"][Chemistry].molarity[:2, 0].tolist() == [0.5, 0.125]


def test_what_evaporates_is_lost_to_the_body(meadow):
    world = musky(meadow, {"consume": True})
    act(world, Diffuse)
    gone = 2 * 0.5 * LITRES * (1 - math.exp(-0.01))
    assert world.fields["musk"].value.sum(dtype=float) == pytest.approx(gone)
    assert world.tables["deer"][Chemistry].molarity[0].tolist() == pytest.approx([0.5 * math.exp(-0.01), 0.1])
    assert world.matter.flows[0, 0, NUMBER["emitted"]] == pytest.approx(-gone)


@pytest.mark.parametrize("rates", [(0.5, 0.5), (3.0, 1.0), (0.0, 0.5), (90.0, 30.0)])
def test_emissions_of_one_store_are_in_proportion_to_their_rates_in_any_order(meadow, rates):
    found = []
    for order in (("musk", "hay"), ("hay", "musk")):
        ways = dict(zip(("musk", "hay"), rates, strict=True))
        still = {"cell": 2.0, "decay": 0.0}
        world = meadow(
            world=FIELDS | {"substances": {"musk": "", "salt": ""}, "fields": {"musk": still, "hay": still}},
            emits={name: {"substance": "musk", "rate": ways[name], "consume": True} for name in order},
            **SMELLY,
        )
        act(world, Diffuse)
        gone = 2 * 0.5 * LITRES * (1 - math.exp(-0.5 * sum(rates)))
        for name in order:
            amount = world.fields[name].value.sum(dtype=float)
            assert amount == pytest.approx(gone * ways[name] / sum(rates))
        left = world.tables["deer"][Chemistry].molarity[:2, 0]
        assert left == pytest.approx(0.5 * math.exp(-0.5 * sum(rates)), abs=1e-9)
        assert (left >= 0).all()
        found.append(world.digest())
    assert found[0] == found[1]


def test_what_evaporates_into_a_field_of_its_substance_stays_in_the_world(meadow):
    air = {"musk": {"cell": 2.0, "diffusion": 0.5, "substance": "musk"}}
    world = musky(meadow, {"consume": True}, fields=air)
    before = stocks(world, world.matter).sum(0)
    world.run(4)
    assert stocks(world, world.matter).sum(0) == pytest.approx(before, rel=1e-12)
    assert world.fields["musk"].held() == pytest.approx(LITRES * (1 - math.exp(-0.04)))


def test_what_decays_in_a_field_is_in_the_books(meadow):
    air = {"musk": {"cell": 2.0, "diffusion": 0.5, "decay": 0.5, "substance": "musk", "initial": 0.1}}
    world = musky(meadow, {"consume": True, "rate": 0.0}, fields=air).run(1)
    page = world.recorder.matter_series().to_pydict()
    assert sum(page["decayed"]) == pytest.approx(-0.1 * 400_000 * (1 - math.exp(-0.25)), rel=1e-6)
    assert sum(page["set"]) == pytest.approx(0, abs=1e-6)
