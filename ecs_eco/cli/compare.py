"""The command compare: a world with and without treatments, with the same seeds."""

from collections.abc import Mapping
from concurrent.futures import BrokenExecutor, Executor
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table

from ecs_eco.cli.folders import results
from ecs_eco.cli.options import On, Policies, Quiet, Set, Ticks, Trust, Workers, World, new_folder, number
from ecs_eco.cli.terminal import FAILED, INTERRUPTED, complain, exits, printable, progress, refuse, say
from ecs_eco.cli.trust import allow
from ecs_eco.lab.comparison import Comparison, Key, Planned, comparison_of
from ecs_eco.lab.executors import LOCAL, check_engine, engine, prepare
from ecs_eco.lab.treatments import arms_of, check_policies
from ecs_eco.lab.work import run_jobs
from ecs_eco.record import container
from ecs_eco.record.claim import Claim
from ecs_eco.worlds.policies import POLICIES


@exits
def compare(
    world: World,
    treatment: Annotated[
        list[str] | None,
        typer.Option(
            "--treatment",
            "--control",
            metavar="NAME|KEY=VALUE",
            help="A treatment: random-policy or untrained-policy (:deer for one species), "
            "learning, frozen, individual-brains, no-reflexes, neutral-drift, shuffled-genome, "
            "no-mutation, constant-light, inverted-light, no-smell, "
            "no-SPECIES, energy-only, energy-and-light, or a changed value. Repeatable. Default: random-policy.",
        ),
    ] = None,
    seeds: Annotated[int, number("Number of runs per arm, with seeds from 1.", most=10_000)] = 8,
    ticks: Ticks = None,
    set_: Set = None,
    workers: Workers = None,
    out: Annotated[
        Path | None, new_folder("Results folder: new, empty, or begun by this command. Default: in runs/.")
    ] = None,
    quiet: Quiet = False,
    training_seeds: Annotated[
        int | None,
        number(
            "Train policies with training seeds 1 to N, and run each policy with every world seed.",
            most=10_000,
        ),
    ] = None,
    retrain: Annotated[
        bool,
        typer.Option(
            "--retrain",
            help="Retrain under each treatment that changes values. Default: all arms use the same policies.",
        ),
    ] = False,
    policies: Policies = "trained",
    on: On = LOCAL,
    trust: Trust = False,
) -> None:
    """Compare a world with and without treatments; the same command with --out DIR resumes a stopped
    comparison."""
    allow(trust, world, set_)
    check_engine(on)
    arms = arms_of(world, set_ or [], treatment or ["random-policy"])
    if policies != "trained":
        check_policies(policies, arms[0].config)
        if training_seeds is not None:
            fault = "is not used, because --training-seeds trains policies"
            refuse("--policies", fault, policies, "only one of these options")
        arms = [arm.with_policies(_seen_from_everywhere(Path(policies), on)) for arm in arms]
    comparison = comparison_of(arms, out or Path(), seeds, ticks, training_seeds, retrain)
    with claim_folder(out, comparison) as claim:
        comparison = replace(comparison, folder=_seen_from_everywhere(claim.path, on))
        with engine(on, workers) as pool:
            comparison.begin()
            prepare(pool, comparison.folder, arms[0].config)
            _do(comparison, pool, quiet)
        _report(comparison)


def _seen_from_everywhere(path: Path, on: str) -> Path:
    """Return an absolute path if workers run elsewhere, but leave names such as "trained" unchanged."""
    return path if on == LOCAL or str(path) in POLICIES else path.absolute()


def claim_folder(out: Path | None, comparison: Comparison) -> Claim:
    """Claim a comparison's folder: either a new folder, or one in which the same comparison was begun.

    Raises ForeignFile if it contains a different comparison, FolderInUse if another process is writing there.
    """
    begun = out is not None and container.has(out, Planned)
    if begun:
        container.check(comparison.folder, Planned, comparison.plan)
    return results(out, f"{comparison.arms[0].config.name}-compare", begun)


def _do(comparison: Comparison, pool: Executor, quiet: bool) -> None:
    """Do the remaining training and runs, with a progress bar, and print why jobs failed.

    Ctrl-C ends the command at once; failures end it after the last job.
    """
    (calls, after), n, out = comparison.left(), len(comparison.runs), comparison.folder
    left = sum(key in calls for key in comparison.runs)
    if left < n and not quiet:
        complain(f"{n - left} of {n} runs are already done.")

    def failed(key: Key | Path, error: BaseException) -> None:
        if isinstance(error, BrokenExecutor):
            complain(
                "A worker process was killed (out of memory?). Finished runs are complete; others are lost."
            )
        else:
            complain(f"{key}: {type(error).__name__}: {error}")

    with progress("comparing", quiet, "jobs") as bar:
        try:
            done = run_jobs(calls, pool, bar, failed, after=after)
        except KeyboardInterrupt:
            complain(
                f"Stopped after {bar.done} of {len(calls)} jobs; finished recordings are in {out}. "
                f"To resume, repeat the command with --out {out}."
            )
            raise typer.Exit(INTERRUPTED) from None
    if len(done) < len(calls):
        lost = left - sum(key in done for key in comparison.runs)
        complain(f"{lost} of {n} runs failed; recordings of all others are in {out}.")
        raise typer.Exit(FAILED)


def _report(comparison: Comparison) -> None:
    """Compare the arms; write and print the comparison."""
    policies = comparison.policies_in_words()
    result = comparison.result()
    for name, text in result["opening"].items():
        say(f"{name}: {text}")
    for name, words in policies.items():
        say(f"  {name} runs with {words}")
    for name, arm in result["arms"].items():
        if "crossed" in arm:
            _say_persistence(name, arm)
    for name, arm in result["arms"].items():
        _say_depths(name, arm)
    _print_table(result["arms"])
    for name, kinds in result.get("measured", {}).get("arms", {}).items():
        _say_measured(name, kinds)
    say(f"written: {comparison.folder / 'compare.html'}")


def _say_persistence(name: str, arm: Mapping[str, Any]) -> None:
    """Print the proportion of runs in which all species persist, and the sources of variance."""
    _, low, high = arm["persistence"]
    say(
        f"  {name}: share of runs in which all species persist, 95% interval over training and world seeds: "
        f"{low:.0%} to {high:.0%}"
    )
    shares = arm["crossed"]["variance_shares"].get("persisted")
    if shares and shares["share"]["rest"][0] is not None:
        parts = ", ".join(f"{effect} {share[0]:.0%}" for effect, share in shares["share"].items())
        say(f"  {name}: sources of variance in persistence: {parts}")


def _say_depths(name: str, arm: Mapping[str, Any]) -> None:
    """Print how each species' depth changes over the day, if the world has days and depth."""
    for species, row in arm["per_species"].items():
        if depth := row.get("depth"):
            r = "" if depth["r"] is None else f", correlation with light {depth['r'][0]:.2f}"
            say(
                f"  {name}: depth of {species} over the day, means of {depth['n']} runs: amplitude "
                f"{depth['amplitude'][0]:.0%} of the water depth, {depth['along_day'][0]:+.0%} in phase "
                f"with the sun{r}"
            )


def _say_measured(name: str, kinds: Mapping[str, Any]) -> None:
    """Print a reporter's mean values for each species and arm."""
    for of, arms in kinds.items():
        means = [f"{arm} {x['mean'][0]:.4g}" for arm, x in arms.items() if x["mean"] is not None]
        what = name if of.startswith("(") else f"{name} of {of}"
        say(f"{what}, mean over runs: {', '.join(means) or 'none'}")


def _print_table(arms: Mapping[str, Any]) -> None:
    """Print mean numbers and extinctions for each arm and species."""
    head = ("arm", "runs", "all persist", "species", "mean number", "extinct in")
    table = Table(*(Column(word, overflow="fold", no_wrap=word in ("arm", "species")) for word in head))
    for name, arm in arms.items():
        first = [escape(printable(name)), str(arm["n"]), str(arm["persisted"])]
        for species, row in arm["per_species"].items():
            shown = escape(printable(species))
            table.add_row(*first, shown, f"{row['mean_number']:.1f}", str(row["extinctions"]))
            first = ["", "", ""]
    Console().print(table)
