"""Write docs/explanation/definitions.md: each clause of the paper's definitions and the tests that show it;
--check: only compare.

A test says which clauses it shows by `@pytest.mark.definition("1 temperature", …)`. A clause without a test
is listed as missing, and a mark that names no clause is an error.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "explanation" / "definitions.md"
HEAD = """# The paper's definitions, and the tests that show them

<!-- Written by tools/make_definitions.py from the marks of the tests: change those, not this page. -->

This page lists the tests that demonstrate each clause of Definitions 1 to 4 of *The Ecosystem Path to AGI*, and of
its text on decisions and learning, in our words. These tests are marked `@pytest.mark.definition("CLAUSE")`. The
last column lists what is not implemented yet.
"""
PARTS = {
    "1": "Properties of objects (Definition 1)",
    "2": "Inanimate objects (Definition 2)",
    "3": "Organisms (Definition 3)",
    "4": "Ecosystems (Definition 4)",
    "5": "Decisions and learning",
}
CLAUSES = {  # clause: (what it says, what of it is missing)
    "1 temperature": ("Every body may have a temperature [K]", ""),
    "1 mass": ("Every body has a mass [kg]", ""),
    "1 pressure": ("Every body may have a pressure [Pa]", ""),
    "1 current": ("Every body may carry an electric current [A]", ""),
    "1 luminosity": ("Every body may shine: luminous intensity [cd]", ""),
    "1 conformation": ("A body has a shape and a place in space", ""),
    "1 substances": ("A body holds chemical substances, each with its molarity", ""),
    "1 age": ("An organism has an age [s]", ""),
    "1 sex": ("An organism is female, male, or has no sex", ""),
    "1 fertility": ("An organism has a fertility between 0 and 1", ""),
    "2 type": ("An inanimate object has a type", ""),
    "2 moves": ("An inanimate object may move, be pushed, carried and built", ""),
    "2 properties": ("An inanimate object has physical and chemical properties", ""),
    "3 type": ("An organism is of a species", ""),
    "3 genome": ("An organism has a genome: a string over a finite alphabet, of any length", ""),
    "3 properties": ("An organism has physical, chemical and biological properties", ""),
    "3 sensor place": ("A sensor has a place on the body", ""),
    "3 sensor property": ("A sensor is sensitive to a property, of the own body or of any other", ""),
    "3 actions": ("An organism has a set of actions", ""),
    "3 reflex": ("A reflex network leads from the sensors to the actions", ""),
    "3 policy": ("A policy network leads from the sensors to the actions", ""),
    "3 happiness": ("A happiness network leads from the sensors to one number", ""),
    "3 hyperparameters": ("An organism has hyperparameters of its learning, reproduction and death", ""),
    "3 physical rules": ("Physical properties change by rules: place by moving, temperature by heat", ""),
    "3 chemical rules": (
        "Chemical properties change by rules: eating, breathing, moving and decay change substances",
        "",
    ),
    "3 reproduction": ("Reproduction is sexual or asexual, with crossover and mutation", ""),
    "3 biological rules": (
        "Biological properties change by rules: age by time, fertility by age and season, size by growing",
        "",
    ),
    "3 eggs": ("Newborn may begin as eggs, which lie until they hatch and can be eaten", ""),
    "3 parental care": ("Parents feed their young, who know their mother and follow her", ""),
    "3 staying alive": ("An organism dies outside the interval of a property, or when too old", ""),
    "3 remains": ("What dies becomes an inanimate object", ""),
    "3 genome encodes": (
        "The genome encodes body, nervous system and hyperparameters",
        "the proportions of a shape; the incubation of eggs",
    ),
    "3 genome inherited": ("One or two genomes give rise to a new one", ""),
    "3 reflex agents": (
        "An organism may have an empty policy network, or an empty reflex network, or both networks",
        "",
    ),
    "3 no nerves": ("An organism may have no nervous system, as plants and bacteria", ""),
    "3 hand-coded": ("Reflex and happiness may be functions, and become networks by supervised learning", ""),
    "4 space": ("An ecosystem has a space", ""),
    "4 objects": ("An ecosystem has inanimate objects", ""),
    "4 organisms": ("An ecosystem has organisms", ""),
    "5 sense": ("In each tick every sensor is read: x", ""),
    "5 reflex": ("The reflex network blocks (−1), leaves (0) or forces (1) each action: y", ""),
    "5 choice": ("The policy picks actions: z", ""),
    "5 decision": ("The decision is H(y + z): none, one or several actions", ""),
    "5 reward": ("The reward is the change of happiness", ""),
    "5 learning": ("The policy learns by PPO with the animal's own hyperparameters", ""),
    "5 evolution alone": ("Reflex and happiness do not change in life", ""),
}


def marks(path: Path) -> Iterator[tuple[str, str]]:
    """Yield (clause, name of the test) of each mark in a file; raises ValueError for an unknown clause."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        for call in node.decorator_list if isinstance(node, ast.FunctionDef) else ():
            if not (isinstance(call, ast.Call) and ast.unparse(call.func) == "pytest.mark.definition"):
                continue
            for argument in call.args:
                clause = ast.literal_eval(argument)
                if clause not in CLAUSES:
                    near = get_close_matches(clause, CLAUSES, 1)
                    hint = f"; did you mean {near[0]!r}?" if near else f"; expected: {', '.join(CLAUSES)}"
                    raise ValueError(f"{path}, line {call.lineno}: no clause {clause!r}{hint}")
                yield clause, node.name


def page(tests: Path) -> str:
    """Return the page that the marks in a folder of tests make."""
    shown: dict[str, list[str]] = {clause: [] for clause in CLAUSES}
    for path in sorted(tests.rglob("test_*.py")):
        for clause, name in marks(path):
            where = path.relative_to(tests.parent).as_posix()
            shown[clause].append(f"[{name.removeprefix('test_').replace('_', ' ')}](../../{where})")
    sections = []
    for part, title in PARTS.items():
        rows = [
            f"| {what} | {'<br>'.join(shown[clause]) or '**no test**'} | {missing} |"
            for clause, (what, missing) in CLAUSES.items()
            if clause.split()[0] == part
        ]
        sections.append(f"## {title}\n\n| clause | shown by | missing |\n|---|---|---|\n" + "\n".join(rows))
    return HEAD + "\n" + "\n\n".join(sections) + "\n"


def main() -> int:
    """Write the page, or with --check return 1 where it is not what the marks say."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--check", action="store_true")
    wanted = page(ROOT / "tests")
    if parser.parse_args().check:
        if not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != wanted:
            print(f"{PAGE} is not what the tests' marks say: run python tools/make_definitions.py")
            return 1
        return 0
    PAGE.write_text(wanted, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
