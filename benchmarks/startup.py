"""Measure commands as complete processes: `--help`, and a run of 100 ticks with and without compiled kernels.

python benchmarks/startup.py
"""

import compileall
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()


def seconds(arguments: list[str], cache: Path) -> float:
    """Run one command in a separate process and return its wall-clock time [s]."""
    environment = os.environ | {"ECS_ECO_CACHE": str(cache)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # users have cached bytecode
    start = time.perf_counter()
    subprocess.run(
        [sys.executable, "-c", "from ecs_eco.cli import main; main()", *arguments],
        check=True,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    return time.perf_counter() - start


def main() -> None:
    """Time each command several times; the first run compiles into an empty cache."""
    rows = []
    compileall.compile_dir(Path(__file__).parents[1] / "ecs_eco", quiet=2)  # as pip does during installation
    with tempfile.TemporaryDirectory() as folder:
        cache, out = Path(folder) / "cache", Path(folder) / "run"
        for arguments, goal in (
            (["--help"], 0.3),
            (["list"], 0.3),
            (["run", "predator-prey", "--ticks", "100", "--out", str(out)], 4.0),
        ):
            times = []
            for _ in range(6):
                times.append(seconds(arguments, cache))
                shutil.rmtree(out, ignore_errors=True)
            rows.append(
                {
                    "command": "ecs-eco " + " ".join(arguments[:4]),
                    "first start [s]": times[0],
                    "later, median [s]": statistics.median(times[1:]),
                    "later, minimum [s]": min(times[1:]),
                    "goal [s]": goal,
                }
            )
        compiled = len(list(cache.rglob("*.nbc")))
    _bench.save(
        "startup", "Commands as complete processes", rows, {"kernels compiled by the first run": compiled}
    )


if __name__ == "__main__":
    main()
