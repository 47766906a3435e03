"""The site's generated pages: the API from docstrings, components from their files, and commands from the
command line. Used by tools/build_site.py."""

import inspect
import re
import tomllib
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import api_pages  # a file in this folder
import typer

FIELD = re.compile(r"^    (\w+): ([^=#]+?)(?: = ([^#]+?))?(?:\s+# (.*))?$", re.MULTILINE)


def generated() -> dict[str, str]:
    """Return the generated pages' text by site path."""
    pages = {f"reference/api/{name}.md": text for name, text in api_pages.pages().items()}
    pages["reference/api/components.md"] = _components()
    pages["reference/api/index.md"] = api_pages.index()
    pages["reference/commands.md"] = _commands()
    pages["reference/shipped/index.md"] = _shipped()
    return pages


def _components() -> str:
    components = import_module("ecs_eco.components")
    parts = [
        "# Components\n\nThe data of organisms and objects: `table[Metabolism].energy` is a column; "
        "`world.get(uid, Metabolism).energy` is a single value. All are in `ecs_eco.components`."
    ]
    for name in components.__all__:
        kind = getattr(components, name)
        rows = [
            f"| `{field}` | `{of.strip()}` | `{default or ''}` | {_cell(unit or '')} |"
            for field, of, default, unit in FIELD.findall(inspect.getsource(kind))
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
    from ecs_eco.cli.app import COMMANDS, app, loaded

    parts = [
        "# Commands\n\nEvery command of `ecs-eco` with its arguments and options, as `ecs-eco COMMAND --help` "
        "prints them. [Running](../how-to/running.md) shows how they work together."
    ]
    for name in sorted(COMMANDS):
        parts += _command(f"ecs-eco {name}", loaded(name))
    rows = _options(typer.main.get_command(app))
    parts.append("## Options of all commands\n\nThey precede the command.\n\n" + "\n".join(rows))
    return "\n\n".join(parts) + "\n"


def _command(name: str, command: Any, level: int = 2) -> Iterator[str]:
    """Yield the parts of a command's page and of its subcommands' pages."""
    within = {sub: one for sub, one in getattr(command, "commands", {}).items() if not one.hidden}
    arguments = [p for p in command.params if p.param_type_name == "argument"]
    words = [name, *(_metavar(p) for p in arguments), "COMMAND" if within else "[OPTIONS]"]
    yield f"{'#' * level} {name.removeprefix('ecs-eco ')}"
    # no `bash` fence, because it is not a command to copy
    yield f"`{' '.join(words)}`\n\n{_cell(command.help or '')}"
    if rows := _options(command):
        yield "\n".join(rows)
    for sub in sorted(within):
        yield from _command(f"{name} {sub}", within[sub], level + 1)


def _options(command: Any) -> list[str]:
    """Return a command's table of arguments and options, or an empty string."""
    arguments = [p for p in command.params if p.param_type_name == "argument"]
    options = [p for p in command.params if p.param_type_name == "option" and not p.hidden]
    rows = [(_metavar(p), "", p.help) for p in arguments]
    rows += [(_option(p), _default(p), p.help) for p in options if p.name != "help"]
    table = [f"| `{_code(word)}` | {default} | {_cell(text or '')} |" for word, default, text in rows]
    return ["| | default | |", "|---|---|---|", *table] if table else []


def _metavar(parameter: Any) -> str:
    word = parameter.metavar or parameter.name.upper()
    return word if parameter.required else f"[{word}]"


def _option(parameter: Any) -> str:
    names = ", ".join(parameter.opts) + "".join(f" / {n}" for n in parameter.secondary_opts)
    return names if parameter.is_flag else f"{names} {parameter.metavar or parameter.name.upper()}"


def _default(parameter: Any) -> str:
    default = parameter.default
    absent = default in (None, False, ()) or callable(default) or "UNSET" in repr(default)
    return "" if absent else f"`{_code(str(getattr(default, 'value', default)))}`"


def _code(text: str) -> str:
    return text.replace("|", "\\|")


def _cell(text: str) -> str:
    return _code(" ".join(text.split())).replace("<", "&lt;")
