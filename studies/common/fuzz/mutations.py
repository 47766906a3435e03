"""Mutations of world files, and of files that a run leaves; and a guard under which each is tried."""

from __future__ import annotations

import copy
import datetime
import importlib.util
import json
import math
import multiprocessing
import os
import random
import re
import signal
import tomllib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[3]
Path_ = tuple[str | int, ...]
FEW = 12  # organisms of a species

# --- a guard ------------------------------------------------------------------------------------------------


def guarded(judge: Callable[[Any], dict[str, Any]], items: Sequence[Any], seconds: float,
            memory: int = 4 << 30) -> Iterator[dict[str, Any]]:
    """What judge(item) says of each item, tried in a child process; "hang" after so many seconds,
    "crash" where the child died."""
    context, at = multiprocessing.get_context("fork"), 0
    while at < len(items):
        ours, theirs = context.Pipe(duplex=False)
        child = context.Process(target=_child, args=(judge, items[at:], theirs, memory), daemon=True)
        child.start()
        theirs.close()
        while at < len(items):
            try:
                outcome = ours.recv() if ours.poll(seconds) else {"kind": "hang"}
            except EOFError:
                outcome = {"kind": "crash"}
            at += 1
            yield outcome
            if outcome["kind"] in ("hang", "crash"):
                break
        child.kill()
        child.join()
        ours.close()


def _child(judge: Callable[[Any], dict[str, Any]], items: Sequence[Any], pipe: Any, memory: int) -> None:
    import resource
    import warnings

    with open("/proc/self/statm", encoding="ascii") as file:
        have = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (have + memory, have + memory))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.simplefilter("error")
    for item in items:
        pipe.send(judge(item))


# --- worlds to start from -----------------------------------------------------------------------------------


def sources() -> dict[str, tuple[str, Path | None]]:
    """The text of every shipped world, and of those that tests are made of,
    with the folder that files are named from."""
    from ecs_eco.config.shipped import shipped

    worlds: dict[str, tuple[str, Path | None]] = {name: (path.read_text(encoding="utf-8"), path.parent)
                                                  for name, path in shipped().items()}
    menagerie = _module("tests/conftest.py").MENAGERIE
    herd = copy.deepcopy(_module("tests/worlds/test_heredity.py").HERD)
    goat = herd["species"]["goat"]
    del goat["components"]  # of the test's own
    goat["genome"]["genes"] = [g for g in goat["genome"]["genes"] if g["name"] != "wool"]
    return worlds | {"menagerie": (toml(menagerie), None),
                     "herd": (toml(_without_none(herd) | {"interventions": DONE}), None)}


DONE = [  # to the herd
    {"kind": "cull", "at": 1, "species": "goat", "share": 0.2, "which": "oldest",
     "region": [15.0, 15.0, 8.0]},
    {"kind": "add", "at": 1, "every": 2, "until": 4, "species": "grass", "count": 3,
     "region": [2.0, 2.0, 9.0, 9.0]},
    {"kind": "fence", "at": 2, "line": [[5.0, 5.0], [5.0, 20.0]]},
    {"kind": "set", "at": 3, "set": {"species.goat.metabolism.basal": 0.005}},
    {"kind": "switch", "at": 3, "species": "goat", "learning": False},
]


def _module(path: str) -> Any:
    spec = importlib.util.spec_from_file_location(Path(path).stem + "_fuzzed", ROOT / path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _without_none(x: Any) -> Any:
    if isinstance(x, dict):
        return {k: _without_none(v) for k, v in x.items() if v is not None}
    return [_without_none(v) for v in x] if isinstance(x, list) else x


def toml(data: dict[str, Any]) -> str:
    """A dict as TOML: scalars first, then a section for each table,
    and one below it where a table holds tables alone."""
    lines = [f"{_key(k)} = {_value(v)}" for k, v in data.items() if not isinstance(v, dict)]
    for name, section in data.items():
        if not isinstance(section, dict):
            continue
        if section and all(isinstance(v, dict) for v in section.values()):
            for word, part in section.items():
                lines += ["", f"[{_key(name)}.{_key(word)}]",
                          *(f"{_key(k)} = {_value(v)}" for k, v in part.items())]
        else:
            lines += ["", f"[{_key(name)}]", *(f"{_key(k)} = {_value(v)}" for k, v in section.items())]
    return "\n".join(lines) + "\n"


def _key(key: Any) -> str:
    return (key if isinstance(key, str)
            and re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(str(key), ensure_ascii=False))


def _value(x: Any) -> str:
    if isinstance(x, bool):
        return "true" if x else "false"
    if isinstance(x, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in x.items()) + " }"
    if isinstance(x, list):
        return "[" + ", ".join(_value(v) for v in x) + "]"
    if isinstance(x, datetime.date):
        return x.isoformat()
    return json.dumps(x, ensure_ascii=False) if isinstance(x, str) else repr(x)


# --- mutations of text --------------------------------------------------------------------------------------


def mutate_text(text: str, chance: random.Random) -> bytes:
    """The text with one to three things done to its bytes or lines."""
    raw = text.encode()
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        raw = chance.choice((_flip, _flip, _digit, _byte, _cut, _cut, _double, _swap,
                             _truncate, _splice))(raw,
                                                  chance)
    return raw


def _flip(raw: bytes, chance: random.Random) -> bytes:
    out = bytearray(raw or b"\0")
    out[chance.randrange(len(out))] ^= 1 << chance.randrange(8)
    return bytes(out)


def _digit(raw: bytes, chance: random.Random) -> bytes:
    places = [i for i, byte in enumerate(raw) if 48 <= byte <= 57] or [0]
    at = chance.choice(places)
    return (raw[:at] + chance.choice((b"9", b"0", b"-1", b"1e9", b".", b"", b"00", b"9" * 5000))
            + raw[at + 1 :])


def _byte(raw: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(raw) + 1)
    return raw[:at] + chance.choice((b"\0", b"\xff", b"\"", b"'", b"[", b"]", b"{", b"}", b"=", b"#", b"\r",
                                     b"\n", b"\xc3\xa4", b".", b"[" * 300, b"{a=" * 300)) + raw[at:]


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
    0, 1, 2, -1, -7, 3, 10**6, 10**9, 2**31, 2**63 - 1, 2**63, 2**64, 10**40, 0.0, -0.0, 0.5, 1.0, -1.0,
    1e-30, 5e-324, 1e-9, 1e9, 1e30, 1.1e30, 1e39, 1.7e308, math.nan, math.inf, -math.inf, True, False, "",
    "x", "any", "wall", "none", "energy", "müde Rehe 🦌", "a b", "x" * 5000, "\0", "\n", "nosuch:thing",
    "a:b:c", "../../etc", [], {}, [[]], [{}], [0.5] * 3000, ["x"] * 500, [1, "x", {}], {"x": 1}, {"": 0},
    {"kind": "own"}, {"kind": "sexual"}, datetime.date(2020, 2, 29), "((((", "1/0", "energy**energy**energy",
    "not energy", "1 if energy else",
    10**12, "$\\foo$", "x" * 100_000, "\u202e", "CON", "../x", "/proc/self/mem", "/dev/zero", [4096] * 8,
    [[1.0]] * 5000, "(" * 900, "9**9**9**9", {f"k{i}": 1 for i in range(2000)},
]  # fmt: skip


def places(data: Any, at: Path_ = ()) -> list[Path_]:
    """The keys of all values in nested tables and lists."""
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
    """A copy with one to three values, keys or genes changed."""
    data = copy.deepcopy(data)
    ways = (_odd, _odd, _odd, _scaled, _scaled, _scaled, _scaled, _other_value, _other_value, _renamed,
            _removed, _doubled, _moved, _typo, _genes, _genes)
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
        _at(data, path[:-1])[path[-1]] = (int(x) if isinstance(_at(data, path), int)
                                          and math.isfinite(x) else x)


def _other_value(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    """A value from somewhere else in the file, of the same type where there is one."""
    path = chance.choice(paths)
    alike = [p for p in paths if type(_at(data, p)) is type(_at(data, path))]
    _at(data, path[:-1])[path[-1]] = copy.deepcopy(_at(data, chance.choice(alike)))


def _renamed(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    keys = [p for p in paths if isinstance(p[-1], str)]
    path, other = chance.choice(keys), chance.choice(keys)[-1]
    table = _at(data, path[:-1])
    table[chance.choice((other, f"{path[-1]}s", str(path[-1])[::-1], str(path[-1]).upper(),
                         "ü", "a.b", ""))] = table.pop(path[-1])


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
        _at(data, path[:-1])[path[-1]] = (text[:at] + chance.choice(("", "x", "é", "(", " + ", ".", " "))
                                          + text[at + 1 :])


TRAITS = (
    "body.radius", "body.mass", "locomotion.pace", "metabolism.growth", "defence.toughness", "defence.poison",
    "reproduction.spread", "policy.weights", "ppo.learning_rate", "ppo.discount", "ppo.entropy",
    "life.age_max", "reproduction.age_min", "reproduction.energy_min",
    "reproduction.energy_given", "reproduction.litter", "reproduction.choice", "happiness.energy",
    "body.count", None, None,
)  # fmt: skip
OPERATORS = ("cxOnePoint", "cxTwoPoint", "cxUniform", "cxOrdered", "cxBlend", "mutFlipBit", "mutUniformInt",
             "mutShuffleIndexes", "mutGaussian",
             "cxMessyOnePoint", "mut", "nosuch:operator", "math:floor")  # fmt: skip


def _genes(data: dict[str, Any], paths: list[Path_], chance: random.Random) -> None:
    """A genome with a layout of chance, or a change of one that is there."""
    species = ([v for v in data["species"].values() if isinstance(v, dict)]
               if isinstance(data.get("species"), dict) else [])
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
        chance.choice(genes) and genes[-1].update(chance.choice((
            {"at": chance.choice((0, 3, 10**6, 5 * 10**7))},
            {"letters": chance.choice((0, 1, 5, 30, 64, 65))},
            {"code": "additive", "codons": chance.choice((1, 4, 9999))}, {"scale": "log"}, {"whole": True},
            {"form": "direct"}, {"form": "cosine", "coefficients": chance.choice((1, 5, 10**7))},
            {"mutation": chance.random()}, {"values": [0.0] * chance.choice((0, 1, 4, 16, 1000))},
        )))  # fmt: skip
    elif way == 2:
        genome["alphabet"] = chance.choice(("01", "ACGT", "A", "", "AA", "äöü",
                                            "".join(map(chr, range(300, 556))), " \n"))
    elif way == 3:
        genome |= chance.choice(({"ploidy": 2}, {"ploidy": 2, "dominance": "mean"}, {"ploidy": 3},
                                 {"dominance": "greater"}, {"founders": "own"},
                                 {"loci": chance.choice((1, 10, 5000, 10**7, 5 * 10**7))}))  # fmt: skip
    else:
        arguments = chance.choice(({}, {"indpb": chance.choice((0, 0.5, 1, 2, "x", -1))},
                                   {"low": 0, "up": 1, "indpb": 0.5}, {"alpha": 0.5},
                                   {"up": [1, 2], "indpb": 1.0}))
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


def parsed(text: str) -> dict[str, Any]:
    """A world's text as data, with few organisms in it."""
    return fewer(tomllib.loads(text))


def fewer(data: dict[str, Any]) -> dict[str, Any]:
    """The same with at most FEW organisms of a species and objects of a kind."""
    for group in ("species", "objects"):
        for kind in data.get(group, {}).values():
            if kind.get("count", 0) > FEW:
                kind["count"] = FEW
    return data
