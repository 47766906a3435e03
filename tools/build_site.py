"""Build the documentation site from docs/, docstrings and the shipped worlds' READMEs.

    python tools/build_site.py [--out DIR] [--no-notebooks]

All pages are staged in build/site-source (without notebooks, in a temporary folder), where files outside docs/
that pages link to become pages, and the generated pages (API, commands, components, shipped worlds) are added.
Warnings are errors. Without --out, the site is written to ecs_eco/_site, where the wheel includes it and
`ecs-eco docs` opens it. Notebook output is kept in build/notebooks until the notebooks change. The pictures on the
home page and in the gallery start recorded runs, which are saved as pages.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from site_pages import generated  # a file in this folder

ROOT = Path(__file__).parents[1]
DOCS, OUT = ROOT / "docs", ROOT / "ecs_eco" / "_site"
# including the link text if it is a page's name; the page's title then replaces it
LINK = re.compile(r"(?:(?<=\[)([\w/-]+\.md))?\]\(([^)#:\s]+)(#[^)\s]*)?(?=\))")
FENCE = re.compile(r"^(```|~~~|:::).*?^\1", re.MULTILINE | re.DOTALL)
BESIDE = {
    "CHANGELOG.md": "project/changelog.md",
    "CONTRIBUTING.md": "project/contributing.md",
    "benchmarks/NOTES.md": "project/benchmarks.md",
}
PLAIN = "---\norphan: true\nnosearch: true\nhtml_theme.sidebar_secondary.remove: true\n---\n\n"
LANGUAGE = {".py": "python", ".toml": "toml", ".js": "javascript", ".json": "json", ".md": "markdown"}
CELL = "```{code-cell} ipython3"
PICTURE = re.compile(r"!\[[^]]*\]\(img/(?:gallery/|page_)(\w+)\.\w+\)")  # of a world
FAULTS = (  # of the generators, which axe reports
    (re.compile('<summary>(?=<span class="toctree-toggle")'), '<summary aria-label="Pages of this section">'),
    (re.compile("<th((?: [^>]*)?)>(?:<p></p>)?</th>"), r"<td\1></td>"),
    (re.compile('<dd>(<em class="sig-param">.*</em>,)</dd>'), r"<span>\1</span>"),
    (re.compile(r"<dl>(\n(?:<span>.*</span>\n)+)</dl>"), r'<span class="sig-params">\1</span>'),
)
LONGEST = 400  # maximum number of lines shown from a file, enough for every Python file
SHIPPED_WORLDS = ROOT / "ecs_eco" / "worlds"


def shipped_worlds() -> dict[Path, str]:
    """Return the site page for each shipped world's README."""
    pages = sorted(SHIPPED_WORLDS.glob("*/README.md"))
    return {path: f"reference/shipped/{path.parent.name}.md" for path in pages}


class Stage:
    """The staged copy: `add` takes a page and turns its links to project files into links to pages."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.pages = {ROOT / name: page for name, page in BESIDE.items()} | shipped_worlds()
        self.sources: dict[Path, str] = {}  # files and folders that pages link to → their page

    def add(self, place: str, text: str, home: Path) -> None:
        """Write a page at a site path; its links are relative to the folder `home`."""
        kept: list[str] = []

        def keep(match: re.Match[str]) -> str:  # a fenced block contains no links
            kept.append(match[0])
            return f"\0{len(kept) - 1}\0"

        text = LINK.sub(lambda m: f"]({self._target(m[2], m[3] or '', place, home)}", FENCE.sub(keep, text))
        text = re.sub("\0(\\d+)\0", lambda m: kept[int(m[1])], text)
        self.write(place, text)

    def write(self, place: str, text: str) -> None:
        """Write a page unless it is unchanged, because Sphinx compares modification times."""
        path = self.folder / place
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")

    def _target(self, target: str, anchor: str, place: str, home: Path) -> str:
        path = Path(os.path.normpath(home / target))
        at = (self.folder / place).parent
        if path == ROOT / "README.md":
            return os.path.relpath(self.folder / "index.md", at)
        if path in self.pages:
            return os.path.relpath(self.folder / self.pages[path], at) + anchor
        if path.is_relative_to(DOCS):
            return os.path.relpath(self.folder / path.relative_to(DOCS), at) + anchor
        if not path.exists():
            return target + anchor
        if path.suffix not in LANGUAGE and path.is_file():  # pictures and similar files are copied
            return os.path.relpath(path, at)
        name = path.relative_to(ROOT).as_posix().replace("__init__", "init")
        self.sources[path] = f"source/{name}.md"
        return os.path.relpath(self.folder / self.sources[path], at)

    def show_sources(self) -> None:
        """Write a page for each linked file and folder."""
        for path, place in self.sources.items():
            self.write(place, _folder(path) if path.is_dir() else _file(path))


def _file(path: Path) -> str:
    name, lines = path.relative_to(ROOT), path.read_text(encoding="utf-8").rstrip().split("\n")
    shown, more = "\n".join(lines[:LONGEST]), len(lines) - LONGEST
    left = f"\nThe source file has {more:,} more lines.\n" if more > 0 else ""
    return f"{PLAIN}# {_escaped(name)}\n\n````{LANGUAGE[path.suffix]}\n{shown}\n````\n{left}"


def _folder(path: Path) -> str:
    there = (p for p in path.iterdir() if not p.name.startswith(("__pycache__", ".")))
    names = "\n".join(f"- `{name}`" for name in sorted(p.name + "/" * p.is_dir() for p in there))
    return f"{PLAIN}# {_escaped(path.relative_to(ROOT))}\n\n{names}\n"


def _escaped(name: Path) -> str:
    return name.as_posix().replace("_", "\\_")


def stage(folder: Path, notebooks: bool = True) -> Stage:
    """Fill the staged copy; without `notebooks`, notebook cells become plain snippets."""
    staged = Stage(folder)
    for path in sorted(DOCS.rglob("*")):
        place = path.relative_to(DOCS).as_posix()
        if path.suffix == ".md":
            text = path.read_text(encoding="utf-8")
            staged.add(place, text if notebooks else text.replace(CELL, "```python"), path.parent)
        elif path.is_file() and "__pycache__" not in path.parts:
            (folder / place).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, folder / place)
    for path, place in list(staged.pages.items()):
        staged.add(place, path.read_text(encoding="utf-8"), path.parent)
    for place, text in generated().items():
        staged.add(place, text, DOCS / Path(place).parent)
    staged.show_sources()
    return staged


def replays(folder: Path) -> None:
    """Save recorded runs of the shipped worlds as pages of the staged copy; their pictures become links to them."""
    from gallery import TICKS, save

    (there := folder / "_static" / "replays").mkdir(parents=True, exist_ok=True)
    for world in TICKS:
        save(world, there)
    for name in ("index.md", "gallery.md"):
        text = (folder / name).read_text(encoding="utf-8")
        (folder / name).write_text(PICTURE.sub(_living, text), encoding="utf-8")


def _living(picture: re.Match[str]) -> str:
    """Return a picture as a link to the recorded run, which _static/living.js starts in the picture's place."""
    return f'<a class="living" href="_static/replays/{picture[1]}.html">{picture[0]}</a>'


def accessible(html: str) -> str:
    """Return a page of the site whose buttons have names, and whose lists and tables have proper headings."""
    for fault, mended in FAULTS:
        html = fault.sub(mended, html)
    return html


def build(work: Path, notebooks: bool) -> int:
    """Run Sphinx on the copy staged in a working folder, for its subfolder `site`; return the exit status."""
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "--keep-going",
        "-q",
        "-b",
        "html",
        "-d",
        str(work / "site-trees"),
        "-D",
        f"nb_execution_mode={'cache' if notebooks else 'off'}",
        "-D",
        f"nb_execution_cache_path={ROOT / 'build' / 'notebooks'}",
        str(work / "site-source"),
        str(work / "site"),
    ]
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)
    return subprocess.run(command, env=os.environ | {"PYTHONPATH": paths}, check=False).returncode


def main() -> int:
    """Build the site that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument(
        "--no-notebooks",
        action="store_true",
        help="show the tutorials and the home page without running them",
    )
    asked = parser.parse_args()
    sys.path.insert(0, str(ROOT))
    if asked.no_notebooks:
        with tempfile.TemporaryDirectory(prefix="ecs-eco-site-") as work:  # several may run at the same time
            return make(Path(work), asked.out, notebooks=False)
    return make(ROOT / "build", asked.out, notebooks=True)


def make(work: Path, out: Path, notebooks: bool) -> int:
    """Stage and build the site in a working folder, and write it without files that it does not need."""
    source = work / "site-source"
    shutil.rmtree(source, ignore_errors=True)
    stage(source, notebooks)
    if notebooks:
        replays(source)
    if status := build(work, notebooks):  # notebooks leave a folder next to the output
        shutil.rmtree(work / "site", ignore_errors=True)
        return status
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(work / "site", out, ignore=shutil.ignore_patterns("*.map"))
    for name in ("_sources", ".buildinfo", "objects.inv"):
        path = out / name
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    for path in out.rglob("*.html"):
        path.write_text(accessible(path.read_text(encoding="utf-8")), encoding="utf-8")
    size = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    print(f"{out / 'index.html'}: {size / 1e6:.0f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
