import json

import numpy as np
import pytest

from ecs_eco import World
from ecs_eco.components import Nervous
from ecs_eco.genomes import Layout
from ecs_eco.genomes.models import Gene
from ecs_eco.nervous.thoughts import minds, softmax, thinkers
from ecs_eco.view.inspect import drawable, marked, state_of


@pytest.fixture(scope="module")
def lived(menagerie):
    """A menagerie of 60 ticks that learns."""
    full = {
        "ram": {
            "reflex": {"connections": [{"sensor": "energy", "action": "eat", "weight": -1, "above": 0.4}]}
        }
    }
    world = World.from_config(menagerie(species=full), policies="untrained", learn=True, record=False)
    return world.run(60)


def test_looking_changes_nothing(menagerie):
    seen, alone = (World.from_config(menagerie(), policies="untrained", learn=True) for _ in range(2))
    for _ in range(25):
        seen.run(1)
        for table in seen.tables.values():
            for row in table.rows()[:3]:
                json.dumps(state_of(seen, int(table.uid[row])), allow_nan=False)
    assert seen.digest() == alone.run(25).digest()


def test_what_is_said_of_all_rams_is_what_they_decided(lived):
    table = lived.tables["ram"]
    rows, at = thinkers(table)
    mind, nerves = minds(table, rows, at), table.species.nerves
    assert rows.size > 5
    assert (np.diff(table.uid[rows].astype(int)) > 0).all()
    assert ((mind.y.astype(int) + mind.z > 0) == mind.decision).all()
    assert (mind.decision == table[Nervous].decision[rows]).all()
    eat = nerves.column("eat")
    assert (mind.y[:, eat] == -(mind.x[:, 0] > 0.4).astype(int)).all()  # who is full does not eat
    assert 0 < (mind.y[:, eat] < 0).sum() < rows.size
    # one gait is chosen, one turn, or automatic ones
    assert mind.z[:, 0:3].sum(axis=1).tolist() == [1] * rows.size
    p = mind.p[:, nerves.columns["speed"][0] :][:, :3]
    assert p.sum(axis=1) == pytest.approx(1)
    # the brain learns before it decides: it still is the one that did
    logits, _ = nerves.brain.forward(mind.x)
    assert p == pytest.approx(softmax(logits[:, 0:3]), abs=1e-6)


def test_automatic_actions_have_no_probability_and_are_chosen(lived):
    table = lived.tables["lynx"]
    if not table.n:
        pytest.fail("the lynxes died out: another seed is needed")
    state = next(s for r in table.rows() if (s := state_of(lived, int(table.uid[r])))["nerves"])
    eat = next(a for a in state["nerves"]["actions"] if a["name"] == "eat")
    assert (eat["probability"], eat["chosen"], eat["reflex"]) == (None, 1, 0)
    assert {a["probability"] for a in state["nerves"]["actions"]} == {None}  # they have no policy
    assert (state["nerves"]["happiness"], state["genome"]) == (None, None)


def test_softmax_of_two_logits_by_hand():
    assert softmax(np.array([[0.0, np.log(3.0)]], np.float32)) == pytest.approx(np.array([[0.25, 0.75]]))


def test_a_newborn_has_not_sensed_yet(meadow):
    world = meadow()
    world.run(1)
    world.spawn("deer")
    world.flush()
    newborn = int(world.tables["deer"].uid.max())
    assert state_of(world, newborn)["nerves"] is None
    world.run(1)
    assert state_of(world, newborn)["nerves"]["sensors"] == [{"name": "energy", "value": 0.5}]


def test_a_newborn_in_the_row_of_one_who_died_is_not_taken_for_it(meadow):
    world = meadow()
    world.run(1)
    deer = world.tables["deer"]
    row = int(deer.rows()[0])
    old = int(deer.uid[row])
    world.kill(old)
    world.flush()
    world.spawn("deer")
    world.flush()
    assert deer.uid[row] != old
    assert state_of(world, int(deer.uid[row]))["nerves"] is None


class _Kin:
    """Remembers one death."""

    def facts(self, uid):
        known = {"born": 2, "generation": 1, "parents": [1], "children": [8, 9]}
        died = {"tick": 5, "cause": "starved", "killer": None}
        return known | ({"species": "deer", "died": died} if uid == 33 else {"species": None, "died": None})


def test_of_the_dead_is_said_what_is_remembered(meadow):
    world = meadow()
    dead = state_of(world, 33, _Kin())
    assert [dead[k] for k in ("species", "alive", "born", "parents", "children", "generation")] == [
        "deer",
        False,
        2,
        [1],
        [8, 9],
        1,
    ]
    assert (dead["died"]["cause"], dead["energy"], dead["nerves"], dead["detail"]) == (
        "starved",
        None,
        None,
        "record",
    )
    living = state_of(world, int(world.tables["deer"].uid[0]), _Kin())
    assert [living[k] for k in ("alive", "died", "energy_max", "children")] == [True, None, 1.0, [8, 9]]


@pytest.mark.parametrize("uid", [0, 77])
def test_who_never_was_is_refused(lived, uid):
    with pytest.raises(KeyError, match="no living entity"):
        state_of(lived, uid * 10**6, _Kin())


def test_genes_are_marked_with_their_place_and_value():
    genes = [
        Gene(name="size", values=[1.0, 2.0, 3.0, 4.0], letters=1),
        Gene(name="mood", low=0.0, high=15.0, letters=2),
    ]
    layout = Layout(genes, loci=4)
    genome = marked(layout, layout.alphabet.encode("GTCA"))
    assert genome["strings"] == ["GTCA"]
    assert [(g["name"], g["from"], g["to"], g["value"]) for g in genome["genes"]] == [
        ("size", 0, 1, 3.0),
        ("mood", 1, 3, 13.0),
    ]


def test_two_strings_say_both_alleles():
    layout = Layout([Gene(name="size", values=[1.0, 2.0, 3.0, 4.0], letters=1)], ploidy=2, dominance="mean")
    genome = marked(layout, layout.alphabet.encode("CT"))
    assert genome["strings"] == ["C", "T"]
    assert (genome["genes"][0]["value"], genome["genes"][0]["alleles"]) == (3.0, [2.0, 4.0])


def test_what_is_said_can_be_drawn(lived):
    from ecs_eco.analysis.nervous_figure import draw_nervous_system

    world = lived
    table = world.tables["ram"]
    state = state_of(world, int(table.uid[thinkers(table)[0][0]]))
    values = drawable(state["nerves"])
    assert len(values["readings"]) == len(table.species.nerves.channels)
    assert draw_nervous_system(world.config, "ram", values).axes
