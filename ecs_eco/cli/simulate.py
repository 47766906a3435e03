"""The work of run, resume, repeat and train."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import typer

from ecs_eco.cli.archipelago import command_of, has_islands, resume_islands, run_islands
from ecs_eco.cli.folders import known_policies, results
from ecs_eco.cli.terminal import FAILED, INTERRUPTED, complain, progress, refuse, say
from ecs_eco.config import load
from ecs_eco.engine import portable
from ecs_eco.experiments.engines import LOCAL, check_engine, engine
from ecs_eco.record.archipelago import is_archipelago


def run_world(
    world: str,
    changes: list[str],
    ticks: int | None,
    seed: int | None,
    out: Path | None,
    quiet: bool,
    threads: int,
    learn: bool | None,
    policies: str,
    report: bool,
    checkpoint_every: int | None = None,
    keep: int = 3,
    shown: tuple[int, bool] | None = None,
    record: str | None = None,
    workers: int | None = None,
    on: str = LOCAL,
    prepare: Callable[[Any], None] | None = None,
) -> None:
    """Run a world into a folder; `shown`: the port of a viewer, and whether to open the browser."""
    config = load(world, changes)
    if has_islands(config, world, shown is not None or checkpoint_every is not None, workers, on):
        return run_islands(
            config,
            world,
            changes,
            ticks,
            seed,
            out,
            quiet,
            threads,
            learn,
            policies,
            report,
            record,
            workers,
            on,
        )
    seed, ticks = config.seed if seed is None else seed, ticks or config.ticks
    known_policies(policies, config)
    from ecs_eco.record.details import how_many
    from ecs_eco.runs.run import run_to_folder
    from ecs_eco.worlds.first_start import known_to_list, two_processes

    how_many(record)
    with (
        nullcontext() if prepare else two_processes(known_to_list(config.name)) as kernels,
        results(out, f"{config.name}-{seed}") as claim,
        progress(config.name, quiet) as bar,
        _viewer(config.title or config.name, ticks, shown) as viewer,
    ):
        out = claim.path
        try:
            command = command_of(world, config, seed, ticks, policies, changes, learn, record)
            more = _given(
                prepare=prepare if viewer is None else viewer.open,
                record=record,
                checkpoint_every=checkpoint_every,
                keep=checkpoint_every and keep,
            )
            result = run_to_folder(
                config,
                seed,
                ticks,
                claim,
                policies,
                learn,
                bar,
                threads=threads,
                report=report,
                command=command,
                **more,
            )
        except KeyboardInterrupt:
            stopped(bar.done, ticks, out)
    say(
        f"{ticks} ticks of {config.name}, seed {seed}, in {out}{numbers(result)}{kernels or ''}"
        f"{populations(out)}"
    )


def _given(**options: Any) -> dict[str, Any]:
    """Those options that are given."""
    return {name: value for name, value in options.items() if value is not None}


def run_in_bands(
    world: str,
    changes: list[str],
    ticks: int | None,
    seed: int | None,
    out: Path | None,
    quiet: bool,
    threads: int,
    learn: bool | None,
    policies: str,
    report: bool,
    checkpoint_every: int | None,
    keep: int,
    shown: tuple[int, bool] | None,
    record: str | None,
    divided: bool = False,
) -> None:
    """Run one world in all processes that mpiexec started; process 0 records it and prints. Where it is
    `divided`, each holds a part of it."""
    unwatched(shown)

    def build() -> Any:
        from ecs_eco.ecosystem import World

        return World.from_config(
            load(world, changes), seed=seed, policies=policies, threads=threads, learn=learn, record=False
        )

    def lead(prepare: Callable[[Any], None]) -> None:
        run_world(
            world,
            changes,
            ticks,
            seed,
            out,
            quiet,
            threads,
            learn,
            policies,
            report,
            checkpoint_every,
            keep,
            None,
            record,
            prepare=prepare,
        )

    in_all(lead, build, ticks, divided)


def resume_in_bands(
    folder: Path,
    until: int | None,
    forks: bool,
    quiet: bool,
    threads: int,
    report: bool,
    shown: tuple[int, bool] | None,
    divided: bool,
) -> None:
    """Resume a run in all processes that mpiexec started, however many it had before."""
    from ecs_eco.runs.run import read_manifest, world_at

    unwatched(shown)
    if forks:
        refuse(
            "--bands",
            "goes on with a run; a fork begins in one process",
            "",
            "resume without --from-tick, --set and --out",
        )
    manifest = read_manifest(folder)

    def build() -> Any:
        return world_at(folder, manifest, None, threads, lambda text: None, trust=False)

    def lead(prepare: Callable[[Any], None]) -> None:
        resume_run(folder, until, None, [], None, quiet, threads, report, prepare=prepare)

    in_all(lead, build, manifest["ticks"] if until is None else until, divided)


def unwatched(shown: tuple[int, bool] | None) -> None:
    """Refuse a viewer of a world in several processes."""
    if shown is not None:
        refuse(
            "--watch",
            "is not possible with --bands: what a page does reaches one process alone",
            "",
            "one of them; or watch the folder afterwards",
        )


def in_all(lead: Callable[..., None], build: Callable[[], Any], ticks: int | None, divided: bool) -> None:
    """Run a world in all processes; process 0 says what it exchanged."""
    from ecs_eco.bands.run import together

    led = together(lead, build, ticks, state=divided)
    if led is not None:
        bands = led[1]
        many, held = (
            (bands.processes, "each with its own part of the world")
            if divided
            else (bands.size, "the same world in all")
        )
        say(
            f"  {many} processes, {held}; process 0 received "
            f"{bands.traffic.received / 1e6:.1f} MB, and spent {bands.traffic.seconds:.1f} s exchanging and "
            "waiting"
        )


def _viewer(title: str, ticks: int, shown: tuple[int, bool] | None) -> Any:
    """The viewer of a run, or nothing."""
    if shown is None:
        return nullcontext()
    from ecs_eco.cli.watch import window

    return window(ticks, title, *shown)


def repeat_run(folder: Path, out: Path | None, quiet: bool, threads: int) -> None:
    """Repeat a recorded run and compare the digests; exits with code 1 if they differ."""
    from ecs_eco.runs.repeat import repeat

    with (
        nullcontext() if out is None else results(out, folder.name) as claim,
        progress(folder.name, quiet) as bar,
    ):
        result = repeat(folder, claim, bar, threads=threads)
    done = f"{result['ticks']} ticks of {result['world']} again, with {result['interventions']} interventions"
    if result["same"]:
        say(f"{done}: the same end, {result['digest'][:16]}")
        return
    complain(
        f"{done}: ANOTHER end, {result['digest'][:16]} instead of {result['recorded'][:16]}{result['why']}"
    )
    raise typer.Exit(FAILED)


def resume_run(
    folder: Path,
    until: int | None,
    from_tick: int | None,
    changes: list[str],
    out: Path | None,
    quiet: bool,
    threads: int,
    report: bool,
    shown: tuple[int, bool] | None = None,
    workers: int | None = None,
    on: str = LOCAL,
    prepare: Callable[[Any], None] | None = None,
) -> None:
    """Resume a run in its folder, or fork it into another; `shown` and `prepare` are as for a run."""
    from ecs_eco.runs.run import fork, read_manifest, resume

    forks = from_tick is not None or bool(changes) or out is not None
    if is_archipelago(folder):
        return resume_islands(folder, until, forks, quiet, threads, report, workers, on)
    if forks and out is None:
        fault = "is missing: a fork is recorded in a folder of its own"
        refuse("--out", fault, "", "a folder, new or empty")
    manifest, where = read_manifest(folder), out or folder
    title = manifest["config"].get("title") or folder.name
    with (
        nullcontext() if out is None else results(out, folder.name) as claim,
        _viewer(title, manifest["ticks"] if until is None else until, shown) as viewer,
        progress(folder.name, quiet) as bar,
    ):
        more: dict[str, Any] = {"threads": threads, "report": report, "complain": complain}
        more |= _given(prepare=prepare if viewer is None else viewer.open)
        try:
            if claim is not None:
                command = f"ecs-eco{portable.option()} resume {shlex.quote(str(folder))} --out DIR"
                command += " --trust" if manifest["config"].get("code") else ""
                command += "" if from_tick is None else f" --from-tick {from_tick}"
                command += "".join(f" --set {shlex.quote(change)}" for change in changes)
                result = fork(folder, claim, from_tick, changes, until, bar, command=command, **more)
            else:
                result = resume(folder, until, bar, **more)
        except KeyboardInterrupt:
            stopped(bar.done, bar.total, where)
    say(
        f"{result['done']} ticks of {result['world']}, seed {result['seed']}, "
        f"in {where}{numbers(result)}{populations(where)}"
    )


def train_world(
    world: str,
    changes: list[str],
    ticks: int | None,
    seed: int | None,
    out: Path | None,
    quiet: bool,
    on: str = LOCAL,
) -> None:
    """Pre-train the policies of a world into a folder, in this process or on another engine."""
    check_engine(on)
    config = load(world, changes)
    seed, ticks = config.seed if seed is None else seed, ticks or config.training.ticks
    if not any(species.policy.thinks for species in config.species.values()):
        refuse("WORLD", "no species has a policy to train", world, 'a world with policy.kind = "shared"')
    from ecs_eco.analysis.report.training import write_training
    from ecs_eco.experiments.pretraining import train_and_evaluate

    with (
        results(out, f"{config.name}-policies-{seed}") as claim,
        progress(f"training {config.name}", quiet) as bar,
    ):
        out = claim.path
        try:
            if on == LOCAL:
                result = train_and_evaluate(config, seed, ticks, out, bar)
            else:
                with engine(on, 1) as pool:
                    result = pool.submit(train_and_evaluate, config, seed, ticks, out.absolute()).result()
        except KeyboardInterrupt:
            stopped(bar.done, ticks, out)
    say(f"policies of {config.name}, {ticks} ticks, seed {seed}, in {out}{numbers(result)}")
    tell_training(result)
    shades = {name: species.color for name, species in config.species.items()}
    say(f"written: {write_training(result, out, shades)}")
    say(f"use them: ecs-eco run {world} --policies {out}")


def tell_training(result: dict[str, Any]) -> None:
    """Print how each species learnt, and how it does beside random policies."""
    from ecs_eco.analysis.page import number

    for name, of in result["learning"].items():
        cut = max(1, len(of["tick"]) // 10)
        ends = {
            w: [[v for v in part if v is not None] for part in (of[w][:cut], of[w][-cut:])]
            for w in ("reward", "entropy", "approx_kl", "explained_variance")
        }
        told = ", ".join(
            f"{w.replace('approx_kl', 'KL').replace('_', ' ')} "
            + " → ".join(number(sum(v) / len(v)) if v else "–" for v in both)
            for w, both in ends.items()
        )
        say(f"  {name}: {len(of['tick'])} updates; first to last tenth: {told}")
    for name, by_word in result["against_random"].items():
        for word, of in by_word.items():
            mean, low, high = of["difference"]
            sure = "" if low is None else f" ({number(low)} … {number(high)})"
            say(
                f"  {name}: {word} {number(of['trained'][0])}, random {number(of['random'][0])}, "
                f"difference {number(mean)}{sure}"
            )


def stopped(done: int, ticks: int, out: Path) -> None:
    """Ends a command after Ctrl-C."""
    manifest = out / "manifest.json"
    if manifest.is_file():
        done = json.loads(manifest.read_text(encoding="utf-8")).get("done", done)
    kept = f"what was recorded until then is in {out}" if manifest.is_file() else "nothing was recorded"
    if any((out / "checkpoints").glob("tick-*")):
        kept += f"; go on with: ecs-eco resume {out}"
    complain(f"Stopped at tick {done} of {ticks}; {kept}.")
    raise typer.Exit(INTERRUPTED)


def numbers(result: dict[str, Any]) -> str:
    """The times of a run, a line each."""
    return "".join(
        f"\n  {word.replace('_', ' ')}: {result[word]:.1f}" for word in result if word.endswith("_seconds")
    )


def populations(out: Path) -> str:
    """Whether all species persisted, which died out of what, the numbers of each species at the end of a run,
    and what was measured."""
    from ecs_eco.analysis.extinction import opening
    from ecs_eco.analysis.runs import load_series

    series = load_series(out)
    lines = [
        *opening(series),
        "at the end: "
        + ", ".join(f"{n:.0f} {name}" for name, n in zip(series.species, series.n[-1], strict=True)),
    ]
    if series.reporters:
        from ecs_eco.analysis import measures

        lines += measures.lines(series)
    return "".join(f"\n  {line}" for line in lines)
