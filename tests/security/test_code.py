"""Nothing that is loaded runs code: every key that can name code, each tried with a module that leaves a
mark when it is run."""

import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from ecs_eco import World
from ecs_eco.config import load
from ecs_eco.config.checks.reporters import ARGUMENTS
from ecs_eco.engine.errors import ConfigError
from ecs_eco.genomes.operators import SAFE
from ecs_eco.inputs.code import SHIPPED, CodeError
from ecs_eco.record import resume, run_to_folder
from ecs_eco.runs.repeat import repeat
from studies.common.malicious.templates import KEYS, PAYLOAD, fields_that_name_code, world_of
from tests.security.worlds import written


def test_every_field_that_may_name_code_is_in_the_table() -> None:
    fields = fields_that_name_code()
    assert fields == {
        "systems",
        "components",
        "function",
        "current_function",
        "operator",
        "objective",
        "of",
        "network",
        "reporters",
        "use",
    }
    fields.discard("use")  # what stands in a table in the place of a name, with parameters
    assert {p.removesuffix(".*").rpartition(".")[2] for p in ARGUMENTS} == fields
    assert set(KEYS) == set(ARGUMENTS)


def test_the_page_lists_every_function_with_the_arguments_that_it_is_called_with() -> None:
    page = (Path(__file__).parents[2] / "docs/explanation/security.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`[^|]+`) \| an? [^|]+ \| ([^|]*) \|$", page, re.MULTILINE)
    listed = {key.strip("`"): len(given.split(", ")) for keys, given in rows for key in keys.split(", ")}
    for key, n in ARGUMENTS.items():
        if n:
            assert listed[key] == n, key


@pytest.mark.parametrize("pattern", KEYS)
def test_code_that_is_not_listed_is_refused_and_not_imported(pattern: str, mark: Path) -> None:
    path = written(mark.parent, world_of(pattern))
    with pytest.raises(ConfigError, match="`code` does not list"):
        load(path)
    with pytest.raises(ConfigError, match="`code` does not list"):
        load(path, trust=True)
    assert not mark.exists()
    assert "evil" not in sys.modules


@pytest.mark.parametrize("pattern", KEYS)
def test_listed_code_waits_until_it_is_allowed(pattern: str, mark: Path) -> None:
    path = written(mark.parent, world_of(pattern, code=["evil.py"]))
    config = load(path)  # all the rest is right
    with pytest.raises(CodeError, match=r"is not allowed to run[\s\S]*SHA-256[\s\S]*--trust"):
        World.from_config(config)
    assert not mark.exists()
    World.from_config(path, trust=True, record=False).run(1)
    assert mark.exists() or pattern.startswith("search")  # a run needs no objective
    assert "evil" not in sys.modules


TABLES = [p for p in KEYS if p.endswith("function") or p in ("systems.*", "reporters.*")]


@pytest.mark.parametrize("pattern", TABLES)
def test_code_that_is_named_in_a_table_with_parameters_is_no_exception(pattern: str, mark: Path) -> None:
    text = re.sub(r'"(evil:\w+)"', r'{"use": "\1"}', json.dumps(world_of(pattern)))
    path = written(mark.parent, json.loads(text))
    with pytest.raises(ConfigError, match="`code` does not list"):
        load(path)
    path = written(mark.parent, json.loads(text) | {"code": ["evil.py"]})
    load(path)
    with pytest.raises(CodeError, match="is not allowed to run"):
        World.from_config(path)
    assert not mark.exists()
    World.from_config(path, trust=True, record=False).run(1)
    assert mark.exists()


@pytest.mark.parametrize("pattern", [p for p in KEYS if p != "systems.*"])
def test_an_intervention_from_outside_names_no_code(pattern: str, mark: Path) -> None:
    value = KEYS[pattern]
    key = {"water.current_function": "water.current_function", "search.objective": "search.objective"}.get(
        pattern, pattern.replace("*", "snail", 1).removesuffix(".*")
    )
    world = World.from_config(
        written(mark.parent, world_of("systems.*", code=["evil.py"])), trust=True, record=False
    )
    mark.unlink(missing_ok=True)
    text = json.dumps(value).split('"evil:')[1].partition('"')[0]
    for name in (f"evil:{text}", "os:system", "pydoc:pipepager"):
        before = world.digest()
        with pytest.raises((ConfigError, ValueError)):
            world.intervene({"kind": "set", "set": {key: name}})
        assert world.digest() == before
    assert not mark.exists()


def test_an_operator_set_from_outside_is_refused_for_naming_code(mark: Path) -> None:
    path = written(mark.parent, world_of("species.*.genome.mutate.operator", code=["evil.py"]))
    world = World.from_config(path, trust=True, record=False)
    with pytest.raises(ConfigError, match="cannot name code"):
        world.intervene({"kind": "set", "set": {"species.snail.genome.mate": {"operator": "evil:mate"}}})
    world.intervene({"kind": "set", "set": {"species.snail.genome.mutate": {"operator": "mutInversion"}}})


def test_operators_of_deap_are_named_from_a_closed_list_and_checked_without_a_call(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from deap import tools

    def called(*_: Any, **__: Any) -> Any:
        raise AssertionError("an operator was called to check a world")

    for names in SAFE.values():
        for name in names:
            monkeypatch.setattr(tools, name, called)
    data = world_of("systems.*") | {"systems": []}
    load(data)
    for operator, word in (
        (("mutUniformInt", {"indpd": 0.1}), "indpb"),
        (("mutUniformInt", {"indpb": 0.1, "low": 3, "up": 1}), "above up"),
        (("tools", {}), "unknown"),
        (("mutInversion", {"cmd": "ls"}), "unexpected"),
    ):
        data["species"]["snail"]["genome"]["mutate"] = {"operator": operator[0], **operator[1]}
        with pytest.raises(ConfigError, match=word):
            load(data)


@pytest.mark.parametrize(
    "entry",
    ["pydoc", "os", "os.path", "subprocess", "../evil.py", "/evil.py", "sub/evil.py", "no.py", "no.such"],
)
def test_what_is_no_file_beside_the_world_nor_an_installed_module_of_ones_own_is_refused(
    entry: str, mark: Path
) -> None:
    with pytest.raises(ConfigError, match="code"):
        load(written(mark.parent, world_of("systems.*", code=[entry]) | {"systems": []}))


def test_packages_are_not_imported_to_find_a_module_in_them(mark: Path) -> None:
    package = mark.parent / "evilpackage"
    package.mkdir()
    for name in ("__init__.py", "ecology.py"):
        (package / name).write_text(PAYLOAD.format(mark=str(mark)), encoding="utf-8")
    data = world_of("systems.*", code=["evilpackage.ecology"]) | {"systems": ["evilpackage.ecology:Wait"]}
    load(data)
    assert not mark.exists()
    World.from_config(data, trust=True, record=False)
    assert mark.exists()


def test_a_file_is_run_as_it_was_read_and_no_compiled_copy_is_taken(mark: Path) -> None:
    import py_compile

    harmless = (
        "from ecs_eco import System\n"
        "class Wait(System):\n    phase = 'record'\n    def process(self, *_): pass\n"
    )
    cached = mark.parent / "__pycache__" / f"evil.{sys.implementation.cache_tag}.pyc"
    py_compile.compile(
        str(mark.parent / "evil.py"),
        str(cached),
        invalidation_mode=py_compile.PycInvalidationMode.UNCHECKED_HASH,
    )
    (mark.parent / "evil.py").write_text(harmless, encoding="utf-8")
    config = load(written(mark.parent, world_of("systems.*", code=["evil.py"])), trust=True)
    (mark.parent / "evil.py").write_text(PAYLOAD.format(mark=str(mark)), encoding="utf-8")
    World.from_config(config, record=False).run(1)
    assert not mark.exists()


@pytest.mark.parametrize("entry", ["evil.py", "evil"])
def test_a_changed_file_is_asked_for_again_in_the_process_that_allowed_it(entry: str, mark: Path) -> None:
    path = written(mark.parent, world_of("systems.*", code=[entry]))
    run_to_folder(path, ticks=2, out=mark.parent / "run", report=False, trust=True)
    changed = PAYLOAD.format(mark=f"{mark}-changed")
    (mark.parent / "evil.py").write_text(changed, encoding="utf-8")
    kept = mark.parent / "run" / "code" / "evil.py"
    if kept.exists():
        kept.write_text(changed, encoding="utf-8")
    for attempt in (
        lambda: World.from_config(path),
        lambda: resume(mark.parent / "run", 4),
        lambda: repeat(mark.parent / "run"),
        lambda: World.restore(sorted((mark.parent / "run" / "checkpoints").iterdir())[-1]),
    ):
        with pytest.raises(ValueError, match=r"is not allowed to run|has changed"):
            attempt()
    assert not Path(f"{mark}-changed").exists()


def test_an_installed_module_that_changed_before_it_is_imported_is_refused(mark: Path) -> None:
    config = load(written(mark.parent, world_of("systems.*", code=["evil"])))
    config._code.allow()
    (mark.parent / "evil.py").write_text(PAYLOAD.format(mark=f"{mark}-changed"), encoding="utf-8")
    with pytest.raises(CodeError, match="has changed since it was read"):
        World.from_config(config)
    assert not Path(f"{mark}-changed").exists()


def test_a_run_that_cannot_begin_leaves_no_code_behind(mark: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any) -> None:
        assert (mark.parent / "run" / "code" / "evil.py").exists()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("ecs_eco.runs.begin.keep_checkpoint", full)
    path = written(mark.parent, world_of("systems.*", code=["evil.py"]))
    with pytest.raises(OSError, match="No space left"):
        run_to_folder(path, ticks=2, out=mark.parent / "run", report=False, trust=True)
    assert not (mark.parent / "run").exists()


def test_what_a_file_only_imports_cannot_be_named(mark: Path) -> None:
    (mark.parent / "tools.py").write_text("from os import system\n", encoding="utf-8")
    data = world_of("species.*.happiness.function", code=["tools.py"])
    data["species"]["snail"]["happiness"]["function"] = "tools:system"
    with pytest.raises(ConfigError, match="only imports system"):
        load(written(mark.parent, data), trust=True)


def test_a_file_imports_those_listed_before_it_and_shadows_no_other_module(mark: Path) -> None:
    (mark.parent / "json.py").write_text("def dumps(x): return x * 0\n", encoding="utf-8")
    (mark.parent / "later.py").write_text(
        "def feel(x):\n    import json\n    return json.dumps(x)[:, 0]\n", encoding="utf-8"
    )
    data = world_of("species.*.happiness.function", code=["json.py", "later.py"])
    data["species"]["snail"]["happiness"]["function"] = "later:feel"
    World.from_config(written(mark.parent, data), trust=True, record=False).run(2)
    assert json.dumps([1]) == "[1]"


@pytest.mark.parametrize(
    ("name", "text", "word"),
    [
        ("evil:feel", "def feel(x, y): return x", "must accept 1 argument:"),
        ("evil:fel", "def feel(x): return x", 'did you mean "feel"'),
        ("evil:feel", "def feel(x) return", "cannot be imported: SyntaxError"),
        ("evil:feel", "feel = 3", "is not a function"),
    ],
)
def test_allowed_code_is_looked_at(name: str, text: str, word: str, mark: Path) -> None:
    (mark.parent / "evil.py").write_text(text, encoding="utf-8")
    data = world_of("species.*.happiness.function", code=["evil.py"])
    data["species"]["snail"]["happiness"]["function"] = name
    path = written(mark.parent, data)
    load(path)
    with pytest.raises(ConfigError, match=word):
        load(path, trust=True)


def test_shipped_code_needs_no_permission_and_is_a_closed_list(mark: Path) -> None:
    for name in SHIPPED:
        assert load("lamb").function(name).__name__ == name.partition(":")[2]
    with pytest.raises(ConfigError, match="does not list"):
        load(world_of("systems.*") | {"systems": ["ecs_eco.worlds.lamb.systems:np"]})
    assert load("lamb").resolved().get("code") is None
