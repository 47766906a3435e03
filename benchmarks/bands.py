"""Measure one world split across several processes: speed-up, bytes, and a model's predictions for more
processes.

    python benchmarks/bands.py [--animals 20000] [--processes 1 2] [--short]

The script calls mpiexec. Strong scaling: the same savanna in 1, 2, … processes. Weak scaling: as many animals
in each process as in the single process. Both kinds of scaling are measured with the whole world in every
process (`--bands`) and with divided state (`--divided`). All variants take turns, and the best turn counts,
because other work may share the machine. Waiting processes keep a core busy, so with other work on the
machine, wall-clock and exchange times are meaningless. Work is therefore measured in processor time without
exchanges and waiting, separately for work that bands share and work that every process repeats. All processes
must end with a single process's digest.

The cost of a band's halo (the number of ghosts, their bytes, and the processor time to pack, unpack and
remove them) is measured in the divided savanna, for several numbers of organisms per band.

The model for whole worlds: t(N, P) = N (shared / P + alike) + calls · latency · log2 P + N · bytes · (1 −
1/P) / bandwidth. The model for divided state: t(N, P) = N shared / P + told(N) + halo(ghosts) + calls ·
latency · log2 P + bytes of the halo / bandwidth, where ghosts and their bytes grow only with the map's width;
told is the work that every process does for births and plant sites, wherever they are. Both models are linear
fits to measurements at several sizes. The cost of shared work per animal comes from single-process runs;
latency and bandwidth come from messages between two processes.
"""

import argparse
import json
import math
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import _bench

_bench.pin_threads()
SIZES = 1250, 2500, 5000, 10_000, 20_000  # numbers of animals per band for which the halo is measured


def work(animals: int, ticks: int, learn: bool, state: bool) -> dict[str, Any]:
    """Run some ticks of a savanna in all processes of this job; return process 0's costs."""
    from mpi4py import MPI

    from ecs_eco import World
    from ecs_eco.bands import divide

    comm = MPI.COMM_WORLD
    world = World.from_config(
        _bench.savanna(animals), seed=1, policies="untrained", training=True, learn=learn, record=False
    )
    bands = divide(world, comm, state=state)
    spent = {"alike" if state else "shared": 0.0, "halo": 0.0, "spun": 0.0}
    (clock_divided if state else clock)(world, bands, spent)
    world.run(65 if learn else 3)
    best: dict[str, Any] = {}
    for _ in range(3):
        before, ghosts, said = bands.traffic.copy(), getattr(bands, "copied", 0), dict.fromkeys(spent, 0.0)
        spent.update(said)
        start, cpu = time.perf_counter(), time.process_time()
        world.run(ticks)
        seconds, cpu = time.perf_counter() - start, time.process_time() - cpu - spent["spun"]
        if not best or cpu < best["cpu"]:
            traffic = bands.traffic
            shared = cpu - spent["alike"] - spent["halo"] if state else spent["shared"]
            best = {
                "seconds": seconds,
                "cpu": cpu,
                "shared": shared,
                "halo": spent["halo"],
                "exchange": traffic.seconds - before.seconds,
                "calls": (traffic.calls - before.calls) / ticks,
                "bytes": (traffic.received - before.received) / ticks,
                "ghosts": (getattr(bands, "copied", 0) - ghosts) / ticks,
            }
    shares, digest = comm.allgather(best["shared"]), world.digest()
    same = len(set(comm.allgather(digest))) == 1
    held = sum(table.n for table in world.tables.values())
    n = sum(world.tables[name].n for name in ("grazer", "hunter"))
    if state:
        best["least"] = bands.edges.least * float(world.space.lengths[1]) / bands.edges.ny
    return best | {
        "animals": comm.allreduce(n) if state else n,
        "held": held,
        "same": same,
        "digest": digest[:16],
        "ticks": ticks,
        "width": float(world.space.lengths[0]),
        "balance": max(shares) / statistics.mean(shares),
    }


def clock(world: Any, bands: Any, spent: dict[str, float]) -> None:
    """Sum the processor seconds spent on shared work (sensing, networks, food, fields and gradients), and on
    exchanges and waiting for them."""
    from ecs_eco.systems.decide import Decide
    from ecs_eco.systems.diffuse import Diffuse
    from ecs_eco.systems.feed import Feed
    from ecs_eco.systems.learn import Learn
    from ecs_eco.systems.sense import Sense

    for system in world.systems:
        if isinstance(system, Sense | Feed | Diffuse | Decide | Learn):
            timed(system, "process", spent, "shared")
    for name in ("_complete", "share", "agree"):
        timed(bands, name, spent, "spun")


def clock_divided(world: Any, bands: Any, spent: dict[str, float]) -> None:
    """Sum the processor seconds spent on work that all processes repeat, on ghosts and animals that move to
    another process, and on exchanges and waiting for them; each process does all other work for its own
    part."""
    from ecs_eco.systems.respawn import Respawn
    from ecs_eco.systems.spread import Spread

    for system in world.systems:
        if isinstance(system, Respawn | Spread):
            timed(system, "process", spent, "alike")
    timed(world, "flush_births", spent, "alike")
    for name in ("copy", "migrate", "forget"):
        timed(bands, name, spent, "halo")
    for thing, names in (
        (bands.wire, ("swap", "everyone", "any", "total")),
        (bands.talk, ("say",)),
        (bands.common_bands, ("_complete", "share")),
    ):
        for name in names:
            timed(thing, name, spent, "spun")


def timed(thing: Any, name: str, spent: dict[str, float], word: str) -> None:
    """Make a method add its processor time to a label, excluding time counted under nested labels."""
    inner = getattr(thing, name)

    def method(*arguments: Any) -> Any:
        start, before = time.process_time(), sum(spent.values())
        out = inner(*arguments)
        spent[word] += time.process_time() - start - (sum(spent.values()) - before)
        return out

    setattr(thing, name, method)


def messages() -> dict[str, float]:
    """Return the latency [s] and bandwidth [bytes/s] of Allgatherv between this job's processes."""
    import numpy as np
    from mpi4py import MPI

    comm, times = MPI.COMM_WORLD, {}
    for size in (64, 8_000_000):
        buffer = np.zeros(size * comm.size, np.uint8)
        counts, starts = [size] * comm.size, [size * k for k in range(comm.size)]
        seconds = []
        for _ in range(40 if size > 1000 else 400):
            start = time.perf_counter()
            comm.Allgatherv(MPI.IN_PLACE, [buffer, counts, starts, MPI.BYTE])
            seconds.append(time.perf_counter() - start)
        times[size] = min(seconds)  # other work disturbed the longer exchanges
    return {"latency": times[64], "bandwidth": 8_000_000 * (comm.size - 1) / times[8_000_000]}


def launch(n: int, *arguments: str) -> dict[str, Any]:
    """Run this file in n processes; return the output of process 0."""
    mpiexec = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or "mpiexec"
    done = subprocess.run(
        [mpiexec, "-n", str(n), sys.executable, __file__, "--part", *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise SystemExit(done.stdout + done.stderr)
    result: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return result


def row(kind: str, n: int, learn: bool, state: bool, animals: int, ticks: int) -> dict[str, Any]:
    """Return one measurement from one turn."""
    return launch(n, "work", str(animals), str(ticks), str(int(learn)), str(int(state))) | {
        "kind": kind,
        "processes": n,
        "learn": learn,
        "state": state,
    }


def best_row(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Return a table row for the best turn of one measurement."""
    best = min(results, key=lambda r: r["cpu"]) | {"seconds": min(r["seconds"] for r in results)}
    ns = 1e9 / best["ticks"] / best["animals"]
    alike = best["cpu"] - best["shared"] - best["halo"]
    return {
        "scaling": best["kind"],
        "learning": "yes" if best["learn"] else "no",
        "state": "divided" if best["state"] else "whole",
        "processes": best["processes"],
        "animals": best["animals"],
        "ms per tick": best["seconds"] / best["ticks"] * 1e3,
        "divided work, ns per animal": best["shared"] * ns,
        "replicated work, ns per animal": alike * ns,
        "halo, ns per animal": best["halo"] * ns,
        "exchange, ns per animal": best["exchange"] * ns,
        "exchanges per tick": best["calls"],
        "bytes per animal per tick": best["bytes"] / best["animals"],
        "organisms in a process": best["held"],
        "slowest share / mean": best["balance"],
        "digest": best["digest"] if best["same"] else "DIFFERENT",
    }


def halo_row(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the cost of a band's halo, measured with the savanna in two processes."""
    best = min(results, key=lambda r: r["halo"])
    return {
        "organisms in a band": best["held"],
        "width of the map [m]": best["width"],
        "animals": best["animals"],
        "minimum height of a band [m]": best["least"],
        "ghosts per tick": best["ghosts"],
        "bytes received per tick": best["bytes"],
        "processor time of the halo per tick [ms]": best["halo"] / best["ticks"] * 1e3,
        "processor time of replicated work per tick [ms]": (best["cpu"] - best["shared"] - best["halo"])
        / best["ticks"]
        * 1e3,
        "total processor time per tick [ms]": best["cpu"] / best["ticks"] * 1e3,
    }


def line(halos: list[dict[str, Any]], x: str, y: str) -> tuple[float, float]:
    """Return the intercept (at least 0) and slope of a line fitted to the given columns."""
    if len(halos) == 1:
        return 0.0, halos[0][y] / halos[0][x]
    slope, start = statistics.linear_regression([h[x] for h in halos], [h[y] for h in halos])
    return max(start, 0.0), max(slope, 0.0)


def predicted(
    rows: dict[str, dict[str, Any]], wire: dict[str, float], halos: list[dict[str, Any]], n: int, p: int
) -> dict[str, Any]:
    """Return the model's speed-up for a savanna of n animals in p processes, with the measured network."""
    one, two, divided = rows["one"], rows["whole"], rows["divided"]
    shared, alike = one["divided work, ns per animal"] * 1e-9, one["replicated work, ns per animal"] * 1e-9
    # of all bytes, the share 1 − 1/P comes from other processes
    each = two["bytes per animal per tick"] * 2
    calls = math.ceil(math.log2(p)) * wire["latency"]
    now = (
        n * (shared / p + alike)
        + two["exchanges per tick"] * calls
        + n * each * (1 - 1 / p) / wire["bandwidth"]
    )
    side = math.sqrt(n / 0.045)  # [m]
    ghosts, size = (
        halos[-1][name] / halos[-1]["width of the map [m]"] * side
        for name in ("ghosts per tick", "bytes received per tick")
    )
    first, each_ghost = line(halos, "ghosts per tick", "processor time of the halo per tick [ms]")
    begin, told = line(halos, "animals", "processor time of replicated work per tick [ms]")
    own = shared + alike - told * 1e-3
    parts = (
        n * own / p
        + (begin + n * told + first + ghosts * each_ghost) * 1e-3
        + divided["exchanges per tick"] * calls
        + size / wire["bandwidth"]
    )
    whole, least = n * (shared + alike), halos[-1]["minimum height of a band [m]"]
    return {
        "animals": n,
        "processes": p,
        "whole worlds: speed-up": whole / now,
        "divided state: speed-up": whole / parts if side / p >= least else "bands too low",
        "bytes received per process per tick, whole worlds": n * each * (1 - 1 / p),
        "bytes received per process per tick, divided state": size,
        "height of a band [m]": side / p,
    }


def main() -> None:
    """Measure all variants alternately, fit the models, and print their predictions."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--animals", type=int, default=20_000)
    parser.add_argument("--processes", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument(
        "--short", action="store_true", help="use a small world, for a few seconds; write no results"
    )
    parser.add_argument("--part", nargs="+", default=None, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.part:
        part(*options.part)
        return
    animals, turns = (1500, 1) if options.short else (options.animals, options.turns)
    cases: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for _ in range(turns):
        for learn in (False, True):
            ticks = (64 if learn else 20) if not options.short else 4
            for kind, state in (("strong", False), ("strong", True), ("weak", False), ("weak", True)):
                for n in options.processes if kind == "strong" else options.processes[1:]:
                    many = animals * (n if kind == "weak" else 1)
                    done = row(kind, n, learn, state, many, ticks)
                    cases.setdefault((kind, n, learn, state), []).append(done)
    halos = [
        halo_row([launch(2, "work", str(2 * n), "20", "0", "1") for _ in range(turns)])
        for n in (SIZES[:1] if options.short else SIZES)
    ]
    wires = [
        launch(2, "messages") for _ in range(1 if options.short else 8)
    ]  # other work may disturb some of them
    wire = {"latency": min(w["latency"] for w in wires), "bandwidth": max(w["bandwidth"] for w in wires)}
    conclude({case: best_row(results) for case, results in cases.items()}, wire, halos, options.short)


def conclude(
    cases: dict[tuple[Any, ...], dict[str, Any]],
    wire: dict[str, float],
    halos: list[dict[str, Any]],
    short: bool,
) -> None:
    """Print the rows and the predictions; write both unless the run is short."""
    notes = {
        "latency of an exchange between two processes [s]": wire["latency"],
        "bandwidth between two processes [bytes/s]": wire["bandwidth"],
    }
    rows = {
        "one": cases["strong", 1, False, False],
        "whole": cases["strong", 2, False, False],
        "divided": cases["strong", 2, False, True],
    }
    model = [
        predicted(rows, wire, halos, n, p)
        for n in (rows["one"]["animals"], 10_000_000)
        for p in (2, 4, 16, 1000)
    ]
    if short:
        print(
            json.dumps(
                {"rows": list(cases.values()), "notes": notes, "halos": halos, "model": model}, indent=1
            )
        )
        return
    _bench.save("bands", "One world split across several processes", list(cases.values()), notes)
    _bench.save("bands_halo", "The cost of a band's halo", halos)
    _bench.save("bands_model", "A model's predictions for one world split across many processes", model)


def part(what: str, *arguments: str) -> None:
    """Do one measurement in this process, which is one of several; process 0 prints the result."""
    from mpi4py import MPI

    numbers = [int(a) for a in arguments]
    result = (
        work(numbers[0], numbers[1], bool(numbers[2]), bool(numbers[3])) if what == "work" else messages()
    )
    if MPI.COMM_WORLD.rank == 0:
        print(json.dumps(result))


if __name__ == "__main__":
    main()
