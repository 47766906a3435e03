"""Compare frameworks: organism-steps per second of grazers that search for their nearest neighbor, move, eat
and breed, in ecs-eco, in other frameworks and in a bare loop, all in one run on one machine.

    python benchmarks/peers.py [--sizes 1000 10000 100000] [--peers ecs-eco Mesa …] [--rounds 3] [--short]
    python benchmarks/peers.py --others PYTHON --frames PYTHON   # interpreters with the frameworks installed

Each framework implements the task in its own idiom (`peers_grazing.py`, `peers_others.py`); frameworks that
cannot express it run a different task, named in the table, to indicate their cost per tick. Each framework
runs in a process with one thread; processes take turns, and the best round counts. Setup and the first tick
are not timed. A process is stopped after `--limit` seconds. In the common task, the numbers of animals must
agree with those of the bare loop.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()

ROOT = Path(__file__).parents[1]
PEERS = {  # module, function, and whether the peer runs the common task
    "bare loop": ("peers_grazing", "bare", True),
    "ecs-eco": ("peers_grazing", "ecs_eco", True),
    "Mesa": ("peers_others", "mesa", True),
    "mesa-frames": ("peers_frames", "mesa_frames", True),
    "AgentPy": ("peers_others", "agentpy", True),
    "MAgent2 battle, dicts": ("peers_others", "magent2", False),
    "MAgent2 battle, arrays": ("peers_others", "magent2_arrays", False),
    "PettingZoo pursuit": ("peers_others", "pursuit", False),
}
PATIENCE, TIMED = 3.0, 200  # [s] per round, and maximum number of ticks
WARM = 60  # ticks until births and starvation occur
COMPARED = 20  # ticks after which numbers of animals are compared


def one(peer: str, n: int, seed: int) -> dict[str, Any]:
    """Run a peer in this process; return organism-steps per second and the number of living animals after
    COMPARED ticks."""
    import importlib

    module, function, _ = PEERS[peer]
    make: Callable[..., Any] = getattr(importlib.import_module(module), function)
    if module == "peers_grazing":  # compile in a small world
        tick, _ = make(100, seed)
        for _ in range(WARM):
            tick()
    tick, living = make(n, seed)
    tick()
    steps, spent, at = 0, 0.0, {}
    for k in range(1, TIMED + 1):
        steps += living()
        start = time.process_time()
        tick()
        spent += time.process_time() - start
        if k == COMPARED - 1:
            at = {"after": living()}
        if spent > PATIENCE and (k >= COMPARED or steps / k > 3e4 or spent > 10 * PATIENCE):
            break
    return {"steps/s": steps / spent, "ticks": k, **at}


def apart(peer: str, n: int, seed: int, interpreter: str, limit: float) -> dict[str, Any]:
    """Run a peer in a separate process; return its result, or the reason for its failure."""
    command = [interpreter, __file__, "--one", peer, str(n), str(seed)]
    paths = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=limit,
            check=False,
            env=os.environ | {"PYTHONPATH": paths},
        )
    except subprocess.TimeoutExpired:
        return {"why": f"stopped after {limit:g} s"}
    if done.returncode:
        return {"why": (done.stderr.strip().splitlines() or ["?"])[-1][:80]}
    result: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return result


def rows_of(found: dict[tuple[str, int], list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """Return the table: the best round of each peer at each size, and its share of the bare loop's speed."""
    rows = []
    for (peer, n), rounds in found.items():
        good = [r for r in rounds if "steps/s" in r]
        floor = [r["steps/s"] for r in found.get(("bare loop", n), []) if "steps/s" in r]
        alike = [r["after"] for r in found.get(("bare loop", n), []) if "after" in r]
        best = max((r["steps/s"] for r in good), default=None)
        after = [r["after"] for r in good if "after" in r]
        common = PEERS[peer][2]
        rows.append(
            {
                "peer": peer,
                "task": "common" if common else "its own",
                "animals": n,
                "k organism-steps/s": None if best is None else best / 1e3,
                "bare loop's speed / this speed": max(floor) / best if best and floor and common else None,
                f"live animals after {COMPARED} ticks / bare loop's": (
                    sum(after) / len(after) / (sum(alike) / len(alike))
                    if after and alike and common
                    else None
                ),
                "note": "" if good else rounds[0]["why"],
            }
        )
    return rows


def figure(rows: list[dict[str, Any]], path: Path) -> None:
    """Plot organism-steps per second against the number of animals."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams["svg.hashsalt"] = "ecs-eco"
    drawing, ax = plt.subplots(figsize=(7, 4.2), layout="constrained")
    for peer, (_, _, common) in PEERS.items():
        mine = [r for r in rows if r["peer"] == peer and r["k organism-steps/s"]]
        if mine:
            ax.plot(
                [r["animals"] for r in mine],
                [1e3 * r["k organism-steps/s"] for r in mine],
                "o-" if common else "s:",
                lw=2.2 if peer == "ecs-eco" else 1.2,
                ms=4,
                label=peer + ("" if common else " (own task)"),
            )
    ax.set(xscale="log", yscale="log", xlabel="animals", ylabel="organism-steps per second, one core")
    ax.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    drawing.savefig(path, metadata={"Date": None})


def main() -> None:
    """Measure, print and store the results."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--sizes", nargs="+", type=int, default=[1000, 10_000, 100_000])
    parser.add_argument("--peers", nargs="+", choices=PEERS, default=list(PEERS))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--limit", type=float, default=600, metavar="S", help="time limit for each process")
    parser.add_argument(
        "--others", default=sys.executable, metavar="PYTHON", help="interpreter with the other frameworks"
    )
    parser.add_argument(
        "--frames",
        default=sys.executable,
        metavar="PYTHON",
        help="interpreter with mesa-frames, which needs an older numpy",
    )
    parser.add_argument("--name", default="peers", help="name of result and figure")
    parser.add_argument("--short", action="store_true", help="print only")
    parser.add_argument("--one", nargs=3, metavar=("PEER", "N", "SEED"), help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.one:
        print(json.dumps(one(asked.one[0], int(asked.one[1]), int(asked.one[2]))))
        return
    found: dict[tuple[str, int], list[dict[str, Any]]] = {}
    for n in asked.sizes:
        for seed in range(1, asked.rounds + 1):
            for peer in asked.peers:
                if not (rounds := found.setdefault((peer, n), [])) or "why" not in rounds[0]:
                    with_it = {"peers_others": asked.others, "peers_frames": asked.frames}.get(
                        PEERS[peer][0], sys.executable
                    )
                    rounds.append(apart(peer, n, seed, with_it, asked.limit))
                    print(peer, n, rounds[-1], file=sys.stderr, flush=True)
    rows = rows_of(found)
    if asked.short:
        print(json.dumps(rows, indent=1))
        return
    _bench.save(
        asked.name, "Grazers that look around, move, eat and breed, in other frameworks, on one core", rows
    )
    figure(rows, ROOT / "docs" / "img" / f"{asked.name}.svg")


if __name__ == "__main__":
    main()
