"""Mutations of world files and of files written by a run."""

from __future__ import annotations

import copy
import datetime
import math
import random
from typing import Any

Path_ = tuple[str | int, ...]


# --- mutations of text --------------------------------------------------------------------------------------


def mutate_text(text: str, chance: random.Random) -> bytes:
    """Return the text with one to three bytes or lines changed."""
    raw = text.encode()
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        raw = chance.choice((_flip, _flip, _digit, _byte, _cut, _cut, _double, _swap, _truncate, _splice))(
            raw, chance
        )
    return raw


def _flip(raw: bytes, chance: random.Random) -> bytes:
    out = bytearray(raw or b"\0")
    out[chance.randrange(len(out))] ^= 1 << chance.randrange(8)
    return bytes(out)


def _digit(raw: bytes, chance: random.Random) -> bytes:
    places = [i for i, byte in enumerate(raw) if 48 <= byte <= 57] or [0]
    at = chance.choice(places)
    return (
        raw[:at] + chance.choice((b"9", b"0", b"-1", b"1e9", b".", b"", b"00", b"9" * 5000)) + raw[at + 1 :]
    )


def _byte(raw: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(raw) + 1)
    return (
        raw[:at]
        + chance.choice(
            (
                b"\0",
                b"\xff",
                b'"',
                b"'",
                b"[",
                b"]",
                b"{",
                b"}",
                b"=",
                b"#",
                b"\r",
                b"\n",
                b"\xc3\xa4",
                b".",
                b"[" * 300,
                b"{a=" * 300,
            )
        )
        + raw[at:]
    )


def _lines(raw: bytes, chance: random.Random) -> tuple[list[bytes], int]:
    lines = raw.split(b"\n")
    return lines, chance.randrange(len(lines))


def _cut(raw: bytes, chance: random.Random) -> bytes:
    lines, at = _lines(raw, chance)
    del lines[at : at + chance.choice((1, 1, 1, 2, 5))]
    return b"\n".join(lines)


def _double(raw: bytes, chance: random.Random) -> bytes:
    lines, at = _lines(raw, chance)
    lines.insert(chance.randrange(len(lines) + 1), lines[at])
    return b"\n".join(lines)


def _swap(raw: bytes, chance: random.Random) -> bytes:
    lines, at = _lines(raw, chance)
    other = chance.randrange(len(lines))
    lines[at], lines[other] = lines[other], lines[at]
    return b"\n".join(lines)


def _truncate(raw: bytes, chance: random.Random) -> bytes:
    return raw[: chance.randrange(len(raw) + 1)]


def _splice(raw: bytes, chance: random.Random) -> bytes:
    at, to, n = chance.randrange(len(raw) + 1), chance.randrange(len(raw) + 1), chance.randrange(1, 40)
    return raw[:to] + raw[at : at + n] + raw[to:]


# --- mutations of values ------------------------------------------------------------------------------------
ODD: list[Any] = [
    0,
    1,
    2,
    -1,
    -7,
    3,
    10**6,
    10**9,
    2**31,
    2**63 - 1,
    2**63,
    2**64,
    10**40,
    0.0,
    -0.0,
    0.5,
    1.0,
    -1.0,
    1e-30,
    5e-324,
    1e-9,
    1e9,
    1e30,
    1.1e30,
    1e39,
    1.7e308,
    math.nan,
    math.inf,
    -math.inf,
    True,
    False,
    "",
    "x",
    "any",
    "wall",
    "none",
    "energy",
    "müde Rehe 🦌",
    "a b",
    "x" * 5000,
    "\0",
    "\n",
    "nosuch:thing",
    "a:b:c",
    "../../etc",
    [],
    {},
    [[]],
    [{}],
    [0.5] * 3000,
    ["x"] * 500,
    [1, "x", {}],
    {"x": 1},
    {"": 0},
    {"kind": "own"},
    {"kind": "sexual"},
    datetime.date(2020, 2, 29),
    "((((",
    "1/0",
    "energy**energy**energy",
    "not energy",
    "1 if energy else",
    10**12,
    "$\\foo$",
    "x" * 100_000,
    "\u202e",
    "CON",
    "../x",
    "/proc/self/mem",
    "/dev/zero",
    [4096] * 8,
    [[1.0]] * 5000,
    "(" * 900,
    "9**9**9**9",
    {f"k{i}": 1 for i in range(2000)},
]


def places(data: Any, at: Path_ = ()) -> list[Path_]:
    """Return the paths of all values in nested tables and lists."""
    keys: list[Path_] = []
    pairs: Any = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in pairs:
        keys += [(*at, key), *places(value, (*at, key))]
    return keys


def _at(data: Any, path: Path_) -> Any:
    for part in path:
        data = data[part]
    return data


def mutate_values(data: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    """Return a copy with one to three values, keys or genes changed."""
    data = copy.deepcopy(data)
    ways = (
        _odd,
        _odd,
        _odd,
        _scaled,
        _scaled,
        _scaled,
        _scaled,
        _other_value,
        _other_value,
        _renamed,
        _removed,
        _doubled,
        _moved,
        _typo,
        _genes,
        _genes,
    )
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        paths = places(data)
        if not paths:
            break
        chance.choice(ways)(data, paths, chance)
    return data


def _odd(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    path = chance.choice(paths)
    _at(data, path[:-1])[path[-1]] = copy.deepcopy(chance.choice(ODD))


def _scaled(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    numbers = [p for p in paths if isinstance(v := _at(data, p), int | float) and not isinstance(v, bool)]
    if numbers:
        path = chance.choice(numbers)
        x = _at(data, path) * chance.choice((0.1, 0.5, 2, 3, 10, 100, -1, 1e6, 1e-6))
        _at(data, path[:-1])[path[-1]] = (
            int(x) if isinstance(_at(data, path), int) and math.isfinite(x) else x
        )


def _other_value(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    """Return a value from elsewhere in the file, of the same type if possible."""
    path = chance.choice(paths)
    alike = [p for p in paths if type(_at(data, p)) is type(_at(data, path))]
    _at(data, path[:-1])[path[-1]] = copy.deepcopy(_at(data, chance.choice(alike)))


def _renamed(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    keys = [p for p in paths if isinstance(p[-1], str)]
    path, other = chance.choice(keys), chance.choice(keys)[-1]
    table = _at(data, path[:-1])
    table[
        chance.choice((other, f"{path[-1]}s", str(path[-1])[::-1], str(path[-1]).upper(), "ü", "a.b", ""))
    ] = table.pop(path[-1])


def _removed(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    path = chance.choice(paths)
    del _at(data, path[:-1])[path[-1]]


def _doubled(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    path = chance.choice(paths)
    holder, value = _at(data, path[:-1]), copy.deepcopy(_at(data, path))
    if isinstance(holder, list):
        holder.insert(int(path[-1]), value)
    else:
        holder[f"{path[-1]}2"] = value


def _moved(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    path = chance.choice(paths)
    value = _at(data, path[:-1]).pop(path[-1])
    tables = [p for p in places(data) if isinstance(_at(data, p), dict)]
    if tables:
        _at(data, chance.choice(tables))[str(path[-1])] = value


def _typo(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    texts = [p for p in paths if isinstance(_at(data, p), str)]
    if texts:
        path = chance.choice(texts)
        text, at = _at(data, path), chance.randrange(len(_at(data, path)) + 1)
        _at(data, path[:-1])[path[-1]] = (
            text[:at] + chance.choice(("", "x", "é", "(", " + ", ".", " ")) + text[at + 1 :]
        )


TRAITS = (
    "body.radius",
    "body.mass",
    "locomotion.pace",
    "metabolism.photosynthesis",
    "defence.toughness",
    "defence.poison",
    "reproduction.spread",
    "policy.weights",
    "ppo.learning_rate",
    "ppo.discount",
    "ppo.entropy_coef",
    "life.age_max",
    "reproduction.age_min",
    "reproduction.energy_min",
    "reproduction.energy_given",
    "reproduction.litter",
    "reproduction.choice",
    "happiness.energy",
    "body.count",
    None,
    None,
)
OPERATORS = (
    "cxOnePoint",
    "cxTwoPoint",
    "cxUniform",
    "cxOrdered",
    "cxBlend",
    "mutFlipBit",
    "mutUniformInt",
    "mutShuffleIndexes",
    "mutGaussian",
    "cxMessyOnePoint",
    "mut",
    "nosuch:operator",
    "math:floor",
)


def _genes(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    """Return a genome with a random layout, or a change to the existing genome."""
    species = (
        [v for v in data["species"].values() if isinstance(v, dict)]
        if isinstance(data.get("species"), dict)
        else []
    )
    if not species:
        return
    one = chance.choice(species)
    genome = one.get("genome")
    if not isinstance(genome, dict) or chance.random() < 0.3:
        one["genome"] = genome = {"genes": [_gene(chance, i) for i in range(chance.randrange(5))]}
    genes = genome.get("genes")
    way = chance.randrange(6)
    if way == 0 and isinstance(genes, list):
        genes.append(_gene(chance, chance.randrange(100)))
    elif way == 1 and isinstance(genes, list) and genes and isinstance(genes[-1], dict):
        chance.choice(genes) and genes[-1].update(
            chance.choice(
                (
                    {"at": chance.choice((0, 3, 10**6, 5 * 10**7))},
                    {"letters": chance.choice((0, 1, 5, 30, 64, 65))},
                    {"code": "additive", "codons": chance.choice((1, 4, 9999))},
                    {"scale": "log"},
                    {"whole": True},
                    {"form": "direct"},
                    {"form": "cosine", "coefficients": chance.choice((1, 5, 10**7))},
                    {"mutation": chance.random()},
                    {"values": [0.0] * chance.choice((0, 1, 4, 16, 1000))},
                )
            )
        )
    elif way == 2:
        genome["alphabet"] = chance.choice(
            ("01", "ACGT", "A", "", "AA", "äöü", "".join(map(chr, range(300, 556))), " \n")
        )
    elif way == 3:
        genome |= chance.choice(
            (
                {"ploidy": 2},
                {"ploidy": 2, "expression": "mean"},
                {"ploidy": 3},
                {"expression": "greater"},
                {"founders": "own"},
                {"loci": chance.choice((1, 10, 5000, 10**7, 5 * 10**7))},
            )
        )
    else:
        arguments = chance.choice(
            (
                {},
                {"indpb": chance.choice((0, 0.5, 1, 2, "x", -1))},
                {"low": 0, "up": 1, "indpb": 0.5},
                {"alpha": 0.5},
                {"up": [1, 2], "indpb": 1.0},
            )
        )
        genome[chance.choice(("mate", "mutate"))] = {"operator": chance.choice(OPERATORS), **arguments}


def _gene(chance: random.Random, i: int) -> dict[str, Any]:
    gene: dict[str, Any] = {"name": f"g{i}", "letters": chance.choice((1, 2, 3, 5))}
    if (trait := chance.choice(TRAITS)) is not None:
        gene["trait"] = trait
    if trait == "policy.weights":
        gene |= {"form": chance.choice(("direct", "cosine")), "low": -1.0, "high": 1.0, "coefficients": 4}
        if gene["form"] == "direct":
            del gene["coefficients"]
    elif chance.random() < 0.3:
        gene["values"] = [chance.choice((0.0, 0.1, 1.0, 2.0)) for _ in range(4 ** gene["letters"])]
    else:
        gene |= {"low": chance.choice((0.0, 0.1, 1.0, -1.0)), "high": chance.choice((0.5, 1.0, 2.0, 0.05))}
        gene |= chance.choice(({}, {"code": "gray"}, {"code": "additive", "codons": 3}, {"scale": "log"}))
    return gene
