"""Converts matplotlib's SVG to SVG that follows the theme of its page: CSS replaces colors on dark
backgrounds, text stays text, ids are short and unique to a figure, and thousands of dots become one path."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from html import escape
from zlib import crc32

from ecs_eco.analysis.palette import INK, ON_DARK

FONT = "system-ui, sans-serif"
DENSE = 400
"""Minimum number of identical marks to be drawn as one path of round dots."""
DIM = "over-ground"
"""The gid of figures with images behind curves; these images are darkened on dark pages."""
_LEFT_OUT = {"font-family", "font-style", "font-variant", "font-stretch", "image-rendering"}
_ILLEGAL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")
_NUMBER = re.compile(r"-?\d+\.\d+(?:e-?\d+)?")
_REFERENCE = re.compile(r"url\(#([^)]+)\)")


def themed(text: str, name: str, dark: Mapping[str, str] = ON_DARK) -> str:
    """Return matplotlib's SVG after conversion, with ids that depend on `name`, and `dark` colors by light ones."""
    root = ET.fromstring(legible(text))
    _plain_names(root)
    dim = any(part.get("id") == DIM for part in root.iter("g"))
    for part in [*root.findall("metadata"), *root.iter("defs")]:
        for style in part.findall("style"):
            part.remove(style)
    root[:] = [part for part in root if part.tag != "metadata"]
    for part in root.iter():
        _attributes(part)
    _rename(root, f"f{crc32(name.encode()):08x}")
    _dots(root)
    _hoist(root)
    wide, high = (float(x) for x in root.get("viewBox", "0 0 1 1").split()[2:])
    inside = "".join(ET.tostring(part, encoding="unicode") for part in root)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="plot{" dim" * dim}" width="{wide * 4 / 3:.0f}" '
        f'height="{high * 4 / 3:.0f}" viewBox="0 0 {wide:g} {high:g}" font-family="{FONT}" '
        f'fill="{INK}" stroke-linejoin="round"><style>{_rules(inside, dark)}</style>'
        f'<rect class="under" width="100%" height="100%" fill="#ffffff"/>{inside}</svg>\n'
    )


def legible(text: str) -> str:
    r"""Escape characters that XML and HTML cannot contain, for example as \u0001."""
    return _ILLEGAL.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def embedded(text: str, caption: str) -> str:
    """Return a converted SVG for embedding, with the page's background and a caption for screen readers."""
    wide = float(re.search(r'viewBox="0 0 ([\d.]+)', text)[1])  # type: ignore[index]
    alt = escape(caption, quote=True)
    text = text.strip().replace(' xmlns="http://www.w3.org/2000/svg"', "", 1)
    text = re.sub(r'<rect class="under"[^>]*/>', "", text, count=1)
    # text of 10 units stays 9 pixels high on a phone, where wide figures scroll
    style = f"min-width:{min(0.9 * wide, 900):.0f}px"
    return text.replace("<svg ", f'<svg role="img" aria-label="{alt}" style="{style}" ', 1)


def _rules(inside: str, dark: Mapping[str, str]) -> str:
    """Return the dark-background CSS rules for the colors in use."""
    used = {*re.findall(r' (fill|stroke)="(#[0-9a-f]{6})"', inside), ("fill", "#ffffff")}
    known = [(what, hue) for what, hue in sorted(used) if hue in dark]
    rules = "".join(f'.plot [{what}="{hue}"]{{{what}:{dark[hue]}}}' for what, hue in known)
    rules = f".plot{{fill:{dark[INK]}}}{rules}.plot.dim image{{filter:brightness(.28)}}"
    return f"@media (prefers-color-scheme:dark){{{rules}}}"


def _plain_names(root: ET.Element) -> None:
    """Remove the namespaces."""
    for part in root.iter():
        part.tag = part.tag.rpartition("}")[2]
        for key in [key for key in part.attrib if "}" in key]:
            part.set(key.rpartition("}")[2], part.attrib.pop(key))
        if part.tag != "text" and part.tag != "tspan":
            part.text = None
        part.tail = None


def _attributes(part: ET.Element) -> None:
    """Convert styles to attributes, and shorten numbers."""
    for pair in part.attrib.pop("style", "").split(";"):
        key, _, value = pair.partition(":")
        key, value = key.strip(), value.strip()
        if key and key not in _LEFT_OUT:
            part.set(key, value.removesuffix("px") if key == "font-size" else value)
    path = part.get("d")
    if path is not None:
        part.set("d", _short(path))
    if part.tag in ("use", "text"):
        for key in {"x", "y"} & part.attrib.keys():
            part.set(key, f"{float(part.attrib[key]):.1f}")
        if part.get("transform", "").startswith("rotate(-0 "):
            del part.attrib["transform"]
    if part.tag == "image":
        part.set("href", "".join(part.get("href", "").split()))


def _short(path: str) -> str:
    """Round a path's numbers to two decimals; long paths of straight lines become relative, with one decimal."""
    words = path.split()
    if len(words) < 60 or not {word for word in words if word.isalpha()} <= {"M", "L", "z"}:
        return " ".join(_NUMBER.sub(lambda found: f"{float(found[0]):.2f}", " ".join(words)).split())
    out: list[str] = []
    at, begun = (0, 0), (0, 0)
    rest = iter(words)
    for word in rest:
        if word == "z":
            out.append("z")
            at = begun
            continue
        x, y = (round(10 * float(next(rest))) for _ in range(2))
        if (x, y) != at or word == "M":
            out.append(f"{word.lower()}{_tenth(x - at[0])} {_tenth(y - at[1])}".replace(" -", "-"))
        at = (x, y)
        begun = at if word == "M" else begun
    return re.sub(r"(?<=\d)l(?=-)", "", re.sub(r"(?<=\d)l(?=\d|\.)", " ", "".join(out)))


def _tenth(x: int) -> str:
    return f"{x / 10:g}".replace("0.", ".", 1) if abs(x) < 10 else f"{x / 10:.1f}".removesuffix(".0")


def _rename(root: ET.Element, prefix: str) -> None:
    """Keep only ids that are in use, with short names unique to this figure. Reused marks lose their colors,
    because the page's rules do not apply inside `use` elements."""
    values = [value for part in root.iter() for value in part.attrib.values()]
    marks = {part.get("href", "")[1:] for part in root.iter("use")}
    used: set[str] = marks | {found for value in values for found in _REFERENCE.findall(value)}
    new: dict[str, str] = {}
    for part in root.iter():
        old = part.attrib.pop("id", None)
        if old in used:
            part.set("id", new.setdefault(old, f"{prefix}-{len(new)}"))
        if part.tag == "path" and old in marks:
            part.attrib.pop("fill", None)
            part.attrib.pop("stroke", None)
    for part in root.iter():
        for key, value in part.attrib.items():
            if key == "href" and value.startswith("#"):
                part.set(key, "#" + new[value[1:]])
            elif "url(#" in value:
                part.set(key, _REFERENCE.sub(lambda found: f"url(#{new[found[1]]})", value))


def _dots(root: ET.Element) -> None:
    """Replace many identical marks, which may each have their own group, with one path of round dots."""
    paths = {part.get("id"): part.get("d", "") for part in root.iter("path")}
    for group in root.iter("g"):
        inner = [part[0] if part.tag == "g" and len(part) == 1 else part for part in group]
        marks = [part for part in inner if part.tag == "use"]
        kinds = {(mark.get("href"), mark.get("fill")) for mark in marks}
        if len(marks) < DENSE or len(kinds) != 1:
            continue
        href, fill = kinds.pop()
        at = sorted({tuple(round(float(mark.get(axis, 0)), 1) for axis in "yx") for mark in marks})
        clip = next((part.attrib for part in group if "clip-path" in part.attrib), {})
        group[:] = []
        look = {"d": "".join(_steps(at)), "fill": "none", "stroke": fill or INK, "stroke-linecap": "round"}
        reach = (abs(float(x)) for x in re.findall(r"-?[\d.]+", paths[(href or "")[1:]]))
        look["stroke-width"] = f"{20 * max(reach, default=1.0):.1f}"
        ET.SubElement(ET.SubElement(group, "g", clip), "path", look | {"transform": "scale(.1)"})


def _steps(at: list[tuple[float, ...]]) -> Iterator[str]:
    """Yield the steps of a path from dot to dot, in tenths of a unit."""
    x = y = 0
    for v, u in at:
        a, b = round(10 * u), round(10 * v)
        yield f"m{a - x}{'' if b < y else ' '}{b - y}h0"
        x, y = a, b


def _hoist(part: ET.Element) -> None:
    """Remove empty groups and dissolve groups without attributes."""
    for child in part:
        _hoist(child)
    kept: list[ET.Element] = []
    for child in part:
        if child.tag == "g" and not child.attrib:
            kept += list(child)
        elif child.tag not in ("g", "defs") or len(child):
            kept.append(child)
    part[:] = kept
