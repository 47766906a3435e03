"""The JSON schema of world files: shipped worlds fit it, and it marks what is wrong."""

import json
import re
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecs_eco.cli.app import app
from ecs_eco.config.json_schema import json_schema
from ecs_eco.config.shipped import shipped
from studies.common.fuzz.sources import sources

TYPES = {
    "string": str,
    "integer": int,
    "number": (int, float),
    "boolean": bool,
    "object": dict,
    "array": list,
}
OF_NUMBERS = {"minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"}  # keywords that other values pass
OF_TABLES = {
    "required",
    "properties",
    "propertyNames",
    "patternProperties",
    "additionalProperties",
    "minProperties",
    "maxProperties",
}
ANNOTATIONS = {
    "$schema",
    "$defs",
    "title",
    "description",
    "default",
    "unit",
    "discriminator",
}  # limit nothing


def _wrong(value, schema, root, at=""):
    """What a schema says against a value: a small checker, which knows no other keywords than those it
    checks."""
    patterns = schema.get("patternProperties", {})
    keys = [k for k in value if k not in schema.get("properties", {})] if isinstance(value, dict) else []
    others = [k for k in keys if not any(re.search(p, k) for p in patterns)]
    checks = {
        "$ref": lambda s: _wrong(value, root["$defs"][s.removeprefix("#/$defs/")], root, at),
        "anyOf": lambda s: (
            [] if any(not _wrong(value, one, root, at) for one in s) else [f"{at}: none of anyOf"]
        ),
        "oneOf": lambda s: (
            [] if sum(not _wrong(value, one, root, at) for one in s) == 1 else [f"{at}: not one of oneOf"]
        ),
        "type": lambda s: (
            []
            if isinstance(value, TYPES[s]) and (s == "boolean" or not isinstance(value, bool))
            else [f"{at}: no {s}"]
        ),
        "const": lambda s: [] if value == s else [f"{at}: not {s}"],
        "enum": lambda s: [] if value in s else [f"{at}: none of {s}"],
        "minimum": lambda s: [] if value >= s else [f"{at}: below {s}"],
        "maximum": lambda s: [] if value <= s else [f"{at}: above {s}"],
        "exclusiveMinimum": lambda s: [] if value > s else [f"{at}: not above {s}"],
        "exclusiveMaximum": lambda s: [] if value < s else [f"{at}: not below {s}"],
        "minLength": lambda s: [] if len(value) >= s else [f"{at}: shorter than {s}"],
        "maxLength": lambda s: [] if len(value) <= s else [f"{at}: longer than {s}"],
        "minItems": lambda s: [] if len(value) >= s else [f"{at}: fewer than {s}"],
        "maxItems": lambda s: [] if len(value) <= s else [f"{at}: more than {s}"],
        "maxProperties": lambda s: [] if len(value) <= s else [f"{at}: more keys than {s}"],
        "minProperties": lambda s: [] if len(value) >= s else [f"{at}: fewer keys than {s}"],
        "pattern": lambda s: [] if re.search(s, value) else [f"{at}: not like {s}"],
        "required": lambda s: [f"{at}.{key}: missing" for key in s if key not in value],
        "items": lambda s: [w for i, x in enumerate(value) for w in _wrong(x, s, root, f"{at}.{i}")],
        "properties": lambda s: [
            w for key in s.keys() & value.keys() for w in _wrong(value[key], s[key], root, f"{at}.{key}")
        ],
        "propertyNames": lambda s: [w for key in value for w in _wrong(key, s, root, f"{at}.{key}")],
        "patternProperties": lambda s: [
            w for p in s for k in value if re.search(p, k) for w in _wrong(value[k], s[p], root, f"{at}.{k}")
        ],
        "additionalProperties": lambda s: [
            w
            for k in others
            for w in (
                []
                if s is True
                else [f"{at}.{k}: unknown"]
                if s is False
                else _wrong(value[k], s, root, f"{at}.{k}")
            )
        ],
    }
    kinds = [kind] if isinstance(kind := schema.get("type", []), str) else kind
    if kinds and all(checks["type"](one) for one in kinds):
        return checks["type"](kinds[0])
    passed = {"type", *(OF_NUMBERS if isinstance(value, dict) else OF_TABLES)}
    return [
        w
        for keyword, limit in schema.items()
        if keyword not in ANNOTATIONS | passed
        for w in checks[keyword](limit)
    ]


@pytest.mark.parametrize("world", shipped())
def test_every_shipped_world_fits_the_schema(world):
    schema = json_schema()
    assert _wrong(tomllib.loads(shipped()[world].read_text(encoding="utf-8")), schema, schema) == []


def test_a_world_with_ranges_fits_the_schema():
    schema, path = json_schema(), Path(__file__).parents[2] / "examples" / "dying_world.toml"
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    assert (
        _wrong(data | {"search": data["search"] | {"ranges": {"species.hare.count": [5, 9]}}}, schema, schema)
        == []
    )


def test_worlds_with_everything_fit_the_schema():
    schema = json_schema()
    for world in ("menagerie", "herd"):
        assert _wrong(tomllib.loads(sources()[world][0]), schema, schema) == []


@pytest.mark.parametrize(
    ("path", "value", "mark"),
    [
        (("species", "goat", "metabolism", "bassal"), 0.1, ".species.goat.metabolism.bassal: unknown"),
        (("species", "goat", "metabolism", "basal"), -0.1, ".species.goat.metabolism.basal: below 0.0"),
        (("species", "goat", "ppo", "horizon"), 0, ".species.goat.ppo.horizon: below 1"),
        (("species", "goat", "ppo", "horizn"), 3, ".species.goat.ppo.horizn: unknown"),
        (("species", "goat", "count"), "10", ".species.goat.count: no integer"),
        (("species", "a goat"), {}, ".species.a goat: unknown"),
        (("species", "goat", "genome", "ploidy"), 3, ".species.goat.genome.ploidy: none of [1, 2]"),
        (("space",), {}, ".space.size: missing"),
        (
            ("species", "goat", "count"),
            {"value": 10, "search": [5]},
            ".species.goat.count.search: fewer than 2",
        ),
        (("species", "goat", "count"), {"value": 10}, ".species.goat.count.search: missing"),
    ],
)
def test_the_schema_marks_what_is_wrong(path, value, mark):
    data, schema = tomllib.loads(sources()["herd"][0]), json_schema()
    node = data
    for part in path[:-1]:
        node = node[part]
    node[path[-1]] = value
    assert _wrong(data, schema, schema) == [mark]


def test_the_schema_has_units_and_no_null():
    schema = json_schema()
    assert schema["$defs"]["Metabolism"]["properties"]["basal"]["unit"] == "energy/s"
    assert (
        schema["$defs"]["Metabolism"]["properties"]["basal"]["description"]
        == "basal metabolic rate [energy/s]"
    )
    assert "null" not in json.dumps(schema)


def test_check_says_the_schema_and_needs_a_world_otherwise():
    done = CliRunner().invoke(app, ["check", "--schema"])
    assert json.loads(done.stdout) == json_schema()
    done = CliRunner().invoke(app, ["check"])
    assert done.exit_code == 2
    assert "WORLD" in done.stderr
