"""Write the world-file reference (docs/reference/world) from its models; with --check, only compare.

Each section has a page with its keys (type, range, unit, default and meaning) and an example from
tools/world_examples. In the index, the handwritten text above the mark is kept.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from pydantic.fields import FieldInfo  # noqa: E402

from ecs_eco.config.formula import ALLOWED  # noqa: E402
from ecs_eco.config.models.world import WorldConfig  # noqa: E402
from ecs_eco.inputs.section import Section, Use  # noqa: E402
from ecs_eco.learning import PPO  # noqa: E402
from tools.key_types import default_of, models_in, range_of, type_of, written  # noqa: E402

PAGES = ROOT / "docs" / "reference" / "world"
EXAMPLES = ROOT / "tools" / "world_examples"
MARK = "<!-- below: written by tools/make_reference.py -->"
NOTE = "<!-- Written by tools/make_reference.py from the models of ecs_eco.config: change those, not this page. -->"
HEAD = "| key | type | range | unit | default | meaning |\n|---|---|---|---|---|---|\n"
TOP = "Top level"
TITLES = {"functions": "Custom functions"}  # pages with too many paths for a title
PARENTS = ("species", "objects")  # their sections have separate pages


@dataclasses.dataclass(frozen=True)
class Place:
    """A path in the file where a section may appear."""

    path: str  # dotted, with NAME for user-chosen names and [] for list entries; "" is the top level
    about: str  # meaning of the key that contains the section


@dataclasses.dataclass
class Part:
    """A section: its model and all paths where it may appear."""

    model: type[Section]
    places: list[Place]

    @property
    def page(self) -> str:
        """The name of the section's page."""
        return "functions" if self.model is Use else page_of(self.places[0].path)

    @property
    def title(self) -> str:
        """The section's paths, and its kind if there are several kinds."""
        kind = kind_of(self.model)
        return joined(self.places) + (f', `kind = "{kind}"`' if kind else "")


def page_of(path: str) -> str:
    """Return the page that documents a path, named after its first key or, inside a species or object, after
    the next key."""
    keys = path.replace("[]", "").split(".")
    return (keys[2] if keys[0] in PARENTS and len(keys) > 2 else keys[0]) or "file"


def joined(places: list[Place]) -> str:
    """Return paths as code, separated by commas."""
    return ", ".join(dict.fromkeys(f"`{p.path}`" if p.path else TOP for p in places))


def parts() -> list[Part]:
    """Return all sections in file order."""
    found: dict[type[Section], Part] = {}
    for model, place in _sections(WorldConfig, Place("", "")):
        found.setdefault(model, Part(model, [])).places.append(place)
    return list(found.values())


def _sections(model: type[Section], place: Place) -> Iterator[tuple[type[Section], Place]]:
    yield model, place
    for name, info in model.model_fields.items():
        for inner, around in models_in(info.annotation):
            path = f"{place.path}.{name}{around}".lstrip(".")
            yield from _sections(inner, Place(path, info.description or ""))


def kind_of(model: type[Section]) -> str:
    """Return the only value of the `kind` key; "" for a section with several kinds or none."""
    info = model.model_fields.get("kind")
    choices = getattr(info.annotation, "__args__", ()) if info else ()
    return choices[0] if len(choices) == 1 else ""


def pages() -> dict[str, str]:
    """Return the pages' text by file name."""
    of_page: dict[str, list[Part]] = {}
    for part in parts():
        of_page.setdefault(part.page, []).append(part)
    homes = {part.model: part for listed in of_page.values() for part in listed}
    texts = {f"{name}.md": _page(name, listed, homes) for name, listed in of_page.items()}
    texts["ppo.md"] = _ppo()
    texts["formulas.md"] = (
        "\n\n".join(
            [
                "# Formulas",
                NOTE,
                f"A formula is made of {ALLOWED}. A true comparison is 1.",
                _example("formulas"),
            ]
        )
        + "\n"
    )
    above = (PAGES / "index.md").read_text(encoding="utf-8").partition(MARK)[0]
    texts["index.md"] = above + _index(of_page)
    return texts


def _page(name: str, listed: list[Part], homes: dict[type[Section], Part]) -> str:
    """Return a page: the sections of one key, outermost first."""
    shallowest = min(_depth(part) for part in listed)
    outer = [part for part in listed if _depth(part) == shallowest]
    title = outer[0].title if len(outer) == 1 else joined([p for part in outer for p in part.places])
    opening = [f"# {TITLES.get(name, title)}", NOTE]
    if name in TITLES:
        opening.append(f"At {title}.")
    if len(outer) > 1:
        opening.append(sentence(outer[0].places[0].about.partition("; absent")[0]))
    if len(outer) == 1:
        opening.append(_text(outer[0].model))
    headless = outer[0] if len(outer) == 1 else None
    body = [("" if part is headless else _head(part)) + _table(part, homes) for part in listed]
    return "\n\n".join([*opening, _example(name), *body]) + "\n"


def _example(name: str) -> str:
    texts = [path.read_text(encoding="utf-8").strip() for path in examples_of(name)]
    return "\n\n".join(f"```toml\n{text}\n```" for text in texts)


def examples_of(page: str) -> list[Path]:
    """Return a page's examples: PAGE.toml, then PAGE.WORD.toml."""
    return [EXAMPLES / f"{page}.toml", *sorted(EXAMPLES.glob(f"{page}.*.toml"))]


def _depth(part: Part) -> int:
    return min(place.path.count(".") for place in part.places)


def _head(part: Part) -> str:
    return f"## {part.title}\n\n{_text(part.model)}\n\n"


def _text(model: type[Section]) -> str:
    return " ".join((model.__doc__ or "").split())


def sentence(text: str) -> str:
    """Return a description as a sentence."""
    return f"{text[:1].upper()}{text[1:]}".rstrip(".") + "."


def _table(part: Part, homes: dict[type[Section], Part]) -> str:
    kind = kind_of(part.model)
    fields = part.model.model_fields.items()
    return HEAD + "\n".join(_row(n, f, part, homes) for n, f in fields if n != "kind" or not kind)


def _row(name: str, info: FieldInfo, part: Part, homes: dict[type[Section], Part]) -> str:
    extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
    unit = str(extra.get("unit", ""))
    text = (info.description or "").removesuffix(f" [{unit}]")
    inner = {model: homes[model] for model, _ in models_in(info.annotation)}
    links = {model: _link(home, part) for model, home in inner.items()}
    metadata = tuple(info.metadata)
    cells = (
        f"`{name}`",
        type_of(info.annotation, metadata, links),
        range_of(info.annotation, metadata),
        "" if unit == "1" else unit,
        default_of(info),
        text if name != "ppo" else f"{text}; see [ppo](ppo.md)",
    )
    row = "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
    return row.replace("|  |", "| |").replace("|  |", "| |")


def _link(home: Part, part: Part) -> str:
    """Return a link to a section's page, or to its heading if it is on this page."""
    if home.page != part.page:
        return f"[section]({home.page}.md)"
    slug = "".join(c for c in home.title.lower() if c.isalnum() or c in " _-").replace(" ", "-")
    return f"[section](#{slug})"


def _index(of_page: dict[str, list[Part]]) -> str:
    """Return the tree of all keys that contain sections, and the pages for Sphinx's menu."""
    lines = [f"- [{TOP}](file.md)"]
    seen: set[str] = {""}
    for model, place in _sections(WorldConfig, Place("", "")):
        page = "functions" if model is Use else page_of(place.path)
        if place.path not in seen:
            indent = "  " * (place.path.count(".") - place.path.count("NAME") + 1)
            about = place.about.partition("; absent")[0]
            lines.append(f"{indent}- [`{place.path}`]({page}.md): {about}")
            seen.add(place.path)
            if place.path == "species.NAME.policy":
                lines.append("    - [`species.NAME.ppo`](ppo.md): hyperparameters of PPO")
    lines.append("- [Formulas](formulas.md)")
    names = [*of_page, "ppo", "formulas"]
    tree = "```{toctree}\n:hidden:\n\n" + "\n".join(names) + "\n```\n"
    return f"{MARK}\n\n" + "\n".join(lines) + f"\n\n{tree}"


def _ppo() -> str:
    rows = [f"| `{f.name}` | `{written(f.default)}` | {f.metadata['doc']} |" for f in dataclasses.fields(PPO)]
    table = "| key | default | meaning |\n|---|---|---|\n" + "\n".join(rows)
    return (
        "\n\n".join(["# `species.NAME.ppo`", NOTE, "Hyperparameters of PPO.", _example("ppo"), table]) + "\n"
    )


def main() -> int:
    """Write the pages, or list outdated ones."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a page is out of date")
    check = parser.parse_args().check
    wanted = pages()
    old = {path.name: path.read_text(encoding="utf-8") for path in PAGES.glob("*.md")}
    stale = [name for name in wanted | old if wanted.get(name) != old.get(name)]
    if check:
        for name in stale:
            print(f"{name} is out of date: run python tools/make_reference.py", file=sys.stderr)
        return bool(stale)
    for name in stale:
        if name in wanted:
            (PAGES / name).write_text(wanted[name], encoding="utf-8")
        else:
            (PAGES / name).unlink()
    return 0


if __name__ == "__main__":
    sys.exit(main())
