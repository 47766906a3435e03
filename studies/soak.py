"""A small world runs a million ticks; memory, ledger, ids and speed at the end are compared with their values
at the start."""

import gc
import resource
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from ecs_eco.record.ledger import imbalance
from studies.common.study import Study, verdict

GRASS = {
    "count": 60,
    "body": {"radius": 0.4, "opaque": False},
    "metabolism": {"energy": 0.3},
    "reproduction": {"kind": "spread", "rate": 0.05, "seed_rain": 0.004, "spacing": 2.0},
}
RABBIT = {
    "count": 12,
    "body": {"radius": 0.3},
    "metabolism": {"energy": 0.6, "basal": 0.004},
    "locomotion": {"speed": {"hop": 0.7}, "cost": {"hop": 0.002}, "turn": 0.8},
    "diet": [{"eats": "grass", "reach": 0.2, "gain": 0.25}],
    "sensors": [{"kind": "own", "property": "energy"}, {"kind": "nearest", "target": "grass", "range": 4.0}],
    "actions": {"speed": ["hop"], "turn": ["left", "none", "right"], "eat": ["eat"]},
    "always_on": ["hop", "eat"],
    "happiness": {"weights": {"energy": 1.0}, "minimum": -1.0},
    "policy": {"kind": "individual", "hidden": [8], "learn": True, "inherit": "learned"},
    "ppo": {"horizon": 32, "epochs": 2, "learning_rate": 0.01},
    "reproduction": {"kind": "asexual", "rate": 0.01, "energy_min": 0.7, "energy_given": 0.3},
    "lethal": [
        {"property": "energy", "min": 0.0, "cause_below": "starved"},
        {"property": "age", "max": 400.0, "cause_above": "too old"},
    ],
}
WORLD = {
    "format": 1,
    "name": "soak",
    "space": {"size": [24.0, 24.0]},
    "species": {"grass": GRASS, "rabbit": RABBIT},
}


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Run the world with recording and checkpoints; measure memory and time for every block of ticks."""
    from ecs_eco import World
    from ecs_eco.record import Recorder
    from ecs_eco.record.folder import Folder
    from ecs_eco.record.parquet import read_parts

    ticks, block = config["ticks"], config["block"]
    memory, seconds, numbers = [], [], []
    with tempfile.TemporaryDirectory() as place:
        world = World.from_config(WORLD, seed=case["seed"], record=False)
        folder = Folder(Path(place) / "run", world)
        folder.path.mkdir()
        Recorder(world, folder.sink)
        world.run(block)  # time for kernels to compile and for buffers to reach full size
        for done in range(block, ticks, block):
            start = time.perf_counter()
            world.run(min(block, ticks - done))
            seconds.append(time.perf_counter() - start)
            gc.collect()
            memory.append(int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize())
            numbers.append(world.tables["rabbit"].n)
            if done % config["checkpoint_every"] == 0:
                world.save(Path(place) / "last.safetensors")
        world.recorder.flush()
        series = {n: c for n, c in read_parts(folder.path / "series").to_pydict().items() if n != "species"}
        uids = np.array(read_parts(folder.path / "births", columns=["uid"])["uid"], np.uint64)
        same = World.restore(Path(place) / "last.safetensors").tick <= world.tick
        part = sum(p.stat().st_size for p in folder.path.rglob("*.parquet"))
    s = {n: np.asarray(c, float) for n, c in series.items()}
    left = imbalance(s)
    half = len(memory) // 10 or 1
    slope = float(np.polyfit(np.arange(len(memory)) * block, memory, 1)[0]) if len(memory) > 2 else 0.0
    return {
        "ticks": world.tick,
        "births": int(uids.size),
        "ids": int(np.unique(uids).size),
        "next uid": int(world.next_uid),
        "rabbits, fewest at the end of a block": int(min(numbers, default=0)),
        "ledger gap, as a share of the stock": float((np.abs(left) / np.maximum(1, s["stock_before"])).max()),
        "memory slope [B/tick]": slope,
        "memory first, last [MB]": [round(memory[0] / 1e6, 1), round(memory[-1] / 1e6, 1)],
        "ticks/s first tenth, last tenth": [
            block / float(np.median(seconds[:half])),
            block / float(np.median(seconds[-half:])),
        ],
        "recording [MB]": round(part / 1e6, 1),
        "restored": bool(same),
    }


def summarise(cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Report which measures remained constant."""
    r = cases[0]["result"]
    first, last = r["ticks/s first tenth, last tenth"]
    growth = r["memory slope [B/tick]"] * r["ticks"] / 1e6 / r["memory first, last [MB]"][0]
    return [
        verdict("ticks", r["ticks"], "1,000,000 or more", r["ticks"] >= 1_000_000),
        verdict(
            "births, and distinct ids among them",
            f"{r['births']:,}, {r['ids']:,}",
            "as many ids as births",
            r["births"] == r["ids"],
        ),
        verdict(
            "memory slope [B/tick]; growth over the run, as a share",
            f"{r['memory slope [B/tick]']:.3g}; {growth:.3f}",
            "below 0.02",
            abs(growth) < 0.02,
        ),
        verdict(
            "largest gap in the energy ledger, as a share of the stock",
            r["ledger gap, as a share of the stock"],
            "below 1e-5",
            r["ledger gap, as a share of the stock"] < 1e-5,
        ),
        verdict(
            "speed at the end, relative to the start",
            round(last / first, 3),
            "0.9 to 1.1",
            0.9 <= last / first <= 1.1,
        ),
        verdict(
            "fewest rabbits at the end of a block",
            r["rabbits, fewest at the end of a block"],
            "above 0",
            r["rabbits, fewest at the end of a block"] > 0,
        ),
    ]


STUDY = Study(
    name="soak",
    claim="Over a million ticks memory stays flat, ledgers close, ids are unique, and speed does not fall.",
    config={"ticks": 1_000_000, "block": 5000, "checkpoint_every": 100_000},
    cases=[{"seed": 31}],
    run=run,
    summarise=summarise,
    short_config={"ticks": 6000, "block": 500, "checkpoint_every": 1000},
)

if __name__ == "__main__":
    STUDY.main()
