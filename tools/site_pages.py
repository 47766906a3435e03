"""Pages of the site that are generated: the API from docstrings, components from their files, commands from
the command line itself. Used by tools/build_site.py.
"""

import inspect
import re
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any

MEMBERS = "   :members:\n   :show-inheritance:\n"
API: dict[str, tuple[str, str, tuple[str, ...]]] = {  # page: (title, opening, names as `module:name`)
    "world": (
        "World, tables and systems",
        "What `from ecs_eco import …` gives.",
        (
            "ecs_eco:World",
            "ecs_eco:Table",
            "ecs_eco:System",
            "ecs_eco:component",
            "ecs_eco:njit",
            "ecs_eco:draw",
            "ecs_eco.nervous.external:External",
            "ecs_eco.nervous.external:Sensed",
        ),
    ),
    "config": (
        "World files",
        "Loading and checking; every key is in [the world file](../world/index.md).",
        (
            "ecs_eco.config:load",
            "ecs_eco.config:for_training",
            "ecs_eco.config:WorldConfig",
            "ecs_eco.config:compile_formula",
            "ecs_eco.worlds.build:build",
            "ecs_eco.engine.errors:ConfigError",
        ),
    ),
    "runs": (
        "Runs and their records",
        "Run into a folder, go on, fork; what is kept in memory.",
        (
            "ecs_eco.runs.run:run_to_folder",
            "ecs_eco.runs.run:resume",
            "ecs_eco.runs.run:fork",
            "ecs_eco.record.recorder:Recorder",
            "ecs_eco.analysis.runs:load_series",
            "ecs_eco.analysis.runs:Series",
        ),
    ),
    "learning": (
        "Learning",
        "Brains and PPO, also for plain Gymnasium environments; see "
        "[learning](../../explanation/learning.md).",
        ("ecs_eco.learning:*",),
    ),
    "rl": (
        "Reinforcement learning from outside",
        "Species as environments of PettingZoo and Gymnasium: "
        '`pip install "ecs-eco[rl]"`; see [bring your own learner]'
        "(../../how-to/bring_your_own_learner.md).",
        ("ecs_eco.rl:parallel_env", "ecs_eco.rl:slots", "ecs_eco.rl:body"),
    ),
    "search": (
        "Searching and fitting",
        "Numbers with which a world lives, or is like measurements; see "
        "[searching](../../how-to/searching.md) and [measurements](../../how-to/measurements.md).",
        (
            "ecs_eco.lab:search",
            "ecs_eco.lab.searching.fit:Fit",
            "ecs_eco.lab.searching.sampler:Sampler",
            "ecs_eco.lab.searching.sampler:Population",
            "ecs_eco.lab.searching.sampler:weighted_quantiles",
        ),
    ),
    "genomes": (
        "Genomes",
        "Layouts, operators and statistics; see [genomes](../../explanation/genomes.md).",
        ("ecs_eco.genomes:*",),
    ),
    "space": ("Space", "Edges, neighbours, fields and ground.", ("ecs_eco.space:*",)),
    "systems": (
        "Systems",
        "What happens to everyone in a tick, in the order of "
        "[the schedule](../../explanation/design.md#the-tick).",
        ("ecs_eco.systems:*",),
    ),
    "testing": (
        "Tests of your own parts",
        "Checks for your own components, systems, genomes and worlds.",
        ("ecs_eco.testing:*",),
    ),
}
ANALYSIS = (
    "cycles",
    "extinction",
    "lineage",
    "pedigree",
    "survival",
    "spectrum",
    "rhythm",
    "depth",
    "carriers",
    "signature",
    "against",
    "compare",
    "seed_grid",
    "figures",
)
FIELD = re.compile(r"^    (\w+): ([^=#]+?)(?: = ([^#]+?))?(?:\s+# (.*))?$", re.MULTILINE)


def generated() -> dict[str, str]:
    """Return the text of each generated page by its place in the site."""
    pages = {f"reference/api/{name}.md": _api(*about) for name, about in API.items()}
    pages["reference/api/analysis.md"] = _analysis()
    pages["reference/api/components.md"] = _components()
    pages["reference/api/index.md"] = _index()
    pages["reference/commands.md"] = _commands()
    pages["reference/shipped/index.md"] = _shipped()
    return pages


def _api(title: str, opening: str, names: tuple[str, ...]) -> str:
    parts = [f"# {title}\n\n{opening}"]
    for name in names:
        module, _, what = name.partition(":")
        wanted = import_module(module).__all__ if what == "*" else (what,)
        parts += [_entry(module, one) for one in wanted]
    return "\n\n".join(parts) + "\n"


def _entry(module: str, name: str) -> str:
    try:
        thing = getattr(import_module(module), name)
    except ModuleNotFoundError as error:  # an extra that is not here: the page says which
        return f"`{module}.{name}`: {error}"
    if isinstance(thing, type) and issubclass(thing, Exception):
        return _directive("autoexception", f"{module}.{name}", "")
    if inspect.isclass(thing):
        inherited = "   :inherited-members: object\n" * (name == "World")
        return _directive("autoclass", f"{module}.{name}", MEMBERS + inherited)
    if callable(thing):
        return _directive("autofunction", f"{module}.{name}", "")
    return _directive("autodata", f"{module}.{name}", "   :no-value:\n")


def _directive(kind: str, name: str, options: str) -> str:
    return f"```{{eval-rst}}\n.. {kind}:: {name}\n{options}```"


def _analysis() -> str:
    parts = [
        "# Analysis\n\nStatistics and figures of recorded runs, one phenomenon a module; see "
        "[running](../../how-to/running.md#from-python)."
    ]
    for name in ANALYSIS:
        module = f"ecs_eco.analysis.{name}"
        head = (import_module(module).__doc__ or "").strip().partition("\n\n")[0].replace("\n", " ")
        parts += [f"## {name}\n\n{head}", *(_entry(module, one) for one in _own(module))]
    return "\n\n".join(parts) + "\n"


def _own(module: str) -> list[str]:
    """Public classes and functions that a module defines itself, in its order."""
    there = vars(import_module(module))
    return [
        name
        for name, thing in there.items()
        if not name.startswith("_")
        and (inspect.isclass(thing) or inspect.isfunction(thing))
        and thing.__module__ == module
    ]


def _components() -> str:
    components = import_module("ecs_eco.components")
    parts = [
        "# Components\n\nThe data of organisms and objects: `table[Metabolism].energy` is a column, "
        "`world.get(uid, Metabolism).energy` a value. All are in `ecs_eco.components`."
    ]
    for name in components.__all__:
        kind = getattr(components, name)
        source = inspect.getsource(import_module(kind.__module__))
        body = source[source.index(f"class {name}") :]
        rows = [
            f"| `{field}` | `{of.strip()}` | `{default or ''}` | {_cell(unit or '')} |"
            for field, of, default, unit in FIELD.findall(body)
        ]
        rows = [row.replace("| `` |", "| |") for row in rows]
        doc = inspect.cleandoc(kind.__doc__ or "").replace("<", "&lt;")
        table = "| field | type | default | unit, meaning |\n|---|---|---|---|\n" + "\n".join(rows)
        parts.append(f"## {name}\n\n{doc}" + (f"\n\n{table}" if rows else ""))
    return "\n\n".join(parts) + "\n"


def _index() -> str:
    names = ["world", "components", *(n for n in API if n != "world"), "analysis"]
    return (
        "# Python\n\nThe classes and functions that users import, from their docstrings.\n\n"
        "```{toctree}\n:maxdepth: 2\n\n" + "\n".join(names) + "\n```\n"
    )


def _shipped() -> str:
    worlds = import_module("ecs_eco.worlds")
    rows, names = [], []
    for name, title in _titles(Path(worlds.__file__ or "").parent):
        readme = name.replace("-", "_")
        page = (Path(worlds.__file__ or "").parent / readme / "README.md").is_file()
        names += [readme] * page
        rows.append(f"| {f'[{name}]({readme}.md)' if page else name} | {_cell(title)} |")
    head = "# Shipped worlds\n\n`ecs-eco run NAME`, or copy the file and change it.\n\n| name | |\n|---|---|"
    return "\n".join([head, *rows, "\n```{toctree}\n:hidden:\n", *names, "```\n"])


def _titles(folder: Path) -> list[tuple[str, str]]:
    files = sorted(folder.glob("*/*.toml"))
    read = [tomllib.loads(path.read_text(encoding="utf-8")) for path in files]
    return [(world["name"], world.get("title", "")) for world in read if "species" in world]


def _commands() -> str:
    from ecs_eco.cli.app import COMMANDS, loaded

    parts = [
        "# Commands\n\nWhat `ecs-eco COMMAND --help` says, of all commands. How they work together: "
        "[running](../how-to/running.md)."
    ]
    parts += [_command(name, loaded(name)) for name in sorted(COMMANDS)]
    return "\n\n".join(parts) + "\n"


def _command(name: str, command: Any) -> str:
    arguments = [p for p in command.params if p.param_type_name == "argument"]
    options = [p for p in command.params if p.param_type_name == "option" and not p.hidden]
    usage = " ".join(["ecs-eco", name, *(_metavar(p) for p in arguments), "[OPTIONS]"])
    rows = [f"| `{_metavar(p)}` | | {_cell(p.help or '')} |" for p in arguments]
    rows += [f"| `{_option(p)}` | {_default(p)} | {_cell(p.help or '')} |" for p in options]
    table = "| | default | |\n|---|---|---|\n" + "\n".join(rows)
    # no fence with `bash`: it is no command to copy
    return f"## {name}\n\n`{usage}`\n\n{_cell(command.help or '')}" + (f"\n\n{table}" if rows else "")


def _metavar(parameter: Any) -> str:
    word = parameter.metavar or parameter.name.upper()
    return word if parameter.required else f"[{word}]"


def _option(parameter: Any) -> str:
    names = ", ".join(parameter.opts) + "".join(f" / {n}" for n in parameter.secondary_opts)
    return names if parameter.is_flag else f"{names} {parameter.metavar or parameter.type.name.upper()}"


def _default(parameter: Any) -> str:
    default = parameter.default
    absent = default in (None, False, ()) or callable(default) or "UNSET" in repr(default)
    return "" if absent else f"`{default}`"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")
