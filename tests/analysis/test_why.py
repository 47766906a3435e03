"""Why a run went as it did: causes followed back by hand-made records, rates counted by hand,
pages and figures of real runs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ecs_eco.analysis.runs import DIED, Series
from ecs_eco.analysis.why import VERDICTS, Case, diagnose, explain, sentences, write_why
from ecs_eco.analysis.why.advice import REMEDIES, advise
from ecs_eco.analysis.why.case import in_force, look_up
from ecs_eco.analysis.why.diagnose import Fall, newborn, offspring, supply
from ecs_eco.analysis.why.figure import draw
from ecs_eco.analysis.why.limits import losses, phases, turns
from ecs_eco.analysis.why.page import chain as linked, chance, distance, effort
from ecs_eco.config import load
from ecs_eco.config.loading import changed
from ecs_eco.config.shipped import shipped
from ecs_eco.record import run_to_folder

TICKS = 100
HUNGER, AGE = "no energy left", "worn out"  # causes have the names that the world file gives them


def animal(eats: str, **more: Any) -> dict[str, Any]:
    """A species that eats: 0.1 energy of each."""
    return {
        "diet": [{"eats": eats, "gain": 0.1, "chance": 0.5, "deadly": False}],
        "metabolism": {"basal": 0.01},
        "reproduction": {
            "kind": "asexual",
            "place": "anywhere",
            "rate": 0.02,
            "energy_min": 0.6,
            "energy_given": 0.3,
        },
        "lethal": [
            {"property": "energy", "min": 0.0, "max": None, "cause_below": HUNGER, "cause_above": ""},
            {"property": "age", "min": None, "max": 300.0, "cause_below": "", "cause_above": AGE},
        ],
    } | more


PLANT = {"diet": [], "reproduction": {"kind": "spread", "rate": 0.03, "seed_rain": 0.001, "spacing": 2.0}}


def course(*points: tuple[int, float]) -> np.ndarray:
    """Numbers at each tick, straight between points."""
    return np.round(np.interp(np.arange(TICKS), *zip(*points, strict=True)))


def case(
    numbers: dict[str, np.ndarray],
    died: dict[tuple[str, str], np.ndarray],
    species: dict[str, Any],
    manifest: Any = None,
    deaths: Any = None,
    **columns: dict[str, np.ndarray],
) -> Case:
    """A record made by hand: numbers, deaths by cause, ledger columns by species; what is absent is 0."""
    names = tuple(numbers)
    table = {"n": np.column_stack(list(numbers.values())).astype(float)}
    for name in ("births", "taken_in", "burnt", "given", "lost"):
        table[name] = np.column_stack([columns.get(name, {}).get(s, np.zeros(TICKS)) for s in names])
    for cause in dict.fromkeys(c for _, c in died):
        table[DIED + cause] = np.column_stack([died.get((s, cause), np.zeros(TICKS)) for s in names])
    table["deaths"] = np.sum(
        [v for k, v in table.items() if k.startswith(DIED)] or [np.zeros_like(table["n"])], axis=0
    )
    config = {"species": species, "space": {"size": [10.0, 10.0], "edges": "torus"}}
    return Case(
        Series(np.arange(TICKS), names, table, {"config": config} | (manifest or {})),
        config,
        deaths or {},
        {},
    )


def grazed(left: float, caught: float = 1.0) -> Case:
    """Plants fall from 1,000 to a share of it; 100 grazers, which ate 10 a tick of them,
    starve from tick 50 on."""
    n = {
        "wolf": course((0, 1000), (50, 1000 * left), (99, 1000 * left)),
        "grass": course((0, 100), (50, 100), (80, 0), (99, 0)),
    }
    eaten = caught * np.where(n["grass"] > 0, 20.0, 0.0)
    fell = -np.diff(n["grass"], prepend=100)  # animals that die in a tick are not in its count
    return case(
        n,
        {("wolf", "eaten by grass"): eaten, ("grass", HUNGER): np.maximum(fell, 0)},
        {"wolf": PLANT, "grass": animal("wolf")},
        burnt={"grass": 0.01 * n["grass"]},
    )


def test_grazers_that_starve_when_plants_are_gone_have_overgrazed_whatever_their_names() -> None:
    diagnosis = diagnose(grazed(0.05))
    assert (diagnosis["verdict"], diagnosis["species"], diagnosis["victim"]) == (
        "overgrazing",
        "grass",
        "wolf",
    )
    assert diagnosis["confidence"] == pytest.approx(1)
    (fell,) = diagnosis["fell"]
    assert (fell["tick"], fell["since"], fell["extinct"]) == (80, 65, True)
    assert fell["causes"]["scarce: wolf"] == pytest.approx(1)
    assert diagnosis["evidence"]["weights"] == {"overgrazing": pytest.approx(1)}
    assert diagnosis["evidence"]["of"] == "grass"
    assert diagnosis["evidence"]["deaths_starved"] == fell["deaths"] == 50


def test_grazers_that_starve_among_plants_starve_amid_plenty() -> None:
    assert diagnose(grazed(0.97))["verdict"] == "starved amid plenty"


def test_supply_is_what_was_left_and_what_all_of_it_would_have_fed() -> None:
    run = grazed(0.05)
    (food,) = supply(run, Fall("grass", 65, 80, True))
    assert food["left"] == pytest.approx(0.05)
    eaten, met = 20.0 * 80, float((run.series.of("grass") * run.series.of("wolf"))[:81].sum())
    assert food["feeds"] == pytest.approx(eaten / met * 1000 * 0.1 / 0.01)


def chain(
    prey: np.ndarray,
    hunters: np.ndarray,
    eaten: np.ndarray,
    hunger: np.ndarray,
    old: np.ndarray | None = None,
    **more: Any,
) -> Case:
    """Plants in plenty, their grazers, and hunters of these."""
    n = {"a": course((0, 500), (99, 500)), "b": prey, "c": hunters}
    old = np.zeros(TICKS) if old is None else old
    died = {
        ("a", "eaten by b"): prey / 10,
        ("b", "eaten by c"): eaten,
        ("c", HUNGER): hunger,
        ("c", AGE): old,
    }
    burnt = {"b": 0.01 * prey, "c": 0.01 * hunters}
    return case(n, died, {"a": PLANT, "b": animal("a"), "c": animal("b", **more)}, burnt=burnt)


def test_hunters_that_eat_all_prey_and_starve_were_too_good() -> None:
    prey, hunters = course((0, 200), (40, 0), (99, 0)), course((0, 20), (60, 20), (80, 0), (99, 0))
    diagnosis = diagnose(
        chain(
            prey, hunters, np.maximum(-np.diff(prey, append=0), 0), np.maximum(-np.diff(hunters, append=0), 0)
        )
    )
    assert (diagnosis["verdict"], diagnosis["species"], diagnosis["victim"]) == (
        "predators too good",
        "c",
        "b",
    )
    assert [f["species"] for f in diagnosis["fell"]] == ["b", "c"]


def test_hunters_that_catch_too_little_among_prey_were_too_few() -> None:
    prey, hunters = course((0, 200), (99, 400)), course((0, 20), (40, 0), (99, 0))
    diagnosis = diagnose(
        chain(
            prey,
            hunters,
            np.where(np.arange(TICKS) % 10 == 0, 1.0, 0.0),
            np.maximum(-np.diff(hunters, append=0), 0),
        )
    )
    assert (diagnosis["verdict"], diagnosis["species"]) == ("predators too few", "c")


def test_hunters_that_age_and_hardly_breed_were_too_few() -> None:
    prey, hunters = course((0, 200), (99, 300)), course((0, 20), (90, 0), (99, 0))
    way = {"kind": "asexual", "place": "anywhere", "rate": 0.001, "energy_min": 0.6, "energy_given": 0.3}
    run = chain(
        prey,
        hunters,
        hunters / 5,
        np.zeros(TICKS),
        np.maximum(-np.diff(hunters, append=0), 0),
        reproduction=way,
    )
    assert offspring(run, "c") == pytest.approx(0.3)
    assert diagnose(run)["verdict"] == "predators too few"


def test_hunters_that_starved_in_a_trough_of_prey_are_not_to_blame_for_its_later_end() -> None:
    n = {
        "a": course((0, 500), (20, 20), (40, 20), (60, 500), (80, 10), (99, 400)),
        "b": course((0, 100), (20, 100), (40, 5), (65, 100), (90, 0)),
        "c": course((0, 10), (30, 10), (50, 0)),
    }
    fell = {s: np.maximum(-np.diff(v, append=v[-1]), 0) for s, v in n.items()}
    died = {
        ("a", "eaten by b"): n["b"] / 5,
        ("b", HUNGER): fell["b"],
        ("b", "eaten by c"): n["c"] / 20,
        ("c", HUNGER): fell["c"],
    }
    diagnosis = diagnose(
        case(n, died, {"a": PLANT, "b": animal("a"), "c": animal("b")}, burnt={s: 0.01 * n[s] for s in "bc"})
    )
    assert [f["species"] for f in diagnosis["fell"]] == ["c", "b"]
    assert diagnosis["fell"][0]["causes"]["scarce: b"] > 0.9
    assert (diagnosis["verdict"], diagnosis["species"], diagnosis["victim"]) == ("overgrazing", "b", "a")


def test_newborn_that_cannot_last_until_a_meal_starve() -> None:
    n = {"a": course((0, 500), (99, 500)), "b": course((0, 100), (90, 0), (99, 0))}
    fell = np.maximum(-np.diff(n["b"], append=0), 0)
    born = np.where(n["b"] > 0, 2.0, 0.0)
    way = {"kind": "asexual", "place": "anywhere", "rate": 0.02, "energy_min": 0.6, "energy_given": 0.01}
    tick = np.repeat(np.arange(2, 90), 2)
    deaths = {"b": {"tick": tick, "age": np.ones(len(tick)), "cause": np.full(len(tick), HUNGER)}}
    died = {("a", "eaten by b"): n["b"] / 8, ("b", HUNGER): born, ("b", AGE): fell}
    run = case(
        n,
        died,
        {"a": PLANT, "b": animal("a", reproduction=way)},
        deaths=deaths,
        births={"b": born},
        burnt={"b": 0.01 * n["b"]},
    )
    young = newborn(run, Fall("b", 45, 90, True))
    assert young["lasts"] == pytest.approx(1)
    assert young["meal_every"] == pytest.approx(8)
    assert young["births"] == 2 * 90
    assert young["starved_young"] == pytest.approx(2 * 88 / (2 * 90))
    assert diagnose(run)["verdict"] == "newborns starve"


def test_poison_that_takes_what_was_lacking_is_to_blame() -> None:
    run = grazed(0.97)
    assert run.toll("grass").sum() == 0
    species = {"wolf": PLANT | {"defence": {"poison": 0.09}}, "grass": animal("wolf")}
    poisoned = Case(run.series, {**run.config, "species": species}, {}, {})
    assert poisoned.toll("grass")[0] == pytest.approx(20 * 0.09)
    assert diagnose(poisoned)["verdict"] == "poisoned"


@pytest.mark.parametrize(
    ("cause", "verdict"), [("poisoned by a", "poisoned"), ("shot", "removed"), ("too hot", "surroundings")]
)
def test_causes_of_their_own_have_verdicts_of_their_own(cause: str, verdict: str) -> None:
    n = {"a": course((0, 500), (99, 500)), "b": course((0, 100), (50, 0), (99, 0))}
    cull = [[3, {"kind": "cull", "species": "b", "share": 0.5, "cause": "shot"}]]
    run = case(
        n,
        {("b", cause): np.maximum(-np.diff(n["b"], append=0), 0)},
        {"a": PLANT, "b": animal("a")},
        {"intervened": cull},
    )
    assert diagnose(run)["verdict"] == verdict


def test_a_run_in_which_all_live_is_healthy_and_one_without_anybody_says_so() -> None:
    n = {"a": course((0, 500), (99, 500)), "b": course((0, 100), (99, 90))}
    diagnosis = diagnose(case(n, {("b", AGE): np.ones(TICKS)}, {"a": PLANT, "b": animal("a")}))
    assert (diagnosis["verdict"], diagnosis["confidence"], diagnosis["fell"]) == ("healthy", 1.0, [])
    assert (
        diagnose(case({"a": np.zeros(TICKS)}, {("a", AGE): np.zeros(TICKS)}, {"a": PLANT}))["verdict"]
        == "nobody"
    )


def test_a_stopped_run_is_told_by_who_has_as_good_as_died_out() -> None:
    n = {"a": course((0, 500), (99, 20)), "b": course((0, 100), (50, 100), (99, 2))}
    died = {("a", "eaten by b"): n["b"] / 5, ("b", HUNGER): np.maximum(-np.diff(n["b"], append=2), 0)}
    stopped = {"finished": False, "ticks": 500}
    run = case(n, died, {"a": PLANT, "b": animal("a")}, stopped, burnt={"b": 0.01 * n["b"]})
    diagnosis = diagnose(run)
    assert diagnosis["verdict"] == "overgrazing"
    assert not diagnosis["fell"][0]["extinct"]
    findings = sentences(run, explain(run))["What happened"]
    assert "stopped at tick 100 of 500" in findings[0]
    assert "nearly died out" in findings[1]


def test_a_meadow_that_is_always_full_falls_because_it_is_grazed() -> None:
    n = {"algae": course((0, 1000), (50, 1000), (99, 100)), "snail": course((0, 10), (50, 10), (99, 90))}
    eaten = np.where(np.arange(TICKS) < 50, 0.06, 0.09) * n["algae"]
    plant = PLANT | {"reproduction": {"kind": "spread", "rate": 0.3, "spacing": 1.0}}
    run = case(
        n,
        {("algae", "eaten by snail"): eaten},
        {"algae": plant, "snail": animal("algae")},
        births={"algae": 0.06 * n["algae"]},
        burnt={"snail": 0.01 * n["snail"]},
    )
    full, fell = phases(run, "algae")
    assert [(p["trend"], p["limit"], p["by"]) for p in (full, fell)] == [
        ("held", "room", "level"),
        ("fell", "predators", "rise"),
    ]
    assert (fell["share"] > 0.95, fell["losses"]["room"] > fell["losses"]["predators"]) == (True, True)
    assert any(
        "limited mainly by animals that eat it" in w
        for w in sentences(run, explain(run))["What limited each species"]
    )


def test_losses_are_counted_per_head_and_tick() -> None:
    n = {"a": np.full(TICKS, 50.0), "b": np.full(TICKS, 10.0)}
    first = np.arange(TICKS) < 4
    died = {("b", HUNGER): 2.0 * first, ("b", "eaten by c"): 1.0 * first, ("b", AGE): 0.5 * first}
    lost = losses(case(n, died, {"a": PLANT, "b": animal("a")}, births={"b": np.full(TICKS, 0.1)}), "b", 0, 8)
    assert lost["food"] == pytest.approx(8 / 80)
    assert lost["predators"] == pytest.approx(4 / 80)
    assert lost["age"] == pytest.approx(2 / 80)
    assert lost["room"] == pytest.approx(0.02 - 0.01)  # at the rate, less those that were born
    assert lost["poison"] == lost["removal"] == lost["surroundings"] == 0


def test_a_course_turns_where_it_turns() -> None:
    n = np.concatenate([np.linspace(10, 1000, 100), np.linspace(1000, 20, 100), np.linspace(20, 800, 100)])
    marks = turns(n)
    assert (marks[0], marks[-1], len(marks)) == (0, 300, 4)
    assert abs(marks[1] - 100) < 5
    assert abs(marks[2] - 200) < 5
    assert turns(np.full(300, 7.0)) == [0, 300]
    assert len(turns(100 + 90 * np.sin(np.arange(3000) / 20))) <= 9


@pytest.mark.parametrize(("edges", "metres"), [("torus", 2.0), ("walls", 8.0)])
def test_distance_is_that_to_the_nearest_of_the_other_species(edges: str, metres: float) -> None:
    at = {"tick": np.zeros(1), "z": np.zeros(1), "energy": np.ones(1), "y": np.full(1, 5.0)}
    run = grazed(0.5)
    near = Case(
        run.series,
        run.config | {"space": {"size": [10.0, 10.0], "edges": edges}},
        {},
        {"grass": at | {"x": np.array([1.0])}, "wolf": at | {"x": np.array([9.0])}},
    )
    distance_ = distance(near, "grass", "wolf", 0, 10)
    assert distance_ is not None
    assert distance_["mean"] == pytest.approx(metres)
    assert distance_["to_chance"] == pytest.approx(metres / 5)


def test_chance_is_the_distance_at_random_places() -> None:
    assert chance(4, [4.0, 4.0]) == pytest.approx(1.0)
    points = np.random.default_rng(1).uniform(0, 10, (4000, 50, 3))
    inner = np.linalg.norm(points - 5, axis=2).min(1).mean()
    assert chance(50, [10.0, 10.0, 10.0]) == pytest.approx(inner, rel=0.02)


def test_effort_is_the_share_of_the_dearest_gait() -> None:
    run = case(
        {"b": np.ones(TICKS)},
        {("b", AGE): np.zeros(TICKS)},
        {"b": animal("a", locomotion={"cost": {"walk": 0.01, "run": 0.04}})},
    )
    assert effort(run, "b", 0.02) == pytest.approx(0.25)
    assert effort(grazed(0.5), "grass", 0.02) is None


def test_values_that_interventions_set_are_those_that_are_told() -> None:
    config = {"species": {"b": {"diet": [{"chance": 0.5}], "defence": None}}}
    done = {
        "set": {
            "species.b.diet.0.chance": 0.1,
            "species.b.diet.0.gain": 3,  # left out of the file, because it has its default value
            "species.b.diet.7.chance": 1,
            "species.b.defence.poison": 1,
        },
        "kind": "set",
    }
    now = in_force({"config": config, "intervened": [[5, done]]})
    assert look_up(now, "species.b.diet.0.chance") == 0.1
    assert look_up(now, "species.b.diet.0.gain") == 3
    assert look_up(now, "species.b.diet.7.chance") is look_up(now, "species.b.defence.poison") is None
    assert config["species"]["b"]["diet"][0]["chance"] == 0.5


@pytest.mark.parametrize("world", sorted(shipped()))
def test_every_value_to_turn_is_one_that_a_world_file_may_set(world: str) -> None:
    config = load(world)
    names = tuple(config.species)
    run = Case(Series(np.arange(1), names, {"n": np.ones((1, len(names)))}), config.resolved(), {}, {})
    seen: dict[str, Any] = {}
    for s in names:
        for verdict in REMEDIES:
            victim = next((f.eats for f in run.diet(s)), s)
            for turn in advise(run, {"verdict": verdict, "species": s, "victim": victim}):
                assert turn["turn"] in ("higher", "lower")
                seen[turn["key"]] = turn["value"]
    assert seen
    assert changed(config, seen).config_hash == config.config_hash
    assert set(REMEDIES) == set(VERDICTS) - {"healthy", "nobody"}


def test_nothing_is_to_be_turned_beyond_its_end() -> None:
    run = Case(grazed(0.5).series, {"species": {"wolf": PLANT, "grass": animal("wolf", count=1)}}, {}, {})
    run.config["species"]["grass"]["diet"][0]["chance"] = 1.0
    keys = {
        (a["key"], a["turn"])
        for a in advise(run, {"verdict": "starved amid plenty", "species": "grass", "victim": "grass"})
    }
    assert ("species.grass.diet.0.chance", "higher") not in keys
    assert ("species.grass.diet.0.gain", "higher") in keys
    keys = {
        (a["key"], a["turn"])
        for a in advise(run, {"verdict": "overgrazing", "species": "grass", "victim": "wolf"})
    }
    assert ("species.grass.diet.0.chance", "lower") in keys
    assert ("species.grass.count", "lower") not in keys


@pytest.fixture(scope="module")
def starving(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run in which wolves cannot catch anything."""
    out = tmp_path_factory.mktemp("why") / "run"
    few = {
        "species.grass.count": 300,
        "species.deer.count": 60,
        "species.wolf.count": 12,
        "species.wolf.diet.0.chance": 0.0,
        "species.wolf.metabolism.basal": 0.02,
        "interventions": [{"kind": "cull", "at": 3, "species": "deer", "count": 5}],
    }
    run_to_folder(load("predator-prey", few), 1, 60, out, "random", report=False)
    return out


@pytest.mark.slow
def test_a_recorded_run_is_explained_in_a_page_a_figure_and_json(starving: Path, tmp_path: Path) -> None:
    findings = write_why(starving, tmp_path)
    assert json.loads((tmp_path / "why.json").read_text()) == findings
    assert (findings["verdict"], findings["species"]) == ("predators too few", "wolf")
    assert findings["parameters"][0]["key"] == "species.wolf.diet.0.chance"
    assert findings["parameters"][0]["turn"] == "higher"
    assert findings["interventions"] == {"cull 5 deer": 1}
    page = (tmp_path / "why.html").read_text()
    assert "wolf died out at tick" in page
    assert "species.wolf.diet.0.chance" in page
    assert (tmp_path / "figures" / "why.svg").stat().st_size > 10_000
    assert findings["conduct"]["wolf"][0]["enemies"] == {}
    assert findings["conduct"]["deer"][0]["enemies"]["wolf"]["mean"] > 0


def test_the_figure_marks_the_end_of_a_species_and_stacks_causes_to_one(starving: Path) -> None:
    run = Case.read(starving)
    findings = explain(run)
    top, *panels = draw(run, findings).axes
    crosses = [line for line in top.get_lines() if line.get_marker() == "x"]
    ends = sorted(f["tick"] for f in findings["fell"] if f["extinct"])
    assert sorted(line.get_xdata()[0] for line in crosses) == ends != []
    assert top.get_yscale() == "log"
    wolves = next(p for p in panels if p.patches)
    heights = sum(p.get_height() for p in wolves.patches)
    assert heights == pytest.approx(len({p.get_x() for p in wolves.patches if p.get_height()}))


def test_food_that_was_never_there_is_said_to_be_missing():
    none = {"eats": "green", "left": 0.0, "full": 0.0, "feeds": 0.0, "gain": 0.2}
    fell = {"species": "goat", "causes": {"scarce: green": 0.83}, "food": [none], "newborn": {}}
    (line,) = linked(None, {"fell": [fell]})
    assert line == "goat (83% of its decline): starvation because there was no green."
