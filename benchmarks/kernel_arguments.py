"""Measure the cost of calling a kernel from Python for each form of arguments.

    python benchmarks/kernel_arguments.py [--rounds 40]

Each kernel reads only the first number of each array, so nearly all of the time is spent on the call. The
same arrays are passed individually, in named tuples that numba unpacks, in plain tuples, in named tuples
whose fields Python passes (`ecs_eco.compiled.views`), and as records that contain addresses. `made` is the
time it takes to create all arguments once from existing arrays. Each form is timed in turn, and the shortest
time counts.
"""

import argparse
import sys
import timeit
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

import numba
import numpy as np

from ecs_eco import njit
from ecs_eco.engine.addresses import address_of, column_at

CALLS = 2000
SHAPES = ((1, 6), (3, 6), (5, 6), (4, 10))  # number of views, and arrays per view


def written(source: str, **names: Any) -> Any:
    """Return the `read` function defined by some source code."""
    exec(source, names)
    return names["read"]


def forms(views: int, each: int) -> dict[str, tuple[Callable[[], Any], Callable[[], Any]]]:
    """Return, for each form of arguments, a kernel call with `views` times `each` arrays and a function that
    creates its arguments."""
    fields, numbers = [f"a{k}" for k in range(each)], range(views)
    arrays = [np.arange(8, dtype=(np.float32, np.int64)[k % 2]) for k in range(views * each)]
    groups = [arrays[v * each : (v + 1) * each] for v in numbers]
    View: Any = NamedTuple(f"View{views}x{each}", [(field, np.ndarray) for field in fields])
    parameters = ", ".join(f"v{v}" for v in numbers)
    total = " + ".join(f"v{v}.{field}[0]" for v in numbers for field in fields)
    loose = ", ".join(f"v{v}_{field}" for v in numbers for field in fields)
    plain = " + ".join(f"v{v}[{k}][0]" for v in numbers for k in range(each))
    noted = ", ".join(f"v{v}: View" for v in numbers)
    of_record = " + ".join(f"column_at(v{v}[0].a{k}, f{k % 2}, 8)[0]" for v in numbers for k in range(each))
    record = np.dtype([(field, np.uint64) for field in fields])
    kinds = {"column_at": column_at, "f0": np.float32, "f1": np.int64}
    one_by_one = njit(written(f"def read({loose}):\n    return {total.replace('.', '_')}"))
    by_numba = numba.njit(written(f"def read({parameters}):\n    return {total}"))
    by_tuples = numba.njit(written(f"def read({parameters}):\n    return {plain}"))
    by_views = njit(written(f"def read({noted}):\n    return {total}", View=View))
    by_records = numba.njit(written(f"def read({parameters}):\n    return {of_record}", **kinds))

    def named() -> list[Any]:
        return [View(*group) for group in groups]

    def tuples() -> list[Any]:
        return [tuple(group) for group in groups]

    def records() -> list[Any]:
        return [np.array([tuple(map(address_of, group))], record) for group in groups]

    views_, tuples_, records_ = named(), tuples(), records()
    return {
        "separate arrays": (lambda: one_by_one(*arrays), lambda: None),
        "named tuples, passed by numba": (lambda: by_numba(*views_), named),
        "plain tuples, passed by numba": (lambda: by_tuples(*tuples_), tuples),
        "fields of named tuples": (lambda: by_views(*views_), named),
        "records of addresses": (lambda: by_records(*records_), records),
    }


def least(work: Callable[[], Any]) -> float:
    """Return the shortest duration [µs] of many calls."""
    return timeit.timeit(work, number=CALLS) / CALLS * 1e6


def main() -> None:
    """Time all forms in turn."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--rounds", type=int, default=40)
    rounds = parser.parse_args().rounds
    rows = []
    for views, each in SHAPES:
        of = forms(views, each)
        for call, make in of.values():
            call(), make()
        times = {form: ([], []) for form in of}
        for _ in range(rounds):
            for form, works in of.items():
                for into, work in zip(times[form], works, strict=True):
                    into.append(least(work))
        rows += [
            {
                "arrays": f"{views} × {each}",
                "form": form,
                "per call [µs]": round(min(call), 2),
                "to create the arguments [µs]": "" if form == "separate arrays" else round(min(made), 2),
            }
            for form, (call, made) in times.items()
        ]
    _bench.save("kernel_arguments", "The cost of a kernel call, by the form of its arguments", rows)


if __name__ == "__main__":
    main()
