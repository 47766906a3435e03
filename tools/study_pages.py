"""The page of one study: its claim, its figure, the claims based on it, all measurements, and their
provenance. `make_results.py` writes the pages."""

import importlib
import sys
from pathlib import Path
from typing import Any

from cells import shown, table, typeset
from claims import section as claim_section  # files in this folder
from persistence import opening

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "studies" / "results"
NOTICE = "<!-- Written by tools/make_results.py: change studies/ or tools/, not this page. -->"
FIGURES = {  # other figures are named after their study; each entry is its caption
    "arms_race": (
        "arms_race.svg",
        "Genes for pace and sight over time; kills by hunters among prey from other times",
    ),
    "cycle_causes": (
        "cycle_causes.svg",
        "Shares of runs that persist and cycle, for six kinds of deer and nearby worlds",
    ),
    "cycles": ("predator_prey.png", "Numbers of grass, deer and wolves over 10,000 ticks: seven cycles"),
    "deer_that_flee": (
        "deer_that_flee.svg",
        "Gain from running, by its cost; running animals, by distance; numbers of deer over time",
    ),
    "diel_migration": (
        "diel_migration.png",
        "Depth of copepods over twenty days: deep by day, shallow by night",
    ),
    "fishing_for_size": (
        "fishing_for_size.svg",
        "Inherited weight of newborns and catch by year, for stocks fished by size, at random or not at all",
    ),
    "full_rate": (
        "full_rate.svg",
        "Wolf numbers while deer, wolves or both learn; catches in the arena; policy change",
    ),
    "goats": ("goats_carriers.png", "Carriers of genes against red, yellow and green grass over generations"),
    "goats_factorial": (
        "goats_factorial.svg",
        "Selection coefficients of four genes, and newborns that eat yellow grass, by inheritance",
    ),
    "happiness": ("happiness_genes.png", "Happiness weights in vole genomes over generations"),
    "individual_brains": (
        "individual_brains.svg",
        "Numbers of deer if each animal or each species has a network; their variation in all runs",
    ),
    "intelligence": (
        "intelligence.svg",
        "Evolved learning rates by rates of change; by what each past predicts; and the effect in all arms",
    ),
    "isolation": ("isolation.svg", "Diversity of genes and policies with and without migration"),
    "learning_map": (
        "learning_map.svg",
        "Persistence and cycles by the learning rates of deer and wolves, on two grounds; persistence by the "
        "wolves' rate and by area",
    ),
    "lifelong": (
        "lifelong.svg",
        "Population sizes while deer and wolves learn; wolves in all runs; policy change",
    ),
    "never_settling": (
        "never_settling.svg",
        "Runs in which deer and wolves live; distance of policies by the time between them; catches by the times "
        "of wolves and deer",
    ),
    "outside": ("outside.png", "Deer intake while three learners train"),
    "learning_classics": (
        "learning_classics.svg",
        "Periods of rotifers, weights and catches of fish, intake of grazers, neighbors of prey; they learn or not",
    ),
    "prudence": (
        "prudence.svg",
        "Intake over time and selection within and among patches in five arms; maps of intake in four arms",
    ),
    "rapid_evolution": (
        "rapid_evolution.svg",
        "Numbers of algae and rotifers and defense of algae over time; lag and period of all runs",
    ),
    "real_series": (
        "real_series.svg",
        "Measured predator and prey series, and their statistics against the shipped world's",
    ),
    "recovery": ("recovery.svg", "True and estimated parameters of ten worlds, and the pelts' posterior"),
    "swarms": (
        "swarms.svg",
        "Neighbors and attraction of prey and predators' field of view over time, with and without confusion",
    ),
    "three_networks": ("three_networks.png", "Deer intake while three networks train"),
    "why": ("why.svg", "An extinction as `ecs-eco why` draws it: numbers, causes of death, energy"),
}
STALE = "**The world or the study has since changed; this result must be recomputed.**"


def page(record: dict[str, Any], claims: list[dict[str, Any]]) -> str:
    """Return a study's page."""
    name = record["name"]
    own = [claim for claim in claims if claim["study"] == name]
    blocks = [
        f"# {name}",
        NOTICE,
        claim_of(record),
        *([figure(name, "../img")] if name in FIGURES else []),
        *([f"**{summary}**"] if (summary := opening(record)) else []),
        *([STALE] if stale(record) else []),
        *(["## Claims based on this study"] if own else []),
        *(claim_section(claim, record) for claim in own),
        "## Measured",
        f"{counted(record)} goals passed. Lines without a goal can neither pass nor fail.",
        table(["outcome", "statement", "measured", "goal"], [measured(line) for line in record["verdicts"]]),
        *([table(record["table"]["head"], typed(record["table"]["rows"]))] if record.get("table") else []),
        *([typeset(record["notes"])] if record.get("notes") else []),
        "## Where the numbers come from",
        *([registered(record["registration"])] if "registration" in record else []),
        origin(record),
    ]
    return "\n\n".join(blocks) + "\n"


def figure(name: str, folder: str) -> str:
    """Return a study's image, with its caption."""
    file, shows = FIGURES[name]
    return f"![{shows}]({folder}/{file})"


def measured(line: dict[str, Any]) -> list[str]:
    """Return a line's row; registered words are not changed."""
    word = "reported" if is_reported(line) else "passed" if line["met"] else "**failed**"
    if "registered" in line:
        return [f"{word}, registered", line["statement"], shown(line["value"]), line["goal"]]
    return [word, *(shown(line[key]) for key in ("statement", "value", "goal"))]


def typed(rows: list[list[Any]]) -> list[list[Any]]:
    """Return a stored table's rows in the pages' typography."""
    return [[typeset(x) if isinstance(x, str) else x for x in row] for row in rows]


def registered(noted: dict[str, str]) -> str:
    """Return the link to a study's registration."""
    return (
        f"Registered before the first run in [{noted['file']}](../../{noted['file']}), sha256 "
        f"`{noted['sha256'][:12]}`, commit `{noted['commit'][:12]}`."
    )


def origin(record: dict[str, Any]) -> str:
    """Return a result's command, cases, seeds, commits, configuration and versions."""
    commits = ", ".join(f"`{c[:12]}`" for c in record["commits"])
    rows = [
        ["run it again", f"`{command(record)}`"],
        ["cases", f"{len(record['cases']):,}"],
        *([["seeds", ranges(record["seeds"])]] if record["seeds"] else []),
        ["computing", f"{record['seconds']:,.0f} s"],
        ["commits", commits + " with uncommitted changes" * bool(record["dirty"])],
        ["configuration", f"`{record['config_hash'][:12]}`"],
        ["versions", ", ".join(f"{k} {v}" for k, v in record["versions"].items())],
        ["all numbers", f"[{record['name']}.json](../../studies/results/{record['name']}.json)"],
    ]
    return table(["", ""], rows)


def command(record: dict[str, Any]) -> str:
    """Return the command that runs all cases of a study again, because by default, finished ones are kept;
    older results name the study's file."""
    of = record["command"].replace("python studies/", "python -m studies.").replace(".py", "")
    return of if "--fresh" in of else f"{of} --fresh"


def counted(record: dict[str, Any]) -> str:
    """Return the numbers of goals passed and set."""
    goals = [line for line in record["verdicts"] if not is_reported(line)]
    return f"{sum(line['met'] for line in goals)} of {len(goals)}"


def stale(record: dict[str, Any]) -> bool:
    """Return whether a result's configuration differs from its study's current configuration."""
    study = study_of(record["name"])
    return study is not None and bool(study.whole_config_hash() != record["config_hash"])


def claim_of(record: dict[str, Any]) -> str:
    """Return a study's current claim."""
    study = study_of(record["name"])
    return str(record["claim"] if study is None else study.claim)


def study_of(name: str) -> Any:
    """Return a result's study from its current script; None if studies/ does not contain it."""
    return _module(name).STUDY if (ROOT / "studies" / f"{name}.py").is_file() else None


def is_reported(line: dict[str, Any]) -> bool:
    """Return whether a line has no goal."""
    return bool(_module("common.study").is_reported(line))


def _module(name: str) -> Any:
    if str(ROOT) not in sys.path:  # run as a script
        sys.path.insert(0, str(ROOT))
    return importlib.import_module(f"studies.{name}")


def ranges(numbers: list[int]) -> str:
    """Return integers as text, with consecutive ones as a range: 1–5, 9."""
    out: list[list[int]] = []
    for x in sorted(numbers):
        if out and x == out[-1][1] + 1:
            out[-1][1] = x
        else:
            out.append([x, x])
    return ", ".join(str(a) if a == b else f"{a}–{b}" for a, b in out)
