"""Checkpoints in the two former formats: goats that each have their own brain, learn and breed, saved in format 1
by version 0.1 at tick 30; and the world of `former/fell.toml` with seed 3, saved in format 2 at tick 12."""

import hashlib
from pathlib import Path

import numpy as np

from ecs_eco import World
from ecs_eco.components import Metabolism, Policy, Position
from ecs_eco.testing.target import target

FORMER = Path(__file__).parent / "format_1.safetensors"
MADE_ON = "znver3"  # elsewhere kernels may round otherwise
AT_30 = "bdfd655476c9037d5c310e44a1f8bc15740b1186ea3c9af337455e59afd1ef94"
AT_50 = "e88d4e1753e2949bd827f12aef6d29447c3187d111530209187492103b8e57fa"  # as this version goes on


def facts(world):
    digest = hashlib.sha256()
    for name in ("red", "yellow", "green", "goat"):  # as they stood in the file of that world
        table = world.tables[name]
        rows = table.by_uid()
        p = table[Position]
        for column in (table.uid, p.x, p.y, p.heading, table[Metabolism].energy):
            digest.update(np.ascontiguousarray(column[rows]).tobytes())
    goat = world.tables["goat"]
    digest.update(goat[Policy].weights[goat.by_uid()].tobytes())
    return {name: table.n for name, table in world.tables.items()}, world.next_uid, digest.hexdigest()


def test_a_checkpoint_of_the_former_format_holds_what_it_held_and_goes_on_as_it_would_have():
    world = World.restore(FORMER)
    assert facts(world) == ({"red": 3, "yellow": 11, "green": 31, "goat": 16}, 71, AT_30)
    facts_now = facts(world.run(20))
    assert facts_now[0]["goat"] > 0
    if target().cpu == MADE_ON:
        assert facts_now == ({"red": 5, "yellow": 15, "green": 32, "goat": 17}, 88, AT_50)


def test_a_checkpoint_in_format_2_has_its_digestion_in_ticks_and_continues_as_it_did_in_that_version():
    world = World.restore(FORMER.with_name("format_2.safetensors"))
    vole = world.tables["vole"]
    digesting = vole[Metabolism].digesting[vole.by_uid()]
    assert (digesting.dtype, digesting.tolist()) == (np.int32, [0, 0, 0, 1, *[0] * 10])  # 0.107 s, rounded up
    assert ({name: table.n for name, table in world.tables.items()}, world.next_uid) == (
        {"moss": 13, "vole": 14, "worm": 22},
        65,
    )
    world.run(10)
    assert ({name: table.n for name, table in world.tables.items()}, world.next_uid) == (
        {"moss": 13, "vole": 12, "worm": 25},
        74,
    )
