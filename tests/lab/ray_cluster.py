"""On a Ray cluster of two nodes on this machine: runs go on, with the same digests, when a worker is killed
and when a node is. `python -m tests.lab.ray_cluster FOLDER`; test_ray_executor.py runs it."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ecs_eco.lab.executors import executor, prepare
from ecs_eco.record.checkpoint import tick_of

WORLD, TICKS, EVERY = "reflexes", 300, 20
SEEDS = (1, 2, 3, 4)
SOON = {"health_check_initial_delay_ms": 1000, "health_check_period_ms": 1000}  # a lost node is found in 5 s


def work(folder: Path, seed: int, slowly: float = 0.0) -> str:
    """Run a world into a folder, or go on there; return its digest. Notes who does it."""
    from ecs_eco.runs.run import resume, run_to_folder

    def slow(world: Any) -> None:
        (folder / f"by-{os.getpid()}").write_text(f"{node()} {world.tick}")
        world.before_tick.append(lambda: time.sleep(slowly))

    if (folder / "manifest.json").is_file():
        return str(resume(folder, TICKS, report=False, complain=lambda _: None, prepare=slow)["digest"])
    return str(
        run_to_folder(
            WORLD, seed=seed, ticks=TICKS, out=folder, report=False, checkpoint_every=EVERY, prepare=slow
        )["digest"]
    )


def main(out: Path) -> dict[str, Any]:
    """Return the digests of runs one after the other, and of those in the cluster."""
    from ray.cluster_utils import Cluster

    from ecs_eco.config import load

    plain = {seed: work(out / f"plain-{seed}", seed) for seed in SEEDS}
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "_system_config": SOON})
    second = cluster.add_node(num_cpus=1)
    os.environ["RAY_ADDRESS"] = cluster.address
    shared = {seed: out / f"ray-{seed}" for seed in SEEDS}
    begin = time.perf_counter()
    with executor("ray") as pool:
        prepare(pool, out, load(WORLD))
        print(f"prepared after {time.perf_counter() - begin:.1f} s", file=sys.stderr)
        calls = {seed: pool.submit(work, folder, seed, 0.02) for seed, folder in shared.items()}
        killed = under_way(shared.values())[0]
        os.kill(killed, signal.SIGKILL)
        print(f"{time.perf_counter() - begin:.1f} s: killed a worker", file=sys.stderr)
        under_way(shared.values(), second.node_id, without=killed)
        cluster.remove_node(second, allow_graceful=False)
        print(f"{time.perf_counter() - begin:.1f} s: killed a node", file=sys.stderr)
        digests = {seed: call.result() for seed, call in calls.items()}
    print(f"all done after {time.perf_counter() - begin:.1f} s", file=sys.stderr)
    cluster.shutdown()
    begun = {
        seed: sorted(int(note.read_text().split()[1]) for note in folder.glob("by-*"))
        for seed, folder in shared.items()
    }
    return {"plain": plain, "ray": digests, "begun": begun}


def node() -> str:
    """Return the id of the Ray node that this is called on, "" outside."""
    ray = sys.modules.get("ray")
    return ray.get_runtime_context().get_node_id() if ray is not None and ray.is_initialized() else ""


def under_way(folders: Iterable[Path], on: str = "", without: int = 0) -> list[int]:
    """Wait for a run, on a node if one is named, that has a checkpoint and is not done;
    return the processes of such runs."""
    until = time.monotonic() + 300
    while time.monotonic() < until:
        processes = []
        for folder in folders:
            notes = {int(note.name[3:]): note.read_text().split() for note in folder.glob("by-*")}
            later = [c for c in folder.glob("checkpoints/tick-*.safetensors") if tick_of(c) > EVERY]
            if later and tick_of(max(later)) < TICKS * 0.8:
                processes += [
                    pid
                    for pid, words in notes.items()
                    if words and on in words[0] and pid != without and Path(f"/proc/{pid}").exists()
                ]
        if processes:
            return processes
        time.sleep(0.05)
    raise TimeoutError("no run came so far")


if __name__ == "__main__":
    print(json.dumps(main(Path(sys.argv[1]))))
