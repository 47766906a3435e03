"""Pages of the Python API: the names on each page, and their entries. Used by tools/site_pages.py.

Every function or class named here appears on its page, regardless of its docstring. A method appears on its
class's page if its docstring has a section (Parameters, Returns, Examples …); methods with one-line
docstrings are internal.
"""

import inspect
import re
from collections.abc import Iterator
from importlib import import_module

MEMBERS = "   :members:\n   :show-inheritance:\n"
INHERITED = "   :inherited-members: object\n"
WHOLE = {"World", "Brain", "ModuleBrain", "Learner", "TorchLearner", "Lineage"}  # with inherited members
SECTION = re.compile(r"^[A-Z]\w+\n-{3,}$", re.MULTILINE)
TYPES = ("boolean", "f32", "f64", "i8", "i16", "i32", "i64", "u8", "u16", "u32", "u64")
API: dict[str, tuple[str, str, tuple[str, ...]]] = {  # page: (title, opening, names as `module:name`)
    "world": (
        "World, tables and systems",
        "Build a world, run and view it, and add your own components and systems.",
        (
            "ecs_eco:World",
            "ecs_eco:Table",
            "ecs_eco:System",
            "ecs_eco:component",
            "ecs_eco:column",
            "ecs_eco:PHASES",
            "ecs_eco:njit",
            "ecs_eco:draw",
            "ecs_eco.engine.random:draw_many",
            "ecs_eco.life.reconfigure:reconfigure",
            "ecs_eco.nervous.external:External",
            "ecs_eco.nervous.external:Sensed",
        ),
    ),
    "config": (
        "World files",
        "Load and check world files, and declare your own keys. Every built-in key is in "
        "[the world file](../world/index.md).",
        ("ecs_eco.config:*", "ecs_eco.engine.errors:ConfigError", "ecs_eco.odd:describe"),
    ),
    "runs": (
        "Runs and their records",
        "Run a world and record it to a folder; resume, fork or repeat a run; and read its records.",
        (
            "ecs_eco.runs.run:run_to_folder",
            "ecs_eco.runs.run:resume",
            "ecs_eco.runs.run:fork",
            "ecs_eco.runs.repeat:repeat",
            "ecs_eco.runs.repeat:repeatable",
            "ecs_eco.runs.run:read_manifest",
            "ecs_eco.analysis.runs:load_series",
            "ecs_eco.analysis.runs:Series",
            "ecs_eco.record.frame:SeriesTable",
            "ecs_eco.record.parquet:read_parts",
            "ecs_eco.record:*",
        ),
    ),
    "lab": (
        "Experiments: many runs",
        "Compare treatments, sweep values, search for parameters, train policies and connect islands; see "
        "[comparing](../../how-to/compare.md), [searching](../../how-to/searching.md) and "
        "[measurements](../../how-to/measurements.md).",
        (
            "ecs_eco.lab:*",
            "ecs_eco.lab.folder:read_sweep",
            "ecs_eco.lab.table:collect",
            "ecs_eco.lab.searching.sampler:weighted_quantiles",
        ),
    ),
    "explain": (
        "Explanations of evolution",
        "Find the alleles that rose by more than drift allows.",
        ("ecs_eco.explain:*",),
    ),
    "learning": (
        "Learning",
        "Policy networks and PPO, also for plain Gymnasium environments; see "
        "[learning](../../explanation/learning.md).",
        ("ecs_eco.learning:*",),
    ),
    "rl": (
        "External reinforcement learning",
        "Species as environments of PettingZoo and Gymnasium: "
        '`pip install -e ".[rl]"`; see [bring your own learner]'
        "(../../how-to/bring_your_own_learner.md).",
        ("ecs_eco.rl:*", "ecs_eco.rl.single:Body", "ecs_eco.rl.parallel:Parallel", "ecs_eco.rl.vector:Slots"),
    ),
    "genomes": (
        "Genomes",
        "Layouts, operators and statistics; see [genomes](../../explanation/genomes.md).",
        ("ecs_eco.genomes:*", "ecs_eco.genomes.models:GenomeSection", "ecs_eco.genomes.own_values:own_value"),
    ),
    "space": (
        "Space",
        "Edges, neighbors, fields and ground.",
        ("ecs_eco.space:*", "ecs_eco.space.pairs:Pairs", "ecs_eco.space.geometry:back_into"),
    ),
    "systems": (
        "Systems",
        "Systems act on organisms and objects in each tick, in the order of "
        "[the schedule](../../explanation/design.md#the-tick).",
        ("ecs_eco.systems:*", "ecs_eco.systems.schedule:schedule"),
    ),
    "bands": (
        "One world split across several processes",
        "Divide the work of one world among MPI processes; see [bands](../../explanation/bands.md).",
        ("ecs_eco.bands:*",),
    ),
    "view": (
        "Viewing",
        "Pictures and data of recorded runs, as the viewer shows them; `World.view` opens the page.",
        (
            "ecs_eco.view.paint:Painter",
            "ecs_eco.view.replay:Replay",
            "ecs_eco.view.inspect:state_of",
            "ecs_eco.view.inspect:drawable",
        ),
    ),
    "testing": (
        "Tests for your own parts",
        "Checks for your own components, systems, genomes and worlds.",
        ("ecs_eco.testing:*",),
    ),
}
ANALYSIS = (  # module: names; other names serve the package's own reports
    "why:write_why",
    "report:write_report",
    "nervous_figure:draw_nervous_system,save",
    "cycles:Lag,CycleStatistics,living_stretch,cycle_statistics,lag,median_lag_interval,cross_correlation,"
    "Surrogates,cross_seed_surrogates",
    "extinction:Decline,decline,declines,lifetime,opening",
    "lineage:Lineage",
    "survival:Interval,SurvivalCurve,kaplan_meier,log_rank,wilson,difference_of_shares,bootstrap_difference",
    "spectrum:thin,transform,detrend,spectrum,Peak,spectral_peak",
    "rhythm:Cosinor,cosinor,p_of_days",
    "depth:DepthCycle,depth_cycle,day_by_hour",
    "carriers:Frequencies,carriers",
    "genes:Course,Selection,log_odds_slope,haldanes",
    "breeding:Breeding,Cohort,responses,forest",
    "signature:Cycle,cycle,period_of",
    "compare:compare",
    "seed_grid:VarianceShares,components,variance_shares,mean_interval,effective_runs,share_interval,"
    "share_difference",
    "figures:populations,over_time,phase,spectra,lags,deaths,energy,survival,save,save_svg",
)


DATA = {  # constants, which are neither functions nor classes
    "PHASES": "The phases of a tick in order: environment, sense, feel, learn, decide, move, interact, metabolise, "
    "die, reproduce, record. Deaths take effect at the end of `die`, births at the end of `reproduce`.",
    "ANEW": "For `about(change=…)`: the value cannot change during a run; build a new world.",
    "FREE": "For `about(change=…)`: the value may change during a run.",
    "Count": "Type of a key: an integer from 1 to 50,000,000.",
    "Name": "Type of a key: a name made of letters, digits and underscores that begins with a letter.",
    "NonNegative": "Type of a key: a finite number of at least 0.",
    "Positive": "Type of a key: a finite number above 0.",
    "Real": "Type of a key: a finite number.",
    "Share": "Type of a key: a number from 0 to 1.",
    "CONTINUOUS": "Represents a continuous action group among a network's `groups`.",
    "ENVIRONMENTS": "World and species of each registered Gymnasium environment, by name.",
    "CHOICES": "The mate choice rules, by number: nearest, random, richest, oldest.",
    "DNA": "The alphabet ACGT.",
}


def pages() -> dict[str, str]:
    """Return the pages' text by name."""
    texts = {name: _page(title, opening, names) for name, (title, opening, names) in API.items()}
    texts["world"] += _types()
    return texts | {"analysis": _analysis()}


def entries() -> Iterator[tuple[str, str, str]]:
    """Yield (page, module, name) for every function, class and constant in the API."""
    for page, (_, _, names) in API.items():
        yield from ((page, module, one) for name in names for module, one in _wanted(name))
    yield from (("analysis", *entry) for _, names in _phenomena() for entry in names)


def _wanted(name: str) -> Iterator[tuple[str, str]]:
    module, _, what = name.partition(":")
    for one in import_module(module).__all__ if what == "*" else (what,):
        yield module, one


def is_public(member: object) -> bool:
    """Return whether a class member is public: a property, or a fully documented method."""
    if isinstance(member, property):
        return True
    return SECTION.search(inspect.getdoc(member) or "") is not None


def _page(title: str, opening: str, names: tuple[str, ...]) -> str:
    wanted = dict.fromkeys(entry for name in names for entry in _wanted(name))
    return "\n\n".join([f"# {title}\n\n{opening}", *(_entry(*entry) for entry in wanted)]) + "\n"


def thing_of(module: str, name: str) -> object:
    """Return an entry's object; None if it belongs to an extra that is not installed."""
    try:
        return getattr(import_module(module), name)
    except ModuleNotFoundError:
        return None


def _entry(module: str, name: str) -> str:
    if name in DATA:
        return _directive("py:data", f"{module}.{name}", f"\n   {DATA[name]}\n")
    thing = thing_of(module, name)
    if isinstance(thing, type) and issubclass(thing, Exception):
        return _directive("autoexception", f"{module}.{name}", "")
    if inspect.isclass(thing):
        members = "" if module.endswith(".systems") else MEMBERS
        return _directive("autoclass", f"{module}.{name}", members + INHERITED * (name in WHOLE))
    return _directive("autofunction", f"{module}.{name}", "")  # also for extras, which autodoc mocks


def _directive(kind: str, name: str, options: str) -> str:
    return f"```{{eval-rst}}\n.. {kind}:: {name}\n{options}```"


def _types() -> str:
    """Return the column types, one per line."""
    import ecs_eco

    data = [
        f".. py:data:: ecs_eco.{name}\n\n   Column type: numpy's `{getattr(ecs_eco, name).dtype}`.\n"
        for name in TYPES
    ]
    return "\n## Types of columns\n\n```{eval-rst}\n" + "\n".join(data) + "```\n"


def _phenomena() -> Iterator[tuple[str, list[tuple[str, str]]]]:
    for entry in ANALYSIS:
        name, _, chosen = entry.partition(":")
        yield name, [(f"ecs_eco.analysis.{name}", one) for one in chosen.split(",")]


def _analysis() -> str:
    parts = [
        "# Analysis\n\nStatistics and figures for recorded runs, one phenomenon per module; see "
        "[running](../../how-to/running.md#from-python)."
    ]
    for name, names in _phenomena():
        doc = import_module(f"ecs_eco.analysis.{name}").__doc__ or ""
        head = doc.strip().partition("\n\n")[0].replace("\n", " ")
        parts += [f"## {name}\n\n{head}", *(_entry(*entry) for entry in names)]
    return "\n\n".join(parts) + "\n"


def index() -> str:
    """Return the page that lists the other pages."""
    names = ["world", "components", *(n for n in API if n != "world"), "analysis"]
    return (
        "# Python\n\nThe classes and functions that you can import, documented from their docstrings.\n\n"
        "```{toctree}\n:maxdepth: 2\n\n" + "\n".join(names) + "\n```\n"
    )
