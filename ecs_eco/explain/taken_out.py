"""Take an allele out of a random half of its carriers, in forks of a recorded run, and compare both halves.

Both halves live in the same worlds, so they share all conditions; only the change and the random draws of
individual organisms differ.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Collection, Generator, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from safetensors.numpy import load_file

from ecs_eco.analysis.compare import clean
from ecs_eco.analysis.runs import load_series
from ecs_eco.analysis.seed_grid import mean_of_known
from ecs_eco.analysis.survival import Interval
from ecs_eco.compiled import portable
from ecs_eco.components import Policy
from ecs_eco.ecosystem import World
from ecs_eco.engine import files
from ecs_eco.engine.arguments import called_with, whole_number
from ecs_eco.engine.errors import ForeignFile, RecordingError
from ecs_eco.engine.hooks import listening
from ecs_eco.engine.processes import python
from ecs_eco.engine.table import Table
from ecs_eco.engine.versions import versions
from ecs_eco.explain.edits import AlleleLike, Edit, edit_of
from ecs_eco.explain.followed import SPARSE, Followed
from ecs_eco.inputs.section import Section
from ecs_eco.inputs.trust import allow
from ecs_eco.lab import slurm
from ecs_eco.lab.executors import LOCAL, SLURM, engine as engine_of, prepare
from ecs_eco.lab.work import completed
from ecs_eco.life.reconfigure import reseed
from ecs_eco.record import checkpoint, container, freeze as frozen, seal
from ecs_eco.runs.requests import repeat_requests
from ecs_eco.runs.run import near

FOLDER = "explain"  # in the run's folder
FORMAT = 2
POLL = 5.0  # [s] between looks at the queue of SLURM
CONTRASTS: dict[int, dict[str, tuple[int, ...]]] = {
    2: {"first": (-1, 1)},
    4: {
        "first": (-1, 1, 0, 0),
        "second": (-1, 0, 1, 0),
        "both": (-1, 0, 0, 1),
        "interaction": (1, -1, -1, 1),
    },
}
"""Weights of the groups: neither changed, first change, second change, both."""

Weights = dict[int, np.ndarray]


class Fork(Section):
    """The contents of a fork's file."""

    fork: int
    lasted: int
    n: list[int]
    means: dict[str, list[float | None]]
    doses: dict[int, dict[str, list[float | None]]]


@dataclass(frozen=True)
class TakenOut:
    """The effect of a change on organisms, measured in forks of one run at one tick.

    Attributes
    ----------
    edits : tuple of Edit
        One change, or two for a 2 × 2 comparison.
    tick : int
        Tick of the forks.
    lasted : array of int64, shape (forks,)
        Number of ticks that each fork ran.
    n : array of int64, shape (forks, groups)
        Number of organisms: unchanged and changed; for two changes, with neither, the first, the second and both.
    means : dict of str to array of float64, shape (forks, groups)
        Means per organism, from the change to death or the end of the fork: "births" (an offspring counts for
        each of its parents), "survival" [ticks], "alive" (at the end, a share), "died: CAUSE" (a share),
        "energy" (taken in), "meals: SPECIES" (organisms killed for food), "action: NAME" (share of decisions;
        for a continuous action, its mean).
    doses : dict of int to dict
        The same means by the number of strings or copies changed, if it differs between organisms.
    """

    edits: tuple[Edit, ...]
    tick: int
    lasted: np.ndarray
    n: np.ndarray
    means: dict[str, np.ndarray]
    doses: dict[int, dict[str, np.ndarray]]

    def effect(self, measure: str = "births", of: str = "first", dose: int | None = None) -> Interval:
        """Return the mean over forks of a difference between groups, with its 95% interval (Student's t).

        Parameters
        ----------
        measure : str, default "births"
            A key of `means`.
        of : {"first", "second", "both", "interaction"}
            The change whose effect is returned. "interaction" is the effect of both changes minus the sum of
            their separate effects.
        dose : int, optional
            Only organisms in which this number of strings or copies changes.

        Returns
        -------
        Interval
            Value, low, high; NaN if there are no such organisms.

        Examples
        --------
        >>> import numpy as np
        >>> from ecs_eco.explain import Edit, TakenOut
        >>> red, births = Edit("goat", "letter", "red", 0, "T", "A"), np.array([[2.0, 1.5], [2.0, 1.3]])
        >>> taken = TakenOut((red,), 500, np.full(2, 90), np.full((2, 2), 40), {"births": births}, {})
        >>> round(taken.effect("births").value, 3), round(taken.effect("births").low, 3)
        (-0.6, -1.871)
        """
        weights = np.array(CONTRASTS[self.n.shape[1]][of], np.float64)
        return mean_of_known((self._of(dose)[measure] @ weights)[None])

    def control(self, measure: str = "births", dose: int | None = None) -> Interval:
        """Return the mean of the unchanged organisms over forks, with its 95% interval."""
        return mean_of_known(self._of(dose)[measure][None, :, 0])

    def to_pandas(self) -> Any:
        """Return a pandas.DataFrame with a row for each measure, contrast and dose (0: all organisms)."""
        return pa.Table.from_pylist(
            [
                {
                    "measure": measure,
                    "of": of,
                    "dose": dose or 0,
                    "control": self.control(measure, dose).value,
                }
                | dict(zip(("effect", "low", "high"), self.effect(measure, of, dose), strict=True))
                for dose in (None, *self.doses)
                for measure in self._of(dose)
                for of in CONTRASTS[self.n.shape[1]]
            ]
        ).to_pandas()

    def _of(self, dose: int | None) -> dict[str, np.ndarray]:
        return self.means if dose is None else self.doses[dose]


def take_out(
    run: str | Path,
    allele: AlleleLike | Sequence[AlleleLike],
    was: str | Sequence[str] | None = None,
    *,
    tick: int | None = None,
    forks: int = 24,
    ticks: int | None = None,
    seed: int = 0,
    reverse: bool = False,
    workers: int | None = None,
    engine: str | Executor = LOCAL,
    progress: Callable[[int, int], None] | None = None,
    trust: bool = False,
) -> TakenOut:
    """Take an allele out of a random half of its carriers in forks of a run; compare them with the other half.

    Parameters
    ----------
    run : str or Path
        Folder of a recorded run.
    allele : Edit, or any object with `species`, `kind`, `gene`, `locus` and `value`
        The allele; see `Edit`. For two alleles, the carriers of both are divided into four groups: unchanged,
        without the first, without the second, without both.
    was : str, optional
        What replaces the allele; default: the most common alternative among the living. Two for two alleles.
    tick : int, optional
        Tick of the forks; default: the newest checkpoint. The run is repeated from the last checkpoint before
        it, or from its start.
    forks : int, default 24
        Number of forks. Each has its own seed and its own random half.
    ticks : int, optional
        Maximum length of a fork; default: the length of the run. A fork ends when all these organisms are dead.
    seed : int, default 0
        Fixes the random draws of all forks.
    reverse : bool, default False
        Whether the allele is put into a random half of the organisms without it instead.
    workers, engine
        As for `ecs_eco.lab.executors.engine`, or "slurm"; results do not depend on them.
    progress : callable, optional
        Called with the number of finished forks and the number of forks.
    trust : bool, default False
        Whether the run's own code is allowed to run.

    Returns
    -------
    TakenOut

    Raises
    ------
    ValueError
        If the change is impossible, or fewer organisms than groups can be changed.
    RecordingError, CheckpointError
        If the run cannot be repeated here, or a fork's file is damaged.
    ForeignFile
        If a link leads out of the run's folder, or a file contains another fork.

    Notes
    -----
    Each fork writes one file to `RUN/explain/`, so a call that was stopped continues where it was. All forks
    begin with the same organisms, so the intervals describe this population at this tick, not other populations
    or runs. Changed and unchanged organisms compete in the same worlds, so a change of all organisms can have a
    different effect.

    Examples
    --------
    >>> from ecs_eco.explain import Edit, take_out
    >>> from ecs_eco.runs.run import run_to_folder
    >>> manifest = run_to_folder("reflexes", seed=1, ticks=5, out="goats", report=False)
    >>> red = Edit("goat", "letter", gene="red", locus=0, value="T")
    >>> taken = take_out("goats", red, "A", forks=2, ticks=3, workers=1)
    >>> taken.lasted.tolist(), taken.effect("survival").value <= 3
    ([3, 3], True)
    """
    called_with("progress", progress, "done", "forks")
    run = Path(run).absolute()  # workers on other machines have other working directories
    manifest = _manifest(run)
    tick = _tick(run, manifest, tick)
    world, base = world_at(run, manifest, tick, trust)
    edits = _edits(world, allele, was, reverse)
    known = _weights_at_birth(base, edits)
    if known is not None:
        _keep_birth_weights(run, manifest, world, edits[0].species, known, trust)
    n = _candidates(world.table(edits[0].species), edits, _read_weights(known))[0].size
    if n < 2 ** len(edits):
        raise ValueError(
            f"{run}: {n} living {edits[0].species} can be changed at tick {tick}; "
            f"expected {2 ** len(edits)} or more"
        )
    most = whole_number("ticks", manifest["done"] if ticks is None else ticks, 1)
    what = [FORMAT, manifest.get("id"), versions(), portable.mode(), [*map(asdict, edits)], tick, most, seed]
    place = run / FOLDER / hashlib.sha256(json.dumps(what).encode()).hexdigest()[:16]
    place.mkdir(parents=True, exist_ok=True)
    files.write_json(place / "what.json", what)
    outs = [_file(place, i) for i in range(whole_number("forks", forks, 1))]
    allowed = [source.sha256 for source in world.config._code.sources if world.config._code.allowed]
    missing = [i for i, out in enumerate(outs) if not out.exists()]
    with closing(
        _on_slurm(place, missing, allowed, workers)
        if engine == SLURM or not missing
        else _on_executor(engine_of(engine, workers), place, world, missing, allowed)
    ) as finished:
        for done, _ in enumerate(finished, len(outs) - len(missing) + 1):
            if progress is not None:
                progress(done, len(outs))
    return _collected(place, edits, tick, [seal.read_sealed(place, out.name, Fork) for out in outs])


def driver(taken: Sequence[TakenOut], measure: str = "births") -> TakenOut | None:
    """Return which of several linked alleles, each taken out separately, has the largest effect on a measure.

    Parameters
    ----------
    taken : sequence of TakenOut
        One for each allele.
    measure : str, default "births"

    Returns
    -------
    TakenOut or None
        None if all intervals contain 0 or, for births, if no allele clearly raises them.

    Notes
    -----
    Only effects whose interval excludes 0 count and, for births, only alleles that raise them. The largest
    effect may not differ significantly from the second largest.

    Examples
    --------
    >>> import numpy as np
    >>> from ecs_eco.explain import Edit, TakenOut, driver
    >>> births = {"T": np.array([[0.9, 0.2], [1.0, 0.4]]), "G": np.array([[0.9, 1.0], [1.0, 0.9]])}
    >>> taken = [
    ...     TakenOut((Edit("goat", "letter", "red", 0, letter),), 9, 0 * n[:, 0], 0 * n, {"births": n}, {})
    ...     for letter, n in births.items()
    ... ]
    >>> driver(taken).edits[0].value
    'T'
    """
    found = [one for one in taken if clear(one.effect(measure))]
    if measure == "births":
        found = [one for one in found if (one.effect().value > 0) == one.edits[0].reverse]
    return max(found, key=lambda one: abs(one.effect(measure).value), default=None)


def clear(x: Interval) -> bool:
    """Return whether an interval excludes 0; False if there is none."""
    return x.low > 0 or x.high < 0


# --- the world to fork --------------------------------------------------------------------------------------


def _manifest(run: Path) -> dict[str, Any]:
    manifest = seal.read_manifest(run)
    container.inside(run, run / FOLDER)
    if "island" in manifest:
        raise ValueError(
            f"{run}: is an island of an archipelago, which cannot be forked: its immigrants would be missing"
        )
    return manifest


def _tick(run: Path, manifest: dict[str, Any], tick: int | None) -> int:
    if tick is None:
        known = run.glob(f"checkpoints/tick-*{checkpoint.SUFFIX}")
        return max(map(checkpoint.tick_of, known), default=manifest["done"])
    return whole_number("tick", tick, 0, manifest["done"])


def world_at(run: Path, manifest: dict[str, Any], tick: int, trust: bool = False) -> tuple[World, Path]:
    """Return the world of a run at the start of a tick, and the checkpoint in `RUN/explain/` that contains it.

    The run is repeated from its last checkpoint at or before the tick, or from its start. Raises
    RecordingError if the repetition differs from the record.
    """
    base = run / FOLDER / checkpoint.name_of(tick)
    if base.exists() and checkpoint.describe(base).get("run", {}).get("id") == manifest.get("id"):
        return World.restore(base, record=False, trust=trust), base
    world: World = near(run, manifest, tick, trust)
    _repeat(world, manifest, tick)
    series = load_series(run)
    for row in np.flatnonzero(series.ticks == tick - 1).tolist():
        here = [world.table(name).n for name in series.species]
        if here != (recorded := series.n[row].tolist()):
            raise RecordingError(
                f"{run}: repeated to tick {tick}, it has {here} organisms ({', '.join(series.species)}); recorded: "
                f"{recorded}. Check it with: ecs-eco repeat {run}"
            )
    meta, arrays = frozen.freeze(world)
    checkpoint.write(base, meta | {"run": {"id": manifest.get("id")}}, arrays)
    return world, base


def _repeat(world: World, manifest: dict[str, Any], tick: int) -> None:
    """Run a world up to a tick as in its recording."""
    with listening(world.before_tick, lambda: repeat_requests(world, manifest)):
        world.run(tick - world.tick)


def _keep_birth_weights(
    run: Path, manifest: dict[str, Any], world: World, species: str, out: Path, trust: bool
) -> None:
    """Write the weights with which the living members of a species were born, by repeating their births."""
    table = world.table(species)
    if out.exists() or Policy not in table or not table.n:
        return
    living = table.uid[table.by_uid()]
    again: World = near(run, manifest, int(table.born[table.rows()].min()), trust)
    weights: Weights = {}

    def note(of: Table, rows: np.ndarray, *_: object) -> None:
        if of.name == species:
            some = rows[np.isin(of.uid[rows], living)]
            weights.update(zip(of.uid[some].tolist(), of[Policy].weights[some], strict=True))

    there = again.table(species)
    rows = there.rows()
    note(there, rows[there.born[rows] == again.tick])
    with listening(again.on_birth, note):
        _repeat(again, manifest, world.tick)
    arrays = {"uid": np.array(list(weights), np.uint64), "weights": np.stack(list(weights.values()))}
    files.write_tensors(out, arrays, {})


def _read_weights(path: Path | None) -> Weights | None:
    if path is None or not path.exists():
        return None
    files.require_regular(path)
    arrays = load_file(path)
    return dict(zip(arrays["uid"].tolist(), arrays["weights"], strict=True))


def _weights_at_birth(base: Path, edits: Sequence[Edit]) -> Path | None:
    """Return the file of weights at birth for a checkpoint; None if no edit needs it."""
    if not any(edit.kind == "policy" for edit in edits):
        return None
    return base.with_name(f"{base.stem}-born-{edits[0].species}.safetensors")


def _edits(
    world: World, allele: AlleleLike | Sequence[AlleleLike], was: str | Sequence[str] | None, reverse: bool
) -> tuple[Edit, ...]:
    alleles = list(allele) if isinstance(allele, Sequence) else [allele]
    before = [was] * len(alleles) if was is None or isinstance(was, str) else list(was)
    if not 1 <= len(alleles) <= 2 or len(before) != len(alleles) or len({a.species for a in alleles}) > 1:
        raise ValueError(
            f"{len(alleles)} alleles and {len(before)} replacements; expected 1 or 2 of one species"
        )
    table = world.table(alleles[0].species)
    made = []
    for one, word in zip(alleles, before, strict=True):
        word = word or getattr(one, "was", "")
        edit = edit_of(one, word, reverse)
        made.append(edit_of(one, word or ("" if reverse else edit.alternative(table)), reverse))
    return tuple(made)


def _candidates(table: Table, edits: Sequence[Edit], known: Weights | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows i64[n] of the organisms to which all changes apply, in uid order, and the number of
    strings or copies that the first one changes."""
    rows, dose = edits[0].carriers(table, known)
    for edit in edits[1:]:
        both = np.isin(rows, edit.carriers(table, known)[0])
        rows, dose = rows[both], dose[both]
    return rows, dose


# --- one fork -----------------------------------------------------------------------------------------------


def _on_executor(
    executor: AbstractContextManager[Executor],
    place: Path,
    world: World,
    numbers: Sequence[int],
    allowed: Sequence[str],
) -> Generator[int, None, None]:
    """Run forks on an executor; yield their numbers as they end."""
    with executor as pool:
        prepare(pool, place, world.config)
        for number, future in completed(pool, {n: (run_fork, place, n, allowed) for n in numbers}):
            future.result()
            yield number


def _on_slurm(
    place: Path, numbers: Sequence[int], allowed: Sequence[str], workers: int | None
) -> Generator[int, None, None]:
    """Run forks as tasks of SLURM arrays; yield their numbers as they end. Tasks that an earlier call has
    submitted are not submitted again."""
    task = (  # a fork has no checkpoint: at its time limit, it fails and is not queued again
        "import signal; signal.signal(signal.SIGTERM, lambda *_: sys.exit(1)); "
        "from ecs_eco.explain.taken_out import Path, run_fork; "
        "run_fork(Path(sys.argv[1]), int(sys.argv[-1]), sys.argv[2:-1])"
    )
    jobs = slurm.Jobs(f"ecs-eco-{place.name}", place / slurm.FOLDER, python(task, str(place), *allowed))
    if numbers:
        waiting, options = slurm.queued_jobs(jobs), slurm.Options(limit=workers or slurm.Options.limit)
        slurm.submit_jobs(jobs, [n for n in numbers if n not in waiting], options)
    left, empty = list(numbers), 0
    while left:
        empty = 0 if slurm.queued_jobs(jobs) else empty + 1
        ended = [n for n in left if _file(place, n).exists()]
        left = [n for n in left if n not in ended]
        yield from ended
        if left and empty > 2:  # file servers show new files late
            raise RecordingError(f"{len(left)} forks ended without a result: see the logs in {jobs.place}")
        time.sleep(POLL if left else 0)


def _file(place: Path, number: int) -> Path:
    return place / f"fork-{number:04d}.json"


def run_fork(place: Path, number: int, allowed: Collection[str] = ()) -> None:
    """Fork a checkpoint, change a random part of the organisms, follow all of them, and write their means,
    unless another process has. `place` contains what.json."""
    out = _file(place, number)
    if out.exists():
        return
    allow(allowed)
    run, (*_, changes, tick, ticks, seed) = place.parents[1], files.read_json(place / "what.json")
    base, edits = place.with_name(checkpoint.name_of(tick)), tuple(Edit(**change) for change in changes)
    world, weights = World.restore(base, record=False), _read_weights(_weights_at_birth(base, edits))
    rng = np.random.default_rng([seed, number])
    reseed(world, int(rng.integers(2**31)))
    table = world.table(edits[0].species)
    rows, dose = _candidates(table, edits, weights)
    group = rng.permutation(rows.size) % 2 ** len(edits)
    followed = Followed(world, table, table.uid[rows])
    for bit, edit in enumerate(edits):
        edit.apply(table, rows[group >> bit & 1 == 1], weights)
    followed.run(ticks, {"asked": seal.read_manifest(run).get("asked", [])})
    size = 2 ** len(edits)
    doses = {} if len(edits) > 1 or np.unique(dose).size < 2 else {int(d): dose == d for d in np.unique(dose)}
    result = {
        "fork": number,
        "lasted": world.tick - followed.start,
        "n": np.bincount(group, minlength=size).tolist(),
        "means": followed.means(group, size),
        "doses": {d: followed.means(np.where(some, group, -1), size) for d, some in doses.items()},
    }
    seal.write_manifest(place, clean(result), out.name)


def _collected(place: Path, edits: tuple[Edit, ...], tick: int, forks: Sequence[dict[str, Any]]) -> TakenOut:
    groups = 2 ** len(edits)
    if wrong := [
        number
        for number, fork in enumerate(forks)
        if fork["fork"] != number
        or {
            len(of)
            for part in (fork["means"], *fork["doses"].values(), {"": fork["n"]})
            for of in part.values()
        }
        != {groups}
    ]:
        raise ForeignFile(f"{_file(place, wrong[0])}: contains another fork; remove it to run this one")

    def tables(parts: Sequence[dict[str, Any]]) -> dict[str, np.ndarray]:
        names = sorted(dict.fromkeys(name for part in parts for name in part), key=_order)
        return {
            name: np.array(
                [
                    part.get(name, [0.0 if part and name.startswith(SPARSE) else None] * groups)
                    for part in parts
                ],
                np.float64,
            )
            for name in names
        }

    doses = sorted({int(dose) for fork in forks for dose in fork["doses"]})
    return TakenOut(
        edits,
        tick,
        np.array([fork["lasted"] for fork in forks]),
        np.array([fork["n"] for fork in forks]),
        tables([fork["means"] for fork in forks]),
        {dose: tables([fork["doses"].get(str(dose), {}) for fork in forks]) for dose in doses},
    )


def _order(name: str) -> int:
    return "births survival alive died energy meals action".find(name.partition(":")[0])
