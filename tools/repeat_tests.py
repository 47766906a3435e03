"""Run the README's test command several times in random order, and store the outcomes.

    python tools/repeat_tests.py --runs 5 [--busy] [--chromium both]
                                 [--out studies/results/repeated_tests.json]

Each run has an empty home folder, as on a fresh machine without compiled kernels. `--busy` keeps all
processors busy during the runs; the stored load shows other work on the machine. With `--chromium both`,
every second run finds no Chromium. Runs are appended to the file.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
OUT = ROOT / "studies" / "results" / "repeated_tests.json"
COUNTS = ("passed", "failed", "error", "skipped", "xfailed")


def command() -> str:
    """Return the part of the README's second command that runs the tests."""
    line = next(
        line for line in (ROOT / "README.md").read_text(encoding="utf-8").splitlines() if "-m pytest" in line
    )
    return line.rpartition(" && ")[2]


@contextmanager
def path_without_chromium() -> Iterator[str]:
    """Return a one-folder PATH with links to all programs on the user's PATH except Chromium."""
    with tempfile.TemporaryDirectory() as folder:
        for place in os.environ["PATH"].split(os.pathsep):
            for program in Path(place).glob("*"):
                link = Path(folder, program.name)
                if (
                    not re.match("chrom(e|ium)|google-chrome", program.name)
                    and not link.exists()
                    and not link.is_symlink()
                ):
                    link.symlink_to(program)
        yield folder


@contextmanager
def busy(wanted: bool) -> Iterator[None]:
    """Keep all processors busy."""
    spin = [sys.executable, "-c", "while True: pass"]
    processes = [subprocess.Popen(spin) for _ in range(os.cpu_count() or 1)] if wanted else []
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def once(path: str, spinning: bool, log: Path) -> dict[str, Any]:
    """Run the command with only two environment variables, PATH and HOME (an empty folder); write its output
    to `log`."""
    loads, done, start = [os.getloadavg()[0]], threading.Event(), time.monotonic()

    def look() -> None:
        while not done.wait(10):
            loads.append(os.getloadavg()[0])

    watcher = threading.Thread(target=look)
    watcher.start()
    with busy(spinning), log.open("w", encoding="utf-8") as file, tempfile.TemporaryDirectory() as home:
        code = subprocess.run(
            ["bash", "-c", command()],
            cwd=ROOT,
            env={"HOME": home, "PATH": path},
            stdout=file,
            stderr=subprocess.STDOUT,
            check=False,
        ).returncode
    done.set()
    watcher.join()
    text = log.read_text(encoding="utf-8", errors="replace")
    seed, last = re.search(r"--randomly-seed=(\d+)", text), text.rstrip().rpartition("\n")[2]
    counts = {name: int(match[1]) if (match := re.search(rf"\b(\d+) {name}", last)) else 0 for name in COUNTS}
    return {
        "code": code,
        "seed": int(seed[1]) if seed else None,
        **counts,
        "spinning": spinning,
        "empty home": True,
        "mean load": round(sum(loads) / len(loads), 2),
        "seconds": round(time.monotonic() - start),
        "not passed": re.findall(r"^(?:FAILED|ERROR) (\S+)", text, re.MULTILINE),
    }


def main() -> int:
    """Run the tests and store the outcomes; return the number of failed runs."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--busy", action="store_true")
    parser.add_argument("--chromium", choices=["here", "without", "both"], default="here")
    parser.add_argument("--out", type=Path, default=OUT)
    given = parser.parse_args()
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.strip()
    kept = json.loads(given.out.read_text(encoding="utf-8")) if given.out.is_file() else {}
    runs = kept.get("runs", [])
    for number in range(given.runs):
        without = given.chromium == "without" or (given.chromium == "both" and number % 2 == 1)
        with path_without_chromium() as bare, tempfile.TemporaryDirectory() as folder:
            log = Path(folder, "log")
            run = once(bare if without else os.environ["PATH"], given.busy, log)
            if run["code"]:
                shutil.copy(log, Path(tempfile.gettempdir(), f"repeat-tests-{run['seed']}.log"))
        runs.append({"commit": commit, "chromium": not without, **run})
        record = {"command": command(), "processors": os.cpu_count(), "runs": runs}
        given.out.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
        print(json.dumps(runs[-1]), flush=True)
    return sum(run["code"] != 0 for run in runs)


if __name__ == "__main__":
    sys.exit(main())
