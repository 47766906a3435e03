"""One world over several processes: how much faster, how many bytes, and what a model of it says for more.

    mpiexec is called by it: python benchmarks/bands.py [--animals 20000] [--processes 1 2] [--short]

Strong scaling: the same savanna in 1, 2, … processes. Weak: as many animals in each process as in the one.
All run in turns, and the best turn counts, for others may use the machine; processes that wait keep a core
busy, so that with other work on it the times of exchanges mean nothing. Work is counted in processor time,
which they disturb less: that which bands share, and that which every process does alike (the rest); so
exchanges and waiting are left out of both. All processes must come to the same digest, that of one process.

The model: t(N, P) = N (shared / P + alike) + calls · latency · log2 P + N · bytes · (1 − 1/P) / bandwidth,
the costs per animal from the runs of one process, latency and bandwidth from messages between two. Beside
it is the cost of true bands, which would hold their own part of the world alone: N (shared + alike) / P,
and the halo: who is within the widest sense of an edge goes to the neighbour, before sensing and after
moving. The halo of a band of the savanna is packed and sent here, and what its animals sense with it alone
is compared with what they sense in the whole world. A band is at least as high as the widest sense, which
bounds P.
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
WIDEST = 12.0  # [m] of the savanna's senses
GHOST = 28  # bytes of a ghost that is sensed: x, y, z, heading, radius, uid


def work(animals: int, ticks: int, learn: bool) -> dict[str, Any]:
    """Let a savanna pass some ticks in all processes that there are; return what process 0 spent."""
    from mpi4py import MPI

    from ecs_eco import World
    from ecs_eco.bands import divide

    comm = MPI.COMM_WORLD
    world = World.from_config(_bench.savanna(animals), seed=1, policies="untrained", training=True,
                              learn=learn, record=False)
    bands = divide(world, comm)
    shared, spun = [0.0], [0.0]
    clock(world, bands, shared, spun)
    world.run(65 if learn else 3)
    best: dict[str, Any] = {}
    for _ in range(3):
        bands.traffic.__init__()  # type: ignore[misc]
        shared[0] = spun[0] = 0.0
        start, cpu = time.perf_counter(), time.process_time()
        world.run(ticks)
        spent, cpu = time.perf_counter() - start, time.process_time() - cpu - spun[0]
        if not best or cpu < best["cpu"]:
            best = {"seconds": spent, "cpu": cpu, "shared": shared[0], "exchange": bands.traffic.seconds,
                    "calls": bands.traffic.calls / ticks, "bytes": bands.traffic.received / ticks}
    shares = comm.allgather(best["shared"])
    same = len(set(comm.allgather(world.digest()))) == 1
    n = sum(world.tables[name].n for name in ("grazer", "hunter"))
    return best | {"animals": n, "same": same, "digest": world.digest()[:16], "ticks": ticks,
                   "balance": max(shares) / statistics.mean(shares)}


def clock(world: Any, bands: Any, shared: list[float], spun: list[float]) -> None:
    """Add up the seconds of processor time of the work that bands share (sensing, networks, food, fields and
    gradients), and of exchanges and waiting for them."""
    from ecs_eco.systems.decide import Decide
    from ecs_eco.systems.diffuse import Diffuse
    from ecs_eco.systems.feed import Feed
    from ecs_eco.systems.learn import Learn
    from ecs_eco.systems.sense import Sense

    for system in world.systems:
        if isinstance(system, Sense | Feed | Diffuse | Decide | Learn):
            timed(system, "process", shared, spun)
    for name in ("_complete", "share"):
        timed(bands, name, spun, [0.0])


def timed(thing: Any, name: str, spent: list[float], without: list[float]) -> None:
    """Let a method add its processor time to `spent`, but for what is added to `without` meanwhile."""
    inner = getattr(thing, name)

    def method(*arguments: Any) -> None:
        start, before = time.process_time(), without[0]
        inner(*arguments)
        spent[0] += time.process_time() - start - (without[0] - before)

    setattr(thing, name, method)


def messages() -> dict[str, float]:
    """Return latency [s] and bandwidth [bytes/s] of Allgatherv between the processes there are."""
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
        times[size] = min(seconds)  # others disturbed the rest
    return {"latency": times[64], "bandwidth": 8_000_000 * (comm.size - 1) / times[8_000_000]}


def halo(animals: int) -> dict[str, Any]:
    """Send the ghosts of a band between two processes; return how many they are, their bytes and seconds."""
    import numpy as np
    from mpi4py import MPI

    from ecs_eco import World
    from ecs_eco.components import Body, Position

    comm, world = MPI.COMM_WORLD, World.from_config(_bench.savanna(animals), seed=1, policies="untrained",
                                                    record=False)
    world.flush()
    edge = world.space.lengths[1] / 2
    seconds, sizes = [], []
    for _ in range(20):
        start = time.perf_counter()
        strips = []
        for table in world.tables.values():
            p, high = table[Position], table.high
            below = edge - p.y[:high]
            rows = np.flatnonzero(table.alive[:high] & (below > 0) & (below < WIDEST))
            strips += [np.ascontiguousarray(column[rows]).view(np.uint8)
                       for column in (p.x, p.y, p.z, p.heading, table[Body].radius, table.uid)]
        packed = np.concatenate(strips)
        counts = comm.allgather(len(packed))
        incoming, other = np.empty(max(counts), np.uint8), comm.size - 1 - comm.rank
        comm.Sendrecv(packed, other, 0, incoming, other, 0)
        seconds.append(time.perf_counter() - start)
        sizes.append(len(packed))
    n = sum(t.n for t in world.tables.values())
    return {"organisms": n, "metres": float(world.space.lengths[0]), "ghosts": sizes[0] / GHOST,
            "bytes": sizes[0], "seconds": min(seconds), "same": senses_with_ghosts(world)}


def senses_with_ghosts(world: Any) -> bool:
    """Return whether the animals of a band sense the same bits when all beyond its ghosts are gone."""
    import numpy as np

    from ecs_eco.components import Position
    from ecs_eco.systems.sense import Sense

    sense = next(s for s in world.systems if isinstance(s, Sense))
    low, high = world.space.lengths[1] * 0.25, world.space.lengths[1] * 0.5
    seen = []
    for gone in (False, True):
        for table in world.tables.values():
            if gone:
                y = table[Position].y
                table.alive &= (y >= low - WIDEST) & (y < high + WIDEST)
            table.version += 1
        for name in ("grazer", "hunter"):
            table = world.tables[name]
            sense.update(table, world)
            nerves = table.species.nerves
            y = table[Position].y[nerves.rows]
            own = (y >= low) & (y < high)
            order = np.argsort(table.uid[nerves.rows[own]])
            seen.append(nerves.x[own][order].tobytes())
    return seen[:2] == seen[2:]


def launch(n: int, *arguments: str) -> dict[str, Any]:
    """Run this file in n processes; return what process 0 says."""
    mpiexec = shutil.which("mpiexec", path=str(Path(sys.executable).parent)) or "mpiexec"
    done = subprocess.run([mpiexec, "-n", str(n), sys.executable, __file__, "--part", *arguments],
                          capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(done.stdout + done.stderr)
    result: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return result


def row(kind: str, n: int, learn: bool, animals: int, ticks: int, turns: int) -> dict[str, Any]:
    """Return the best of some turns of one measurement."""
    results = [launch(n, "work", str(animals), str(ticks), str(int(learn))) for _ in range(turns)]
    best = min(results, key=lambda r: r["cpu"]) | {"seconds": min(r["seconds"] for r in results)}
    ns = 1e9 / best["ticks"] / best["animals"]
    alike = best["cpu"] - best["shared"]
    return {"scaling": kind, "learning": "yes" if learn else "no", "processes": n, "animals": best["animals"],
            "ms per tick": best["seconds"] / best["ticks"] * 1e3,
            "shared, ns per animal": best["shared"] * ns,
            "alike, ns per animal": alike * ns, "exchange, ns per animal": best["exchange"] * ns,
            "exchanges per tick": best["calls"], "bytes per animal and tick": best["bytes"] / best["animals"],
            "slowest share / mean": best["balance"],
            "digest": best["digest"] if best["same"] else "DIFFERENT"}


def predicted(one: dict[str, Any], two: dict[str, Any], wire: dict[str, float], strip: dict[str, Any],
              processes: int) -> dict[str, Any]:
    """Return the model's speed-up of a world of the size of `one` over P processes, as it is (whole worlds)
    and with true bands, on the wire that was measured."""
    n, p = one["animals"], processes
    shared, alike = one["shared, ns per animal"] * 1e-9, one["alike, ns per animal"] * 1e-9
    each = two["bytes per animal and tick"] * 2  # of all, of which 1 − 1/P comes from others
    now = (n * (shared / p + alike) + two["exchanges per tick"] * wire["latency"] * max(1, math.log2(p))
           + n * each * (1 - 1 / p) / wire["bandwidth"])
    side = math.sqrt(n / 0.045)  # [m]
    edge = strip["ghosts"] / strip["metres"] * side  # ghosts at one edge of a band
    send = 4 * (edge * strip["seconds"] / strip["ghosts"] + wire["latency"])  # two edges, twice a tick
    true = n * (shared + alike) / p + send
    whole = n * (shared + alike)
    return {"animals": n, "processes": p, "whole worlds: speed-up": whole / now,
            "true bands: speed-up": whole / true if side / p >= WIDEST else "bands too low",
            "bytes received per process and tick, whole worlds": n * each * (1 - 1 / p),
            "bytes of ghosts per band and tick": 4 * edge * GHOST, "height of a band [m]": side / p}


def main() -> None:
    """Measure in turns, fit, and print what the model says."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--animals", type=int, default=20_000)
    parser.add_argument("--processes", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--short", action="store_true", help="a small world, for seconds; writes nothing")
    parser.add_argument("--part", nargs="+", default=None, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.part:
        part(*options.part)
        return
    animals, turns = (1500, 1) if options.short else (options.animals, options.turns)
    rows = []
    for learn in (False, True):
        ticks = (64 if learn else 20) if not options.short else 4
        for kind in ("strong", "weak"):
            rows += [row(kind, n, learn, animals * (n if kind == "weak" else 1), ticks, turns)
                     for n in options.processes if kind == "strong" or n > 1]
    wire, strip = launch(2, "messages"), launch(2, "halo", str(animals))
    conclude(rows, wire, strip, options.short)


def conclude(rows: list[dict[str, Any]], wire: dict[str, float], strip: dict[str, Any], short: bool) -> None:
    """Print the rows and what the model says; write both unless it is short."""
    one, two = rows[0], next(r for r in rows if r["processes"] == 2)
    notes = {"latency of an exchange between two processes [s]": wire["latency"],
             "bandwidth between two processes [bytes/s]": wire["bandwidth"],
             "ghosts at an edge": strip["ghosts"], "bytes of them": strip["bytes"],
             "seconds to pack and send them": strip["seconds"],
             "with ghosts alone a band senses the same bits": strip["same"]}
    model = [predicted(one | {"animals": n}, two, wire, strip, p)
             for n in (one["animals"], 10_000_000) for p in (2, 4, 16, 1000)]
    if short:
        print(json.dumps({"rows": rows, "notes": notes, "model": model}, indent=1))
        return
    _bench.save("bands", "One world over several processes", rows, notes)
    _bench.save("bands_model", "What a model says of one world over many processes", model)


def part(what: str, *arguments: str) -> None:
    """Do one measurement in this process of several; process 0 prints the result."""
    from mpi4py import MPI

    numbers = [int(a) for a in arguments]
    result = {"work": lambda: work(numbers[0], numbers[1], bool(numbers[2])), "messages": messages,
              "halo": lambda: halo(numbers[0])}[what]()
    if MPI.COMM_WORLD.rank == 0:
        print(json.dumps(result))


if __name__ == "__main__":
    main()
