"""The harness for study scripts: it runs the missing cases, stores each immediately, summarizes all of them
and writes the result.

A script states a claim and how to test it:

    STUDY = Study(name="cycles", claim="…", config={…}, cases=[{"arm": "trained", "seed": 1}, …],
                  run=run, summarise=summarise)

    if __name__ == "__main__":
        STUDY.main()

`run(config, case) -> dict` computes one case. `summarise(cases)` returns the verdicts: a list of verdict(…),
or a dict that also has "table" ({"head": […], "rows": [[…], …]}). `python -m studies.cycles` writes
studies/results/cycles.json; you can stop it at any moment, and the next call resumes the study. `--short` is
for CI: a few small cases, written to a separate file.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ecs_eco.engine.errors import ConfigError
from studies.common.provenance import commit, versions
from studies.common.registration import Registration

RESULTS = Path(__file__).parents[1] / "results"
Case = Mapping[str, Any]


def verdict(statement: str, value: Any, goal: str, met: bool) -> dict[str, Any]:
    """Return one verdict: the statement, the measured value, the goal, and whether the value meets the
    goal."""
    return {"statement": statement, "value": value, "goal": goal, "met": bool(met)}


def outcome(line: Mapping[str, Any]) -> str:
    """Return the outcome of a line: "reported" if it has no goal, otherwise "met" or "NOT MET"."""
    return "reported" if is_reported(line) else "met" if line["met"] else "NOT MET"


def is_reported(line: Mapping[str, Any]) -> bool:
    """Return whether a line has no goal and thus can neither pass nor fail."""
    return str(line["goal"]).startswith("reported")


@dataclass(frozen=True)
class Study:
    """A claim and the cases that test it; `short_*` defines the short form, which CI runs in seconds."""

    name: str
    claim: str
    config: dict[str, Any]
    cases: Sequence[Case]
    run: Callable[[dict[str, Any], Case], dict[str, Any]]
    summarise: Callable[[list[dict[str, Any]]], dict[str, Any] | list[dict[str, Any]]]
    short_cases: Sequence[Case] = field(default_factory=list)  # default: the first two cases
    short_config: dict[str, Any] = field(default_factory=dict)  # differences from config
    # the entries in config that a case depends on; default: all
    depends: Callable[[dict[str, Any], Case], Any] | None = None
    registered: Registration | None = None  # the registration, written before the first run

    def main(self, argv: Sequence[str] | None = None) -> None:
        """Run a study script's command line; exit with 1 if a case failed."""
        parser = argparse.ArgumentParser(prog=f"python -m studies.{self.name}", description=self.claim)
        parser.add_argument(
            "--short", action="store_true", help="a few small cases, for CI; writes to a temporary folder"
        )
        parser.add_argument(
            "--workers",
            type=int,
            metavar="N",
            help="number of cases to run in parallel, each in its own process (default: 1; on Ray, all its CPUs)",
        )
        parser.add_argument(
            "--on",
            default="local",
            metavar="ENGINE",
            help="run cases on: local (processes on this machine) or ray (a Ray cluster)",
        )
        parser.add_argument("--fresh", action="store_true", help="run all cases again")
        parser.add_argument(
            "--results", type=Path, metavar="DIR", help="folder for results (default: studies/results)"
        )
        asked = parser.parse_args(argv)
        if asked.workers is not None and asked.workers < 1:
            parser.error(f"--workers: expected 1 or more, got {asked.workers}")
        try:
            result = self.execute(
                short=asked.short,
                workers=asked.workers,
                fresh=asked.fresh,
                results=asked.results,
                executor=asked.on,
            )
        except ConfigError as error:
            parser.error(str(error))
        sys.exit(0 if result["complete"] else 1)

    def execute(
        self,
        *,
        short: bool = False,
        workers: int | None = None,
        fresh: bool = False,
        results: Path | None = None,
        executor: str | Executor = "local",
    ) -> dict[str, Any]:
        """Run the missing cases, write the result and return it; incomplete results remain in
        NAME.partial.json.

        `executor` is "local", "ray", or a custom executor.
        """
        config = self.whole_config() | (self.short_config if short else {})
        note = self.registered.note() if self.registered and not short else None
        cases = list(self.short_cases or self.cases[:2]) if short else list(self.cases)
        _check(self.name, cases)
        if results is None:
            results = Path(tempfile.mkdtemp(prefix="ecs-eco-study-")) if short else RESULTS
        path = results / f"{self.name}{'.short' if short else ''}.json"
        partial = path.with_suffix(".partial.json")
        wanted = {_key(case): case for case in cases}
        hashes = {key: self._hash(config, case) for key, case in wanted.items()}
        if fresh:  # written first: resumed, an interrupted run must not read the earlier result
            write_json(partial, self._record(config, [], short))
        done = _kept(partial if partial.is_file() else path, hashes)
        missing = [case for key, case in wanted.items() if key not in done]
        print(
            f"{self.name}: {self.claim}\n{len(cases)} cases, {len(cases) - len(missing)} finished → {path}",
            flush=True,
        )
        failed = 0
        origin = commit()
        for case, entry in _run_all(self.run, config, missing, workers, executor):
            if "error" in entry:
                failed += 1
                continue
            own = {} if self.depends is None else {"depends_hash": hashes[_key(case)]}
            done[_key(case)] = {"case": dict(case), **entry, **origin, **own}
            write_json(partial, self._record(config, [done[k] for k in wanted if k in done], short))
        record = self._record(config, [done[k] for k in wanted if k in done], short)
        if failed:
            print(
                f"{failed} of {len(cases)} cases failed; the finished cases are in {partial}", file=sys.stderr
            )
            return record
        record |= _conclude(self.summarise(list(record["cases"])))
        record["complete"] = True
        if note is not None:
            record["registration"] = note
        write_json(path, record)
        partial.unlink(missing_ok=True)
        for line in record["verdicts"]:
            print(f"{outcome(line):8} {line['statement']}: {line['value']} (goal: {line['goal']})")
        return record

    def whole_config(self) -> dict[str, Any]:
        """Return the configuration with the hash of the registration."""
        own = {} if self.registered is None else {"registered": self.registered.sha256}
        return {**self.config, **own}

    def whole_config_hash(self) -> str:
        """Return the hash of a result computed by the current code."""
        return config_hash(self.whole_config())

    def _hash(self, config: dict[str, Any], case: Case) -> str:
        """Return the sha256 of the configuration entries that a case depends on."""
        if self.depends is None:
            return config_hash(config)
        of = self.depends(config, case)
        own = None if self.registered is None else {"of": of, "registered": self.registered.sha256}
        return config_hash(own or of)

    def _record(self, config: dict[str, Any], entries: list[dict[str, Any]], short: bool) -> dict[str, Any]:
        return {
            "format": 1,
            "name": self.name,
            "claim": self.claim,
            "command": f"python -m studies.{self.name}" + (" --short" if short else ""),
            "short": short,
            "complete": False,
            "config_hash": config_hash(config),
            "config": config,
            "seeds": sorted({entry["case"]["seed"] for entry in entries if "seed" in entry["case"]}),
            "commits": sorted({entry["commit"] or "unknown" for entry in entries}),
            "dirty": any(entry["dirty"] for entry in entries),
            "versions": versions(),
            "seconds": round(sum(entry["seconds"] for entry in entries), 2),
            "cases": entries,
        }


def canonical(x: Any) -> str:
    """Return JSON with sorted keys and no spaces; raise a ValueError for unsupported values."""
    try:
        return json.dumps(x, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"JSON does not support this value: {error}; use numbers, strings, lists and dicts, and None "
            "for a missing number"
        ) from error


def config_hash(config: Mapping[str, Any]) -> str:
    """Return the sha256 of the canonical JSON of a configuration."""
    return hashlib.sha256(canonical(config).encode()).hexdigest()


def write_json(path: Path, content: Any) -> None:
    """Write a file atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    with open(beside, "w", encoding="utf-8") as file:
        file.write(json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
        file.flush()
        os.fsync(file.fileno())
    os.replace(beside, path)


def plain(x: Any) -> Any:
    """Return the value as JSON types: numpy scalars and arrays become numbers and lists; NaN and infinity
    become None."""
    if isinstance(x, Mapping):
        return {str(k): plain(v) for k, v in x.items()}
    if isinstance(x, list | tuple):
        return [plain(v) for v in x]
    if hasattr(x, "tolist"):
        return plain(x.tolist())
    if isinstance(x, float) and not math.isfinite(x):
        return None
    return x


def _check(name: str, cases: Sequence[Case]) -> None:
    if not cases:
        raise ValueError(f"study {name!r} has no cases")
    seen: set[str] = set()
    for case in cases:
        if _key(case) in seen:
            raise ValueError(f"study {name!r} has the case {dict(case)} twice")
        seen.add(_key(case))


def _key(case: Case) -> str:
    return canonical(dict(case))


def _kept(path: Path, hashes: Mapping[str, str]) -> dict[str, dict[str, Any]]:
    """Return a file's finished cases by key, if they are still needed and their hash is unchanged."""
    if not path.is_file():
        return {}
    record = json.loads(path.read_text(encoding="utf-8"))
    entries = {_key(entry["case"]): entry for entry in record["cases"]}
    return {
        key: entry
        for key, entry in entries.items()
        if hashes.get(key) == entry.get("depends_hash", record.get("config_hash"))
    }


def _conclude(summary: Any) -> dict[str, Any]:
    out = {"verdicts": summary} if isinstance(summary, list) else dict(summary)
    out = plain(out)
    needed = ("statement", "value", "goal", "met")
    allowed = (*needed, "registered")
    for line in out.get("verdicts", []):
        for key in line:
            if key not in allowed:
                near = get_close_matches(key, allowed, 1)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                raise ValueError(
                    f"verdict {line!r}: unknown key {key!r}; expected {', '.join(allowed)}{hint}"
                )
        if lacking := set(needed) - set(line):
            raise ValueError(f"verdict {line!r} lacks {', '.join(sorted(lacking))}")
    if not out.get("verdicts"):
        raise ValueError('summarise() must return at least one verdict("statement", value, "goal", met)')
    return out


def _one(run: Callable[..., Any], config: dict[str, Any], case: Case) -> dict[str, Any]:
    """Run one case in this process; return the result and duration [s], or the error text."""
    start = time.perf_counter()
    try:
        result = plain(run(config, case))
        canonical(result)
    except Exception:
        return {"error": traceback.format_exc()}
    return {"result": result, "seconds": round(time.perf_counter() - start, 3)}


def _run_all(
    run: Callable[..., Any],
    config: dict[str, Any],
    cases: Sequence[Case],
    workers: int | None,
    executor: str | Executor,
) -> Iterator[tuple[Case, dict[str, Any]]]:
    """Yield (case, entry) as cases finish, with a progress bar that shows finished cases, rate and remaining
    time."""
    if not cases:
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    start = time.perf_counter()
    with Progress(*columns) as progress:
        task = progress.add_task("cases", total=len(cases), rate="")
        for count, (case, entry) in enumerate(_each(run, config, cases, workers, executor), 1):
            if "error" in entry:
                progress.console.print(
                    f"case {dict(case)} failed:\n{entry['error']}", markup=False, highlight=False
                )
            rate = count / (time.perf_counter() - start)
            progress.update(task, advance=1, rate=f"{rate:.2f}/s" if rate > 1 else f"{1 / rate:.1f} s each")
            yield case, entry


def _each(
    run: Callable[..., Any],
    config: dict[str, Any],
    cases: Sequence[Case],
    workers: int | None,
    executor: str | Executor,
) -> Iterator[tuple[Case, dict[str, Any]]]:
    """Yield (case, entry) as cases finish."""
    from ecs_eco.lab.executors import engine
    from ecs_eco.lab.work import completed

    with engine(executor, 1 if executor == "local" and workers is None else workers) as pool:
        for i, future in completed(pool, {i: (_one, run, config, case) for i, case in enumerate(cases)}):
            error = future.exception()
            yield cases[i], ({"error": f"the worker died: {error}"} if error else future.result())
