"""The work of the sweep commands: run and resume a plan's jobs, print their state, collect results."""

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table

from ecs_eco.cli.folders import results
from ecs_eco.cli.terminal import FAILED, INTERRUPTED, complain, printable, refuse, say, shown
from ecs_eco.cli.trust import allow
from ecs_eco.config.shipped import named
from ecs_eco.inputs import trust
from ecs_eco.inputs.code import read
from ecs_eco.lab.design import design_of
from ecs_eco.lab.executors import SLURM, check_engine, engine
from ecs_eco.lab.folder import Manifest, Sweep, begin, read_sweep
from ecs_eco.lab.jobs import UNFINISHED, run_job
from ecs_eco.lab.plan import read_plan
from ecs_eco.lab.slurm import Options, resume
from ecs_eco.lab.sweep import Outcome, Status, Survey, do_jobs, unfinished
from ecs_eco.lab.table import check_response, collect, missing_for
from ecs_eco.record import container
from ecs_eco.record.claim import Claim
from ecs_eco.record.code import FOLDER

PACE = 1.0  # [s] between scans of the folder


def sweep_plan(
    plan: str,
    on: str,
    workers: int | None,
    out: Path | None,
    quiet: bool,
    trust: bool,
    sbatch: Sequence[str] = (),
    design: str | None = None,
    most: int | None = None,
    until: tuple[str, float] | None = None,
) -> None:
    """Run the jobs of a plan in a new folder, or continue in a folder begun with this plan."""
    if until is not None and on == SLURM:
        refuse("--until-width", "is not possible on SLURM", until[1], "--on local or ray")
    check_where(on, sbatch)
    file = read_plan(plan, design, most)
    for note in [] if quiet else file.notes:
        complain(f"note: {note}")
    world = file.plan.world
    allow(trust, world if named(world) is not None else file.document.folder / world)
    checked = design_of(file)
    if until is not None:
        check_response(until[0], checked.base)
    begun = out is not None and container.has(out, Manifest)
    with results(out, f"{Path(plan).stem}-sweep", begun) as claim:
        do_sweep(begin(claim.path, checked), on, workers, quiet, sbatch, until)


def resume_sweep(
    folder: Path, on: str, workers: int | None, quiet: bool, trust: bool, sbatch: Sequence[str] = ()
) -> None:
    """Resume the unfinished jobs of a sweep."""
    check_where(on, sbatch)
    sweep = read_sweep(folder)
    sweep.may_continue()
    if trust:
        allow_kept(sweep)
    with Claim(folder):
        do_sweep(sweep, on, workers, quiet, sbatch)


def check_where(on: str, sbatch: Sequence[str]) -> None:
    """Reject an unknown engine, and options for a different engine."""
    check_engine(on)
    if sbatch and on != SLURM:
        refuse("--sbatch", "applies only to SLURM", sbatch[0], "--on slurm")


def allow_kept(sweep: Sweep) -> None:
    """Allow the code in a sweep's folder, and print its names."""
    code = read([str(n["entry"]) for n in sweep.content["code"]], [sweep.folder / FOLDER])[0]
    trust.remember({source.sha256: source.path for source in code.sources})
    for source in code.sources:
        say(f"allowed to run: {source}")


def do_sweep(
    sweep: Sweep,
    on: str,
    workers: int | None,
    quiet: bool,
    sbatch: Sequence[str] = (),
    until: tuple[str, float] | None = None,
) -> None:
    """Run or submit the unfinished jobs of a sweep, or only as many as an interval's width needs; end the
    command if any failed or it was stopped."""
    numbers = unfinished(sweep) if until is None else missing_for(sweep, *until)
    if until is None and len(numbers) < len(sweep.jobs) and not quiet:
        complain(f"{len(sweep.jobs) - len(numbers)} of {len(sweep.jobs)} jobs are already done.")
    if on == SLURM:
        submit_sweep(sweep, numbers, workers, sbatch)
        return
    try:
        with engine(on, workers) as pool, watched(sweep, quiet):
            outcome = do_jobs(sweep, pool, numbers)
            while until is not None and outcome.whole and (numbers := missing_for(sweep, *until)):
                outcome = do_jobs(sweep, pool, numbers)
    except KeyboardInterrupt:
        complain(f"Stopped; finished jobs are kept. Resume with: ecs-eco sweep resume {sweep.folder}")
        raise typer.Exit(INTERRUPTED) from None
    tell_outcome(sweep, outcome)


def submit_sweep(sweep: Sweep, numbers: Sequence[int], limit: int | None, sbatch: Sequence[str]) -> None:
    """Submit the jobs that are neither done nor queued to SLURM."""
    options = Options(more=tuple(sbatch)) if limit is None else Options(limit, more=tuple(sbatch))
    ids, queued = resume(sweep, numbers, options)
    if queued:
        complain(f"{len(queued)} jobs are already queued or running.")
    if ids:
        say(
            f"submitted {len(numbers) - len(queued)} jobs to SLURM: {', '.join(ids)}; to show progress: ecs-eco "
            f"sweep status {sweep.folder}"
        )


def tell_outcome(sweep: Sweep, outcome: Outcome) -> None:
    """Print the outcome of the jobs; end the command if any failed."""
    if outcome.retried:
        complain(f"Workers were killed {outcome.retried} times; their jobs were restarted.")
    if outcome.failed:
        tell_failures(sweep, outcome.failed)
        complain(
            f"{len(outcome.failed)} of {len(sweep.jobs)} jobs failed; all others are done. To retry the "
            f"failed jobs: ecs-eco sweep resume {sweep.folder}"
        )
        raise typer.Exit(FAILED)
    done = len(sweep.jobs) - len(unfinished(sweep))
    say(
        f"{done} jobs are done in {sweep.folder}; to write the table and figures: ecs-eco sweep "
        f"collect {sweep.folder}"
    )


def tell_failures(sweep: Sweep, failed: dict[int, str], most: int = 5) -> None:
    """Print why jobs failed, most frequent reason first."""
    reasons = Status(failed=failed).errors()
    for text, numbers in reasons[:most]:
        complain(
            f"{sweep.jobs[numbers[0]]}"
            + (f" and {len(numbers) - 1} more" if len(numbers) > 1 else "")
            + f": {text}"
        )
    if len(reasons) > most:
        complain(f"… and {len(reasons) - most} more reasons")


def do_jobs_here(folder: Path, numbers: Sequence[int], trust: bool) -> None:
    """Run jobs one after another in this process; on SIGTERM, write a checkpoint and exit with UNFINISHED."""

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    sweep = read_sweep(folder)
    for number in numbers:
        sweep.job_folder(number)
    if trust:
        allow_kept(sweep)
    before, failed = signal.signal(signal.SIGTERM, stop), dict[int, str]()
    try:
        for number in numbers:
            try:
                done = run_job(folder, number)
                say(f"{sweep.jobs[number]}: done, {done['digest'][:16]}")
            except Exception as error:
                failed[number] = f"{type(error).__name__}: {error}"
    except KeyboardInterrupt:
        complain("Unfinished: stopped by a signal; repeat the command to resume.")
        raise typer.Exit(UNFINISHED) from None
    finally:
        signal.signal(signal.SIGTERM, before)
    if failed:
        tell_failures(sweep, failed)
        raise typer.Exit(FAILED)


def tell_status(folder: Path) -> None:
    """Print the state of a sweep as a table, and why jobs failed."""
    sweep = read_sweep(folder)
    status = Survey(sweep).look()
    table = Table(
        title=printable(f"{sweep.content['title'] or sweep.content['world']}: {sweep.folder}"),
        title_justify="left",
        title_style="bold",
    )
    for word in ("jobs", "done", "running", "waiting", "failed", "ticks", "ticks/s", "remaining"):
        table.add_column(word, justify="right")
    counts = (status.jobs, *map(len, (status.done, status.running, status.waiting, status.failed)))
    share = f"{status.ticks:,} of {status.ticks_in_all:,} ({status.ticks / status.ticks_in_all:.0%})"
    table.add_row(
        *map(str, counts), share, f"{status.rate:,.0f}" if status.rate else "–", duration(status.remaining)
    )
    Console().print(table)
    tell_failures(sweep, status.failed)
    if status.failed or (status.waiting and not status.running):
        say(f"to resume the unfinished jobs: ecs-eco sweep resume {sweep.folder}")


def duration(seconds: float | None) -> str:
    """Return a readable duration: 45 s, 12 min, 3 h 20 min."""
    if seconds is None:
        return "–"
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"


@contextmanager
def watched(sweep: Sweep, quiet: bool) -> Iterator[None]:
    """Show the progress of a sweep: as a bar on a terminal, as lines elsewhere; show nothing if quiet."""
    end, survey, name = threading.Event(), Survey(sweep), sweep.content["world"]
    with shown(
        name,
        quiet,
        lambda status: f"{name}: {in_words(status)}",
        lambda s: {"completed": s.ticks, "total": s.ticks_in_all, "text": in_words(s)},
        ("{task.fields[text]}", "TimeElapsedColumn"),
    ) as show:

        def watch() -> None:
            while show and not end.wait(max(PACE, len(sweep.jobs) / 1000)):
                show(survey.look())

        thread = threading.Thread(target=watch, daemon=True)
        thread.start()
        try:
            yield
        finally:
            end.set()
            thread.join()


def in_words(status: Status) -> str:
    """Return the progress of a sweep as one line."""
    failed = f", {len(status.failed)} failed" if status.failed else ""
    rest = f", {status.rate:,.0f} ticks/s, {duration(status.remaining)} left" if status.rate else ""
    return f"{len(status.done)} of {status.jobs} jobs, {len(status.running)} running{failed}{rest}"


def collect_sweep(folder: Path, quiet: bool) -> None:
    """Write the table, figures and page of a sweep, and print a summary."""
    sweep = read_sweep(folder)
    result = collect(sweep)
    if result.missing and not quiet:
        complain(f"{result.missing} of {len(sweep.jobs)} jobs are unfinished and not in the table.")
    for line in result.lines:
        say(line)
    say(f"written: {result.table}, {result.page}")
