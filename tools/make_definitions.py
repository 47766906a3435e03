"""Write docs/explanation/definitions.md, which lists each clause in the paper's definitions and the tests
that demonstrate it.

Tests are marked with the clauses that they demonstrate: `@pytest.mark.definition("1 temperature", …)`. A
clause without tests is listed as such; a mark with an unknown clause is an error. --check only compares.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections import Counter
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "explanation" / "definitions.md"
HEAD = """# The paper's definitions and their tests

<!-- Written by tools/make_definitions.py from marks in the tests: change those, not this page. -->

After reading this page, you know which clauses of the paper *The Ecosystem Path to AGI* are implemented and where
they are tested: Definitions 1 to 4, and its text on decisions and learning, in our words. The tests are marked
`@pytest.mark.definition("CLAUSE")`; the table links to their files and gives the number of tests. The last column
lists what is not implemented yet.
"""
PARTS = {
    "1": "Properties of objects (Definition 1)",
    "2": "Inanimate objects (Definition 2)",
    "3": "Organisms (Definition 3)",
    "4": "Ecosystems (Definition 4)",
    "5": "Decisions and learning",
}
CLAUSES = {  # clause: (its content, the missing part)
    "1 temperature": ("A body may have a temperature [K]", ""),
    "1 mass": ("A body has a mass [kg]", ""),
    "1 pressure": ("A body may have a pressure [Pa]", ""),
    "1 current": ("A body may carry an electric current [A]", ""),
    "1 luminosity": ("A body may emit light: luminous intensity [cd]", ""),
    "1 conformation": ("A body has a shape and a position in space", ""),
    "1 substances": ("A body contains chemical substances, each with its molarity", ""),
    "1 age": ("An organism has an age [s]", ""),
    "1 sex": ("An organism is female, male, or has no sex", ""),
    "1 fertility": ("An organism has a fertility between 0 and 1", ""),
    "2 type": ("An inanimate object has a type", ""),
    "2 moves": ("An inanimate object may move, be pushed, carried and built", ""),
    "2 properties": ("An inanimate object has physical and chemical properties", ""),
    "3 type": ("An organism belongs to a species", ""),
    "3 genome": ("An organism has a genome: a string over a finite alphabet, of any length", ""),
    "3 properties": ("An organism has physical, chemical and biological properties", ""),
    "3 sensor place": ("A sensor has a position on the body", ""),
    "3 sensor property": ("A sensor responds to a property of its body or of another body", ""),
    "3 actions": ("An organism has a set of actions", ""),
    "3 reflex": ("A reflex network maps the sensors to the actions", ""),
    "3 policy": ("A policy network maps the sensors to the actions", ""),
    "3 happiness": ("A happiness network maps the sensors to one number", ""),
    "3 hyperparameters": ("An organism has hyperparameters for learning, reproduction and death", ""),
    "3 physical rules": (
        "Physical properties follow rules: movement changes position, heat changes temperature",
        "",
    ),
    "3 chemical rules": (
        "Chemical properties follow rules: eating, breathing, moving and decay change substances",
        "",
    ),
    "3 reproduction": ("Reproduction is sexual or asexual, with crossover and mutation", ""),
    "3 biological rules": (
        "Biological properties follow rules: age depends on time, fertility on age and season, size on growth",
        "",
    ),
    "3 eggs": ("Newborns may start as eggs, which can be eaten until they hatch", ""),
    "3 parental care": ("Parents feed their young, which recognize and follow their mother", ""),
    "3 staying alive": ("An organism dies if a property leaves its interval, or at its maximum age", ""),
    "3 remains": ("A dead organism becomes an inanimate object", ""),
    "3 genome encodes": (
        "The genome encodes body, nervous system and hyperparameters",
        "the proportions of a shape; the incubation of eggs",
    ),
    "3 genome inherited": ("A new genome is derived from one or two genomes", ""),
    "3 reflex agents": (
        "An organism may have an empty policy network, or an empty reflex network, or both networks",
        "",
    ),
    "3 no nerves": ("An organism may have no nervous system, like plants and bacteria", ""),
    "3 hand-coded": ("Reflex and happiness may be functions, and become networks by supervised learning", ""),
    "4 space": ("An ecosystem has a space", ""),
    "4 objects": ("An ecosystem has inanimate objects", ""),
    "4 organisms": ("An ecosystem has organisms", ""),
    "5 sense": ("Every sensor is read in each tick: x", ""),
    "5 reflex": ("The reflex network blocks (−1), leaves (0) or forces (1) each action: y", ""),
    "5 choice": ("The policy chooses actions: z", ""),
    "5 decision": ("The decision is H(y + z): none, one or several actions", ""),
    "5 reward": ("The reward is the change in happiness", ""),
    "5 learning": ("The policy learns by PPO with the animal's hyperparameters", ""),
    "5 evolution alone": ("Reflex and happiness do not change during life", ""),
}


def marks(path: Path) -> Iterator[str]:
    """Yield the clauses marked in a file; raise a ValueError for an unknown clause."""
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
                yield clause


def page(tests: Path) -> str:
    """Return the page for the marks in a test folder."""
    shown: dict[str, list[str]] = {clause: [] for clause in CLAUSES}
    for path in sorted(tests.rglob("test_*.py")):
        where = path.relative_to(tests.parent).as_posix()
        for clause, n in Counter(marks(path)).items():
            shown[clause].append(f"[{where.removeprefix('tests/')}](../../{where}): {n}")
    sections = []
    for part, title in PARTS.items():
        rows = [
            f"| {what} | {'<br>'.join(shown[clause]) or '**no test**'} | {missing} |"
            for clause, (what, missing) in CLAUSES.items()
            if clause.split()[0] == part
        ]
        sections.append(f"## {title}\n\n| clause | tests | missing |\n|---|---|---|\n" + "\n".join(rows))
    return HEAD + "\n" + "\n\n".join(sections) + "\n"


def main() -> int:
    """Write the page; with --check, return 1 if it is out of date."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--check", action="store_true")
    wanted = page(ROOT / "tests")
    if parser.parse_args().check:
        if not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != wanted:
            print(f"{PAGE} is out of date: run python tools/make_definitions.py")
            return 1
        return 0
    PAGE.write_text(wanted, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
