"""The ODD of a world holds the seven elements, the world's own numbers, and nothing that the world does not use."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from ecs_eco import World
from ecs_eco.components import Position
from ecs_eco.config.shipped import shipped
from ecs_eco.odd import describe
from ecs_eco.odd.concepts import CONCEPTS

EXAMPLES = Path(__file__).parents[2] / "examples"
ELEMENTS = [
    "1. Purpose and patterns",
    "2. Entities, state variables and scales",
    "3. Process overview and scheduling",
    "4. Design concepts",
    "5. Initialization",
    "6. Input data",
    "7. Submodels",
]
UNSAID = ("color", "viewer", "search", "device")  # keys without meaning in biology
MEADOW: dict[str, Any] = {
    "format": 1,
    "name": "meadow",
    "space": {"size": [20.0, 20.0]},
    "species": {
        "grass": {
            "count": 10,
            "body": {"radius": 0.2},
            "reproduction": {"kind": "spread", "rate": 0.03, "spacing": 2.0},
        }
    },
}


@cache
def text_of(name: str) -> str:
    return describe(name).markdown()


def headings(text: str, level: int) -> list[str]:
    return re.findall(rf"^{'#' * level} (.*)$", text, re.MULTILINE)


def rows_of(text: str) -> Iterator[dict[str, str]]:
    """Yield the rows of all tables, by their heads."""
    head: list[str] = []
    for line in text.splitlines():
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] if line.startswith("|") else []
        if cells and not head:
            head = cells
        elif cells and set("".join(cells)) != {"-"}:
            yield dict(zip(head, cells, strict=True))
        elif not cells:
            head = []


def numbers_in(value: object, key: str = "") -> Iterator[tuple[str, float]]:
    """Yield the numbers of a table of a world file with their dotted keys; lists of tables are left out."""
    if isinstance(value, Mapping):
        for name, one in value.items():
            if name not in UNSAID:
                yield from numbers_in(one, f"{key}.{name}".lstrip("."))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield key, float(value)


def entries_in(value: object, key: str = "") -> Iterator[tuple[str, Mapping[str, Any]]]:
    if isinstance(value, Mapping):
        for name, one in value.items():
            yield from entries_in(one, f"{key}.{name}".lstrip("."))
    elif isinstance(value, list):
        yield from ((key, one) for one in value if isinstance(one, Mapping))


def number(cell: str) -> float:
    return float(cell.strip("`").replace(",", ""))


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_world_has_the_seven_elements_and_the_eleven_concepts_in_order(name: str) -> None:
    assert headings(text_of(name), 2) == ELEMENTS
    concepts = text_of(name).partition(f"## {ELEMENTS[3]}")[2].partition(f"## {ELEMENTS[4]}")[0]
    assert headings(concepts, 3) == [*CONCEPTS]


@pytest.mark.parametrize("name", shipped())
def test_each_number_of_a_kind_stands_with_its_key_as_in_the_world_file(name: str) -> None:
    data = tomllib.loads(shipped()[name].read_text(encoding="utf-8"))
    rows = [*rows_of(text_of(name))]
    compared = 0
    for kind, section in {**data["species"], **data.get("objects", {})}.items():
        known = {row["parameter"].strip("`"): row[kind] for row in rows if "parameter" in row and kind in row}
        written = {
            (row["parameter"].strip("`"), row[kind]) for row in rows if "parameter" in row and kind in row
        }
        for key, value in numbers_in(section):
            if key == "metabolism.energy" or key in known:
                cells = [cell for other, cell in written if other == key and cell != "–"]
                assert [number(cell) for cell in cells] == [pytest.approx(value)] * len(cells), key
            assert key in known, f"{kind}.{key} is missing"
            compared += 1
    assert compared > 10


@pytest.mark.parametrize("name", shipped())
def test_each_number_of_a_list_stands_in_a_row_of_its_kind(name: str) -> None:
    data = tomllib.loads(shipped()[name].read_text(encoding="utf-8"))
    rows = [row for row in rows_of(text_of(name)) if "entry" in row]
    for kind, section in data["species"].items():
        for key, entry in entries_in(section):
            mine = [
                row
                for row in rows
                if row.get("kind") == kind and row["entry"].strip("`").startswith(f"{key}.")
            ]
            for field, value in numbers_in(entry):
                cells = [c for row in mine for h, c in row.items() if h.partition(" [")[0] == field and c]
                assert any(number(cell) == pytest.approx(value) for cell in cells), f"{kind}.{key}.{field}"


@pytest.mark.parametrize("name", shipped())
def test_each_number_of_the_surroundings_and_of_time_is_that_of_the_world_file(name: str) -> None:
    data = tomllib.loads(shipped()[name].read_text(encoding="utf-8"))
    text, rows = text_of(name), [*rows_of(text_of(name))]
    values = {
        row["parameter"].strip("`"): row["value"] for row in rows if {"parameter", "value"} <= row.keys()
    }
    for part in ("sun", "year", "water", "terrain", "ambient"):
        for key, value in numbers_in(data.get(part, {}), part):
            assert number(values[key]) == pytest.approx(value), key
    cells = {row["entry"].strip("`"): row for row in rows if "entry" in row}
    for field, section in data.get("fields", {}).items():
        for key, value in numbers_in(section):
            row = {head.partition(" [")[0]: cell for head, cell in cells[f"fields.{field}"].items()}
            assert number(row[key]) == pytest.approx(value), f"{field}.{key}"
    assert f"{data['ticks']:,} ticks = {data['ticks'] * data['dt']:,g} s" in text
    assert " × ".join(f"{size:g}" for size in data["space"]["size"]) + " m" in text


@pytest.mark.parametrize("name", shipped())
def test_each_system_of_the_schedule_is_mentioned(name: str) -> None:
    world = World.from_config(name, populate=False, record=False)
    missing = [s for s in world.systems if f"`{type(s).__name__}`" not in text_of(name)]
    assert missing == []


@pytest.mark.parametrize(
    ("name", "there", "absent"),
    [
        ("predator-prey", "Feeding", "Body temperature"),
        ("island", "Body temperature", "Sexual reproduction"),
        ("reflexes", "Sexual reproduction", "Water"),
        ("diel-migration", "Water", "Spread of plants"),
        ("happiness", "Defence", "Growth by light"),
        ("lamb", "Suckling", "Feeding"),
    ],
)
def test_a_submodel_is_described_only_where_a_world_uses_it(name: str, there: str, absent: str) -> None:
    assert there in headings(text_of(name), 3)
    assert absent not in headings(text_of(name), 3)


def test_a_meadow_without_animals_has_no_predation_no_senses_and_no_learning() -> None:
    text = describe(MEADOW).markdown()
    assert headings(text, 3)[-2:] == ["Aging", "Spread of plants"]
    for word in ("Strannegård", "PPO (", "energy_min", "speed of the gait"):
        assert word not in text
    assert "| `reproduction.rate` | 1/s | 0.03 | births per parent per second while all other sites " in text
    assert "Individuals do not learn." in text
    assert "Individuals sense nothing." in text


def test_a_value_set_for_a_run_is_the_value_in_the_description() -> None:
    meadow = MEADOW | {"species": {"grass": MEADOW["species"]["grass"] | {"count": 77}}}
    assert "| `count` | 77 | organisms at the start |" in describe(meadow).markdown()


@pytest.mark.parametrize("name", shipped())
def test_reflexes_decide_only_in_groups_in_which_a_connection_or_formula_acts(name: str) -> None:
    species = World.from_config(name, populate=False, record=False).config.species  # type: ignore[union-attr]
    rows = [row for row in rows_of(text_of(name)) if "decided by" in row]
    assert {row["species"] for row in rows} == {kind for kind, one in species.items() if one.actions}
    for row in rows:
        reflex = species[row["species"]].reflex
        acted = [] if reflex is None else [*reflex.formulas, *(one.action for one in reflex.connections)]
        assert ("reflexes" in row["decided by"]) == bool({*row["actions"].split(", ")} & {*acted})


def test_networks_are_attributed_to_the_species_that_have_them() -> None:
    text = text_of("diel-migration")
    assert "an innate reflex network (krill) and a policy (copepod)" in text
    assert (
        "`0.5 × energy + 0 × berry_near + 0 × nightshade_near + 0 × vole_near`, with weights from genes"
        in (text_of("happiness"))
    )
    assert "| goat | individual | weights in the genome |" in text_of("innate")
    assert "Before the run, settings may differ" not in text_of("innate")


def test_processes_of_fields_concern_the_world_and_deaths_the_kinds_that_can_die() -> None:
    entities = {
        name: {
            row["process"].strip("`"): row["entities"] for row in rows_of(text_of(name)) if "process" in row
        }
        for name in ("lamb", "learning-krill")
    }
    assert [one["Diffuse"] for one in entities.values()] == ["the world", "the world"]
    assert [one["Perish"] for one in entities.values()] == ["lamb", "all"]


def test_landmarks_are_entities_without_constants_and_mates_interact_within_reach() -> None:
    text = text_of("island")
    assert "| lakes | landmark or other object |" in text
    assert all("lakes" not in row for row in rows_of(text) if "parameter" in row)
    assert "| goat | goat | `reproduction.reach` | 12 m |" in text_of("reflexes")


def test_own_code_is_named_as_a_source_of_draws_and_its_constants_are_listed() -> None:
    assert "may draw other numbers (element 7): `ecs_eco.worlds.diel_migration.senses:whim`." in (
        text_of("diel-migration")
    )
    assert "| `MOUTH` | rad | [-1.6, 1.6] | where it touches an udder" in text_of("lamb")


@pytest.mark.parametrize("name", shipped())
def test_every_name_in_an_equation_of_learning_is_a_setting(name: str) -> None:
    """`entropy` stood for `entropy_coef`, and no setting of that name exists."""
    text = text_of(name)
    for setting in ("entropy_coef", "value_weight", "discount", "gae_lambda", "clip", "horizon"):
        assert text.count(setting) >= 2, setting
        assert f"| `ppo.{setting}` |" in text


@pytest.mark.slow
def test_the_nearness_that_a_sensor_reads_is_the_one_described() -> None:
    eye = {"kind": "nearest", "target": "stone", "range": 4.0}
    species = {"deer": {"count": 0, "body": {"radius": 0.5}, "sensors": [eye]}}
    objects = {"stone": {"at": [[10.0, 10.0]], "body": {"radius": 0.5}}}
    world = World.from_config(MEADOW | {"species": species, "objects": objects}, record=False)
    world.spawn("deer", Position(x=9.0, y=10.0))  # in contact: 1 m from center to center
    world.flush()
    world.run(1)
    assert world.tables["deer"].species.nerves.x[0, 2] == pytest.approx(1 - 1.0 / 4.0)
    assert "name_near is 1 − distance/range" in text_of("predator-prey")


def test_who_learns_by_what_rate_and_for_what_is_said_of_each_species() -> None:
    text = text_of("lamb")
    assert "| lamb | during the run | one for each individual | 0.007 | 64 |" in text
    assert "| lamb | `-4 * (1 - oxygen)**2 - 3 * (1 - glucose)**2 + 1.5 * sheep_smell` | -7 |" in text
    assert "| deer | before the run and during the run | one for all members | 0.004 | 64 |" in text_of(
        "predator-prey"
    )
    means = "wolf_smell is the mean of wolf_smell_1 and wolf_smell_2"
    assert f"| deer | `energy - 0.3 * wolf_smell`, where {means} | -1 |" in text_of("predator-prey")


def test_interventions_are_input_with_their_ticks() -> None:
    cull = {"kind": "cull", "species": "grass", "share": 0.5, "at": 40, "every": 20, "until": 80}
    text = describe(MEADOW | {"interventions": [cull]}).markdown()
    assert "- At tick 40, then every 20 ticks until tick 80: cull 50% of grass." in text
    assert "no input data" in describe(MEADOW).markdown()


def test_own_features_components_systems_and_reporters_are_described_from_their_code() -> None:
    text = describe(EXAMPLES / "epidemic.toml", trust=True).markdown()
    assert "| `Health.state` |  | well, ill or immune | people | dynamic |" in text
    assert "| `Health.left` | s | of illness | people | dynamic |" in text
    assert (
        "`Infect`: Infect healthy members near infected ones; infected members recover and become immune."
        in text
    )
    assert "| `disease.beta` | 1/s | 0.1 | probability of infection per infected neighbor |" in text
    assert "| `speed` | 1 |" in text
    assert "| immune | `sir:prevalence (state = 2)` |" in text


def test_a_world_built_in_python_is_described_from_its_tables_and_systems() -> None:
    module = import_module("examples.without_toml")
    world = World((60.0, 60.0), seed=4, dt=0.5)
    world.add_table("people", module.Position, module.Body, module.Health)
    world.add_system(module.Walk())
    world.add_system(module.Infect())
    text = describe(world).markdown()
    assert headings(text, 2) == ELEMENTS
    assert "| `Health.left` | s | of illness | people | dynamic |" in text
    assert "| extent | 60 × 60 m |" in text
    assert "| time step | 0.5 s |" in text
    assert "random seed is 4" in text
    assert "`Infect`: Infect people within 2 m of an ill person; ill people become immune after 60 s." in text


def test_an_archipelago_is_described_with_its_migration() -> None:
    text = describe(EXAMPLES / "islands.toml").markdown()
    assert "Migration" in headings(text, 3)
    assert "| `archipelago.migration_interval` | ticks |" in text


def test_the_purpose_is_the_description_else_the_readme_else_the_comment_at_the_head(tmp_path: Path) -> None:
    file = tmp_path / "meadow.toml"
    body = 'format = 1\nname = "meadow"\nspace = { size = [20.0, 20.0] }\n'
    body += "[species.grass]\ncount = 3\nbody = { radius = 0.2 }\n"
    file.write_text(f"# Grass that\n#   ecs-eco run meadow.toml\n# stands.\n{body}", encoding="utf-8")
    assert "\n\nGrass that stands.\n\n" in describe(file).markdown()
    (tmp_path / "README.md").write_text(
        "# A meadow\n\nWhy grass\n[stands](x.md).\n\nMore.\n", encoding="utf-8"
    )
    assert "\n\nWhy grass stands.\n\n" in describe(file).markdown()
    (tmp_path / "README.md").write_text("# Pré\n\nL'été.\n", encoding="latin-1")
    assert "\n\nL'\ufffdt\ufffd.\n\n" in describe(file).markdown()
    file.write_text(body.replace("[species", 'description = "To see."\n[species', 1), encoding="utf-8")
    assert "\n\nTo see.\n\n" in describe(file).markdown()


def test_patterns_are_listed_and_change_no_hash_of_a_world() -> None:
    from ecs_eco.config import load

    judged = load(MEADOW | {"patterns": ["Grass covers the ground."]})
    assert "- Grass covers the ground." in describe(judged).markdown()
    assert judged.config_hash == load(MEADOW).config_hash


def test_the_page_of_html_has_the_same_headings_and_marks_code_and_escapes_the_rest() -> None:
    page = describe(MEADOW | {"title": "Grass <b> & more"}).html()
    assert re.findall(r"<h2>(.*)</h2>", page) == ELEMENTS
    assert "<code>reproduction.rate</code>" in page
    assert "Grass &lt;b&gt; &amp; more" in page
