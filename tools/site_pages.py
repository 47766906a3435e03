"""Pages of the site that are generated: the API from docstrings, components from their files, commands from
the command line itself. Used by tools/build_site.py.
"""

import inspect
import re
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any

import api_pages  # the file beside this one

FIELD = re.compile(r"^    (\w+): ([^=#]+?)(?: = ([^#]+?))?(?:\s+# (.*))?$", re.MULTILINE)


def generated() -> dict[str, str]:
    """Return the text of each generated page by its place in the site."""
    pages = {f"reference/api/{name}.md": text for name, text in api_pages.pages().items()}
    pages["reference/api/components.md"] = _components()
    pages["reference/api/index.md"] = api_pages.index()
    pages["reference/commands.md"] = _commands()
    pages["reference/shipped/index.md"] = _shipped()
    return pages


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
