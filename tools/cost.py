"""The cost of a tick, fitted to benchmarks: a fixed part and a part per organism."""

from typing import Any, NamedTuple

import numpy as np
from cells import table
from fields import BENCHMARKS, read_result

MEMORY = "memory"
FITS = {  # name: (result, column with the number of organisms, rows, label)
    "animals": ("animals", "animals", {"threads": 1}, "animals, one core"),
    "animals_threads": ("animals_threads", "animals", {"threads": 2}, "animals, two threads"),
    "animals_learning": ("animals_learning", "animals", {"threads": 1}, "animals that learn, one core"),
    "plants": ("plants", "plants", {}, "plants that grow and spread, one core"),
}


class Cost(NamedTuple):
    """A total cost of `fixed + each * n`, and the fit's largest relative error."""

    fixed: float
    each: float
    error: float

    def at(self, n: int) -> float:
        """Return the total for n organisms."""
        return self.fixed + self.each * n


def fit(n: list[float], total: list[float]) -> Cost:
    """Fit a line to totals over n by least squares of relative errors."""
    y = np.asarray(total, float)
    design = np.column_stack([1 / y, np.asarray(n, float) / y])
    (fixed, each), *_ = np.linalg.lstsq(design, np.ones(len(y)), rcond=None)
    error = np.abs(design @ [fixed, each] - 1).max()
    return Cost(float(fixed), float(each), float(error))


def of_ticks(name: str) -> Cost:
    """Return the fitted cost of a tick [ms] for one result."""
    result, organisms, wanted, _ = FITS[name]
    rows = [row for row in rows_of(result) if wanted.items() <= row.items()]
    n = [row[organisms] for row in rows]
    per = f"ns per {organisms.removesuffix('s')} per tick"
    return fit(n, [row[organisms] * row[per] * 1e-6 for row in rows])


def of_memory() -> Cost:
    """Return a process's memory [B] on one thread without learning."""
    rows = rows_of("animals_pairs") + rows_of("animals_pairs_million")
    alike = [row for row in rows if row["threads"] == 1 and not row["learning"]]
    return fit([row["animals"] for row in alike], [row["GiB now"] * 2**30 for row in alike])


def number(name: str, part: str) -> str:
    """Return part of a cost as text: "fixed" [ms or MiB], "each" [µs or B], or "rate N" [ticks/s at N]."""
    if name == MEMORY:
        cost = of_memory()
        return f"{cost.fixed / 2**20:.0f}" if part == "fixed" else f"{cost.each:,.0f}"
    cost = of_ticks(name)
    if part.startswith("rate"):
        rate = 1e3 / cost.at(int(part.removeprefix("rate")))
        return f"{float(f'{rate:.2g}'):,.0f}"
    return f"{cost.fixed:.2g}" if part == "fixed" else f"{1e3 * cost.each:.2g}"


def costs() -> str:
    """Return a table of all fits."""
    head = ["a tick of", "fixed [ms]", "each [µs]", "error", "10,000 [ticks/s]", "1,000,000 [ticks/s]"]
    return table(
        head,
        [
            [
                words,
                number(name, "fixed"),
                number(name, "each"),
                f"{of_ticks(name).error:.0%}",
                number(name, "rate 10000"),
                f"{1e3 / of_ticks(name).at(1_000_000):.2g}",
            ]
            for name, (_, _, _, words) in FITS.items()
        ],
    )


def rows_of(name: str) -> list[dict[str, Any]]:
    """Return a result's rows."""
    return list(read_result(BENCHMARKS, name)["rows"])
