"""Wrong worlds and arguments are refused before anything is made: place, value, what is allowed,
the right name."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import ecs_eco
from ecs_eco.cli import app

WORLD = """\
format = 1
name = "meadow"
ticks = 10
dt = 1.0
[space]
size = [40.0, 30.0]
edges = "torus"
[substances]
glucose = "blood sugar"
[fields.smoke]
cell = 2.0
diffusion = 0.5
decay = 0.1
[objects.stone]
count = 3
body = { radius = 0.5 }
[species.grass]
count = 90
body = { radius = 0.2 }
emits = { smoke = 0.1 }
reproduction = { kind = "spread", rate = 0.1, spacing = 1.0 }
[species.goat]
count = 10
body = { radius = 0.4, mass = 30.0 }
substances = { glucose = 0.005 }
metabolism = { energy = 0.5, energy_max = 1.0, basal = 0.01 }
diet = [{ eats = "grass", gain = 0.1, chance = 0.5 }]
locomotion = { speed = { still = 0.0, walk = 0.5 }, cost = { walk = 0.01 }, turn = 0.5 }
sensors = [
  { kind = "own", property = "energy" },
  { kind = "nearest", target = "grass", radius = 5.0 },
  { kind = "smell", field = "smoke", at = [1.0, 0.0] },
  { kind = "touch", target = "stone" },
  { kind = "rays", count = 3, radius = 4.0, targets = ["grass", "wall"] },
]
actions = { speed = ["still", "walk"], turn = ["left", "none", "right"], eat = ["eat"] }
neutral = { speed = "still", turn = "none" }
automatic = ["eat"]
happiness = { formula = "energy - 0.1 * smoke", minimum = -1.0 }
reflex = { connections = [{ sensor = "touch_stone", action = "walk", weight = -1, above = 0.5 }] }
policy = { kind = "shared", hidden = [8] }
ppo = { horizon = 16 }
reproduction = { kind = "simplified", rate = 0.01, energy_min = 0.6, energy_given = 0.3 }
lethal = [{ property = "energy", min = 0.0, low = "starved" }]
"""

# what stands there, what is written instead; key (goat is species.goat), value,
# part of what is allowed, right name
CASES: dict[str, tuple[str, str, str, str, str, str]] = {
    "food": ('eats = "grass"', 'eats = "gras"', "goat.diet.0.eats", '"gras"', "grass, goat, stone", "grass"),
    "target": ('target = "grass"', 'target = "grss"', "goat.sensors.1.target", '"grss"', "goat", "grass"),
    "touch": ('target = "stone"', 'target = "stoen"', "goat.sensors.3.target", '"stoen"',
              "wall, any", "stone"),
    "ray": ('"wall"]', '"wal"]', "goat.sensors.4.targets.1", '"wal"', "wall", "wall"),
    "smell": ('field = "smoke"', 'field = "smok"', "goat.sensors.2.field", '"smok"', "smoke", "smoke"),
    "emits": ("{ smoke = 0.1 }", "{ smole = 0.1 }", "grass.emits.smole", '"smole"', "smoke", "smoke"),
    "property": ('property = "energy" }', 'property = "enrgy" }', "goat.sensors.0.property", '"enrgy"',
                 "energy, age, fertility, glucose", "energy"),
    "lethal": ('property = "energy", min', 'property = "glucos", min', "goat.lethal.0.property", '"glucos"',
               "glucose", "glucose"),
    "substance": ("{ glucose = 0.005", "{ glucosse = 0.005", "goat.substances.glucosse", '"glucosse"',
                  "glucose", "glucose"),
    "physical": ("substances = { glucose", "properties = { temprature = 3.0 }\nsubstances = { glucose",
                 "goat.properties.temprature", '"temprature"', "temperature, pressure", "temperature"),
    "group": ("actions = { speed", "actions = { sped", "goat.actions.sped", '"sped"', "speed, turn", "speed"),
    "turn": ('"none", "right"', '"none", "rigth"', "goat.actions.turn.2", '"rigth"',
             "left, none, right", "right"),
    "gait": ('["still", "walk"]', '["still", "wakl"]', "goat.actions.speed.1", '"wakl"',
             "still, walk", "walk"),
    "twice": ('["still", "walk"]', '["still", "walk", "walk"]', "goat.actions.speed.2", '"walk"',
              "still, walk", ""),
    "cost": ("cost = { walk", "cost = { wlk", "goat.locomotion.cost.wlk", '"wlk"', "still, walk", "walk"),
    "neutral": ('neutral = { speed = "still"', 'neutral = { speed = "stil"', "goat.neutral.speed", '"stil"',
                "still, walk", "still"),
    "automatic": ('automatic = ["eat"]', 'automatic = ["eta"]', "goat.automatic.0", '"eta"', "eat", "eat"),
    "chosen": ('automatic = ["eat"]', 'automatic = ["walk"]', "goat.automatic.0", '"walk"', "alone", ""),
    "reflex sensor": ('sensor = "touch_stone"', 'sensor = "touch_ston"', "goat.reflex.connections.0.sensor",
                      '"touch_ston"', "touch_stone", "touch_stone"),
    "reflex action": ('action = "walk"', 'action = "wlak"', "goat.reflex.connections.0.action", '"wlak"',
                      "speed.walk", "walk"),
    "weight": ("weight = -1", "weight = 2", "goat.reflex.connections.0.weight", "2", "-1, 0, 1", ""),
    "thresholds": ("above = 0.5", "above = 0.5, below = 0.1", "goat.reflex.connections.0", "{",
                   "exactly one", ""),
    "formula name": ("0.1 * smoke", "0.1 * smke", "goat.happiness.formula", '"energy - 0.1 * smke"',
                     "smoke", "smoke"),
    "formula syntax": ("0.1 * smoke", "0.1 *", "goat.happiness.formula", '"energy - 0.1 *"',
                       "numbers, names", ""),
    "formula unsafe": ("0.1 * smoke", "smoke.__class__", "goat.happiness.formula", "__class__", "abs", ""),
    "formula call": ("0.1 * smoke", "sqr(smoke)", "goat.happiness.formula", "sqr", "sqrt", "sqrt"),
    "minimum": (", minimum = -1.0", "", "goat.happiness.minimum", "", "finite number", ""),
    "two ways": ("minimum = -1.0", "minimum = -1.0, weights = { energy = 1.0 }", "goat.happiness", "{",
                 "exactly one", ""),
    "function": ('formula = "energy - 0.1 * smoke"', 'function = "math:sqr"', "goat.happiness.function",
                 '"math:sqr"', "code = [", ""),
    "module": ('formula = "energy - 0.1 * smoke"', 'function = "no_such_module:f"', "goat.happiness.function",
               '"no_such_module:f"', "code = [", ""),
    "kind": ('kind = "touch"', 'kind = "tuch"', "goat.sensors.3.kind", '"tuch"', "own, nearest", "touch"),
    "no kind": ('kind = "touch", ', "", "goat.sensors.3.kind", "", "own, nearest", ""),
    "reproduction": ('kind = "simplified"', 'kind = "simple"', "goat.reproduction.kind", '"simple"',
                     "simplified, spread, asexual", "simplified"),
    "rate": ("rate = 0.01", "rate = -0.01", "goat.reproduction.rate", "-0.01", "at least 0", ""),
    "basal": ("basal = 0.01", "basal = -1", "goat.metabolism.basal", "-1", "at least 0", ""),
    "often": ("rate = 0.01", "rate = 2.0", "goat.reproduction.rate", "2.0", "at most 1 per second", ""),
    "chance": ("chance = 0.5", "chance = 1.5", "goat.diet.0.chance", "1.5", "at most 1", ""),
    "nan": ("basal = 0.01", "basal = nan", "goat.metabolism.basal", "nan", "finite", ""),
    "infinite": ("gain = 0.1", "gain = inf", "goat.diet.0.gain", "inf", "finite", ""),
    "text": ("count = 10", 'count = "10"', "goat.count", '"10"', "whole number", ""),
    "fraction": ("count = 10", "count = 10.5", "goat.count", "10.5", "whole number", ""),
    "true": ("dt = 1.0", "dt = true", "dt", "true", "number", ""),
    "zero dt": ("dt = 1.0", "dt = 0", "dt", "0", "more than 0", ""),
    "fewer than no goats": ("count = 10\n", "count = -1\n", "goat.count", "-1", "at least 0", ""),
    "no count": ("count = 10\n", "\n", "goat.count", "", "whole number", ""),
    "no species": (WORLD[WORLD.index("[species.grass]") :], "[species]", "species", "{}",
                   "at least 1 entries", ""),
    "no stones": ("count = 3\n", "count = 0\n", "objects.stone.count", "0", "at least 1", ""),
    "radius": ("radius = 5.0", "radius = 16.0", "goat.sensors.1.radius", "16.0", "at most 15 m", ""),
    "cell": ("cell = 2.0", "cell = 20.0", "fields.smoke.cell", "20.0", "at most 15 m", ""),
    "tiny cell": ("cell = 2.0", "cell = 1e-6", "fields.smoke.cell", "1e-06", "cells", ""),
    "body": ("radius = 0.4", "radius = 40.0", "goat.body.radius", "40.0", "at most 15 m", ""),
    "size": ("size = [40.0, 30.0]", "size = [40.0]", "space.size", "[40.0]", "at least 2 entries", ""),
    "edges": ('edges = "torus"', 'edges = "tours"', "space.edges", '"tours"', "torus, walls", "torus"),
    "key": ("basal = 0.01", "bassal = 0.01", "goat.metabolism.bassal", "0.01", "energy_max", "basal"),
    "section": ("[substances]", "[substance]", "substance", "{", "fields, objects", "substances"),
    "format": ("format = 1", "format = 2", "format", "2", "1", ""),
    "name": ('name = "meadow"', 'name = "my meadow"', "name", '"my meadow"', "text like", ""),
    "color": ("count = 10\n", 'count = 10\ncolor = "red"\n', "goat.color", '"red"', "#rrggbb", ""),
    "hyperparameter": ("horizon = 16", "horizn = 16", "goat.ppo.horizn", "16",
                       "horizon, learning_rate", "horizon"),
    "horizon": ("horizon = 16", "horizon = -1", "goat.ppo.horizon", "-1", ">= 1", ""),
    "max count": ("count = 10\n", "count = 10\nmax_count = 5\n", "goat.count", "10", "at most 5", ""),
    "energy": ("energy = 0.5", "energy = 1.5", "goat.metabolism.energy", "1.5", "at most energy_max", ""),
    "given": ("energy_given = 0.3", "energy_given = 0.8", "goat.reproduction.energy_given", "0.8",
              "energy_min", ""),
    "spacing": ("spacing = 1.0", "spacing = 9.0", "grass.reproduction.spacing", "9.0", "smaller spacing", ""),
    "near": ("energy_given = 0.3", 'energy_given = 0.3, place = "near"', "goat.reproduction.dispersal",
             "", "[m]", ""),
    "min max": ("min = 0.0", "min = 1.0, max = 0.9", "goat.lethal.0.min", "1.0", "less than 0.9", ""),
    "born dead": ("min = 0.0", "min = 0.5", "goat.lethal.0.min", "0.5", "interval", ""),
    "same name": ('{ kind = "touch"', '{ name = "energy", kind = "touch"', "goat.sensors.3.name", '"energy"',
                  "a name of its own", ""),
    "mean's name": ('{ kind = "touch"', '{ name = "smoke", kind = "touch"', "goat.sensors.3.name", '"smoke"',
                    "name", ""),
    "two kinds": ("[objects.stone]", "[objects.goat]", "objects.goat", '"goat"', "a name of its own", ""),
    "bad name": ("[objects.stone]", '[objects."a stone"]', 'objects.a stone', "", "a letter, then", ""),
    "policy file": ("hidden = [8]", 'hidden = [8], file = "goad.safetensors"', "goat.policy.file",
                    '"goad.safetensors"', "beside the world file", "goat.safetensors"),
    "remains": ("count = 10\n", 'count = 10\nremains = "stne"\n', "goat.remains", '"stne"', "stone", "stone"),
    "policy of none": ("count = 90", "count = 90\nppo = { horizon = 3 }", "grass.ppo", "{", "shared", ""),
    "training": ("[species.grass]", '[training]\nset = { "species.goat.count" = -3 }\n[species.grass]',
                 'training.set."species.goat.count"', "-3", "at least 0", ""),
}  # fmt: skip

FOLLOWED = {  # mistakes that break what others name
    *("smell", "touch", "group", "gait", "section", "two kinds", "bad name", "no species", "same name"),
    *("property", "mean's name"),
}
for case, row in CASES.items():
    CASES[case] = (*row[:2], re.sub("^(goat|grass)(?=[.]|$)", r"species.\1", row[2]), *row[3:])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "goat.safetensors").write_bytes(b"")
    return tmp_path


def refused(folder: Path, *arguments: str) -> str:
    """What the command says on stderr when it refuses; and that it leaves nothing."""
    before = sorted(folder.rglob("*"))
    done = CliRunner().invoke(app, [*arguments])
    assert done.exit_code == 2, done.output
    assert sorted(folder.rglob("*")) == before
    assert "Traceback" not in done.output
    return done.stderr


def run(folder: Path, text: str, *more: str) -> str:
    (folder / "meadow.toml").write_text(text)
    return refused(folder, "run", str(folder / "meadow.toml"), "--out", str(folder / "out"), *more)


def test_the_world_itself_is_not_refused(folder: Path) -> None:
    (folder / "meadow.toml").write_text(WORLD)
    assert CliRunner().invoke(app, ["check", str(folder / "meadow.toml")]).exit_code == 0


@pytest.mark.parametrize("case", CASES)
def test_a_wrong_file_is_refused(case: str, folder: Path) -> None:
    old, new, key, value, allowed, near = CASES[case]
    assert WORLD.count(old) == 1, f"{old} is not once in the world"
    output = run(folder, WORLD.replace(old, new))
    block = next((b for b in output.replace("\nmeadow", "\0meadow").split("\0") if f": {key}" in b), "")
    assert block.startswith("meadow.toml, line "), output
    head, _, tail = block.partition("\n")
    assert value in head.partition(key)[2]
    assert allowed in tail
    assert (f'did you mean "{near}"?' in tail) if near else ("did you mean" not in tail)


@pytest.mark.parametrize("case", ["food", "rate", "kind", "formula name", "key", "policy file"])
def test_the_line_is_that_of_the_key(case: str, folder: Path) -> None:
    old, new, key, *_ = CASES[case]
    output = run(folder, WORLD.replace(old, new))
    line = WORLD[: WORLD.index(old)].count("\n") + 1
    assert f"meadow.toml, line {line}: {key}" in output


@pytest.mark.parametrize("case", CASES)
def test_a_wrong_world_has_one_problem(case: str, folder: Path) -> None:
    """One mistake gives one message, but for mistakes that break what others name."""
    old, new, *_ = CASES[case]
    output = run(folder, WORLD.replace(old, new))
    assert output.startswith("meadow.toml: 1 problem\n") or case in FOLLOWED, output


def test_all_problems_are_told_at_once(folder: Path) -> None:
    text = WORLD
    for case in ("food", "rate", "key", "radius", "formula name", "cell", "fewer than no goats"):
        text = text.replace(*CASES[case][:2])
    output = run(folder, text)
    assert "meadow.toml: " in output
    # those of the goat's own section wait until its count is right
    for case in ("rate", "key", "cell", "fewer than no goats"):
        assert CASES[case][2] in output


def test_many_problems_stay_on_one_screen(folder: Path) -> None:
    eaten = ", ".join(f'{{ eats = "g{i}", gain = 0.1 }}' for i in range(40))
    output = run(folder, WORLD.replace('{ eats = "grass", gain = 0.1, chance = 0.5 }', eaten))
    assert "40 problems" in output
    assert "… and 25 more" in output
    assert output.count("species.goat.diet") == 15


@pytest.mark.parametrize(
    ("text", "line", "column", "what"),
    [("a = = 1", 1, 5, "Invalid value"), ("\nx = 1\nx = 2", 3, 6, "overwrite"), ("[a", 1, 3, "Expected")],
)
def test_what_is_not_toml_is_refused_with_line_and_column(
    text: str, line: int, column: int, what: str, folder: Path
) -> None:
    output = run(folder, text)
    assert f"meadow.toml, line {line}, column {column}" in output
    assert what in output


def test_a_file_that_is_no_text_is_refused(folder: Path) -> None:
    (folder / "meadow.toml").write_bytes(b"\xff\xfe\x00")
    assert "UTF-8" in refused(folder, "run", str(folder / "meadow.toml"), "--out", str(folder / "out"))


@pytest.mark.parametrize(
    ("change", "key", "value", "allowed", "near"),
    [
        ("species.deer.reproduction.rate=-1", "species.deer.reproduction.rate", "-1", "at least 0", ""),
        ("species.deer.birth_rate=-1", "species.deer.birth_rate", "-1", "at least 0", ""),
        ("species.dear.count=5", "species.dear.count", "5", "grass, deer, wolf", "deer"),
        ("specis.deer.count=5", "specis", "count", "species", "species"),
        ("species.wolf.diet.1.chance=0.5", "species.wolf.diet.1.chance", "0.5", "0 to 0", ""),
        ("species.wolf.count.x=0.5", "species.wolf.count.x", "0.5", "table or list", ""),
        ("species.wolf.policy.learn=True", "species.wolf.policy.learn", '"True"', "true or false", "true"),
        ("species.wolf.count=[1", "species.wolf.count", "[1", "for example", ""),
        ("species.wolf.count=1\nx=2", "species.wolf.count", "1", "for example", ""),
        ("species.wolf.count", "", "species.wolf.count", "for example", ""),
        ("=3", "", "=3", "for example", ""),
        ("fields.grass_smel.cell=3", "fields.grass_smel.cell", "3", "grass_smell", "grass_smell"),
    ],
)
def test_a_wrong_value_from_outside_is_refused(
    change: str, key: str, value: str, allowed: str, near: str, tmp_path: Path
) -> None:
    output = refused(tmp_path, "run", "predator-prey", "--set", change, "--out", str(tmp_path / "out"))
    head = next(line for line in output.splitlines() if line.startswith("--set: "))
    assert key in head
    assert value in head
    assert allowed in output
    assert (f'did you mean "{near}"?' in output) if near else ("did you mean" not in output)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["run", "predator-pray"], ["WORLD", '"predator-pray"', 'did you mean "predator-prey"?']),
        (["run", "nowhere/world.toml"], ["WORLD", '"nowhere/world.toml"', "no such file"]),
        (["check", "predator-pray"], ["WORLD", "predator-prey"]),
        (["train", "predator-pray"], ["WORLD", "predator-prey"]),
        (["compare", "predator-pray"], ["WORLD", "predator-prey"]),
        (["run", "predator-prey", "--policies", "trainde"],
         ["--policies", '"trainde"', 'did you mean "trained"?']),
        (["run", "predator-prey", "--policies", "."], ["--policies", "deer.safetensors is missing"]),
        (["run", "predator-prey", "--ticks", "0"], ["--ticks", "0"]),
        (["run", "predator-prey", "--ticks", "many"], ["--ticks", "many"]),
        (["run", "predator-prey", "--seed", "-1"], ["--seed", "-1"]),
        (["run", "predator-prey", "--threads", "0"], ["--threads", "0"]),
        (["run", "predator-prey", "--tick", "3"], ["--tick"]),
        (["compare", "predator-prey", "--control", "random-polcy"],
         ["--control", 'did you mean "random-policy"?']),
        (["compare", "predator-prey", "--control", "species.dear.count=3"],
         ["species.dear.count", 'mean "deer"?']),
        (["compare", "predator-prey", "--control", "dt=2", "--control", "dt=2"],
         ["--control", "named twice"]),
        (["report", "nowhere"], ["DIR", '"nowhere"', "ecs-eco run"]),
        (["report", "."], ["DIR", "manifest.json"]),
    ],
)
def test_wrong_arguments_are_refused(
    arguments: list[str], parts: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    output = refused(tmp_path, *arguments)
    for part in parts:
        assert part in output


@pytest.mark.parametrize("command", ["run", "train", "compare"])
@pytest.mark.parametrize(
    ("out", "what"),
    [("full", "not empty"), ("file", "is a file"), ("file/out", "cannot be written"),
     ("x" * 300, "cannot be written")],
)
def test_a_folder_that_cannot_take_results_is_refused(command: str, out: str, what: str,
                                                      tmp_path: Path) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "old").write_text("")
    (tmp_path / "file").write_text("")
    output = refused(tmp_path, command, "predator-prey", "--out", f"{tmp_path}/{out}")
    assert output.startswith("1 problem\n--out: ")
    assert what in output


def process(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from ecs_eco.cli import main; main()", *arguments]
    environment = os.environ | {"PYTHONPATH": str(Path(ecs_eco.__path__[0]).parent)}
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, timeout=60,
                          check=False)


def test_a_wrong_world_ends_the_process_with_2(folder: Path) -> None:
    (folder / "meadow.toml").write_text(WORLD.replace(*CASES["food"][:2]))
    done = process("run", "meadow.toml", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert 'did you mean "grass"?' in done.stderr
    assert not (folder / "runs").exists()


def test_a_folder_without_permission_ends_the_process_with_2(folder: Path) -> None:
    done = process("run", "predator-prey", "--out", "/proc/none/out", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("1 problem\n--out: ")
