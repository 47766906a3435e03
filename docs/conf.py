"""Sphinx settings for the site, which `python tools/build_site.py` builds from a staged copy of this folder."""

import re
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

from tools.api_pages import entries, is_public, thing_of

project, author = "ecs-eco", "the ecs-eco authors"
version = release = version_of("ecs-eco")
project_copyright = "the ecs-eco authors, MIT license"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_design", "sphinx_copybutton"]
exclude_patterns = ["_static"]

myst_enable_extensions = ["colon_fence", "deflist", "attrs_inline"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # the changelog skips a heading level

nb_execution_timeout = 900  # [s] per cell; a busy machine can take ten times as long as an idle one
nb_execution_raise_on_error = True
nb_merge_streams = True

default_role = "code"
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_class_signature = "mixed"
python_maximum_signature_line_length = 90
autodoc_mock_imports = ["stable_baselines3"]
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

html_theme = "pydata_sphinx_theme"
html_title = "ecs-eco"
html_static_path = ["_static"]
html_css_files, html_js_files = ["site.css"], ["living.js"]
html_search_scorer = str(Path(__file__).parent / "_static" / "scorer.js")
html_favicon = "_static/logo.svg"
html_copy_source = html_show_sourcelink = False
html_show_sphinx = False
html_theme_options: dict[str, Any] = {
    "logo": {"image_light": "_static/logo.svg", "image_dark": "_static/logo.svg", "text": "ecs-eco"},
    "header_links_before_dropdown": 7,
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "navbar_persistent": ["search-button-field"],
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_sidebars = {"index": [], "gallery": [], "results": [], "benchmarks": [], "glossary": [], "releases": []}
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True

SPAN = re.compile(r"(`[^`\n]+`)")
# show the type of a parameter as code; otherwise Sphinx tries to link each of its words
TYPE = re.compile(r"^( *[\w*]+(?:, [\w*]+)*) : (.+)$", re.MULTILINE)
EXAMPLE = re.compile(r"(^ *>>> .*?(?:\n *\n|\Z))", re.MULTILINE | re.DOTALL)


def as_rst(_app: Any, _what: str, _name: str, _thing: Any, _options: Any, lines: list[str]) -> None:
    """Convert a docstring to reStructuredText; its only markup is `code` spans and examples."""
    parts = EXAMPLE.split("\n".join(lines))
    parts[::2] = [_escaped(TYPE.sub(r"\1 : `\2`", part)) for part in parts[::2]]
    lines[:] = "".join(parts).split("\n")


def _escaped(text: str) -> str:
    parts = SPAN.split(text)
    for i, part in enumerate(parts):
        parts[i] = part if i % 2 else re.sub(r"([*|])|(?<=\w)(_)(?!\w)", r"\\\1\2", part)
    return "".join(parts)


def skip_internal(_app: Any, what: str, _name: str, thing: Any, _skip: bool, _options: Any) -> bool | None:
    """Skip methods that are internal to the package."""
    method = callable(thing) or isinstance(thing, classmethod | staticmethod)
    return True if what == "class" and method and not is_public(thing) else None


def setup(app: Any) -> None:
    """Connect the functions that convert docstrings and skip internal methods."""
    for _, module, name in entries():
        thing_of(module, name)  # before autodoc imports it with TYPE_CHECKING set, which pydantic rejects
    app.connect("autodoc-process-docstring", as_rst, priority=400)  # before napoleon
    app.connect("autodoc-skip-member", skip_internal)
