"""Write ecs_eco/worlds/kernels.txt, the list of kernels that the shipped worlds call, with their types.

    python tools/make_kernels.py [--check]

At the first start, a second process compiles the kernels on this list, so a slightly outdated list costs only
a little time. `--check` therefore tests whether its lines are readable and most of its kernels exist.
"""

import json
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from ecs_eco.compiled import signatures
from ecs_eco.compiled.kernel import Kernel
from ecs_eco.worlds.first_start import LIST, kernel_of

TICKS = 100
CALLS = """
import json, sys, tempfile
from pathlib import Path
from ecs_eco.config import load
from ecs_eco.compiled import signatures
from ecs_eco.compiled.kernel import Kernel
from ecs_eco.runs.run import run_to_folder

with tempfile.TemporaryDirectory() as folder:
    run_to_folder(load(sys.argv[1]), 1, int(sys.argv[2]), Path(folder) / "run", report=False)
print(json.dumps([(f"{k.py_func.__module__}:{k.py_func.__qualname__}", signatures.text(s))
                  for k, s in Kernel.calls]))
"""


def calls(world: str) -> list[tuple[str, str]]:
    """Return (function, types) for a world's kernels, in order of first call, from a separate process."""
    done = subprocess.run(
        [sys.executable, "-c", CALLS, world, str(TICKS)], capture_output=True, text=True, check=True
    )
    found = [
        (function, types)
        for function, types in json.loads(done.stdout.splitlines()[-1])
        if types and "<" not in function
    ]
    print(f"{world}: {len(found)} kernels", flush=True)
    return found


def write() -> None:
    """Run each shipped world for some ticks, and write the kernels that they call."""
    from ecs_eco.config.shipped import shipped

    worlds = sorted(shipped())
    by: dict[tuple[str, str], list[int]] = {}
    for number, world in enumerate(worlds):
        for call in calls(world):
            by.setdefault(call, []).append(number)
    lines = ["\t".join((",".join(map(str, numbers)), *call)) for call, numbers in by.items()]
    LIST.write_text("\n".join([f"# worlds: {', '.join(worlds)}", *lines]) + "\n", encoding="utf-8")


def check() -> int:
    """Return 1 if a line is unreadable or a fifth of the kernels no longer exist."""
    lines, gone = LIST.read_text(encoding="utf-8").splitlines()[1:], []
    for line in lines:
        _, function, types = line.split("\t")
        signatures.read(types)
        try:
            there = isinstance(kernel_of(function), Kernel)
        except (ImportError, AttributeError):
            there = False
        if not there:
            gone.append(function)
    if 5 * len(gone) > len(lines):
        print(
            f"{LIST.name}: {len(gone)} of {len(lines)} kernels no longer exist ({', '.join(gone[:5])} …); "
            "python tools/make_kernels.py",
            file=sys.stderr,
        )
    return int(5 * len(gone) > len(lines))


if __name__ == "__main__":
    sys.exit(check() if "--check" in sys.argv[1:] else write())
