"""Run PPO alternately in this commit and another, with one shared network and with individual networks.

    python benchmarks/ppo_roads.py --folder CHECKOUT [--turns 9]

The jobs are an update of a shared 24-64-64-6 network from 16-tick rollouts of 10,000 animals, and a horizon
of 32 ticks, without inference, for 1,000 animals that each have a 24-32-8 network. Work on one thread is
measured in processor time. The ratio is this commit's time divided by the checkout's, turn by turn.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import _bench
from in_turns import measure

SHARED = """
import numpy as np
from ecs_eco.learning import PPO, Brain, Learner, choose
learner, rows, rng = Learner(Brain(24, (3, 3)), PPO(), 0), np.arange(10_000), np.random.default_rng(0)
choice, log_probability = np.empty((len(rows), 2), np.int16), np.empty(len(rows), np.float32)
def fill():
    for _ in range(16):
        seen = rng.standard_normal((len(rows), 24), dtype=np.float32)
        logits, values = learner.brain.forward(seen)
        choose(logits, learner.brain.offsets, rng.random(choice.shape, dtype=np.float32), choice, log_probability)
        learner.rollout.store(rows, seen, choice, log_probability, values)
        learner.rollout.credit(rows, seen[:, 0])
    return values
learner.update(rows, fill())
for _ in sys.stdin:
    values = fill()
    begin = time.process_time()
    learner.update(rows, values)
    print((time.process_time() - begin) * 1e3, flush=True)
"""
INDIVIDUAL = """
import individual_ppo as bench
herd, horizon = bench.Herd(1000, 24, (32,), 8, 1), bench.SETTINGS.horizon
for _ in range(2 * horizon):
    herd.live()
for _ in sys.stdin:
    print(sum(herd.live()[3] for _ in range(horizon)) * 1e3, flush=True)
"""
SMALL = INDIVIDUAL.replace("24, (32,), 8", "16, (16,), 8")


def main() -> None:
    """Measure both."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--folder", type=Path, required=True, help="a checkout of the other commit")
    parser.add_argument("--turns", type=int, default=9)
    given = parser.parse_args()
    rows = [
        measure(given.folder, work, "ms", False, code, given.turns)
        for work, code in (
            ("an update of a shared network, 10,000 animals", SHARED),
            ("a horizon of 1,000 individual learners, 24-32-8", INDIVIDUAL),
            ("a horizon of 1,000 individual learners, 16-16-8", SMALL),
        )
    ]
    _bench.save(
        "ppo_roads", "PPO with a shared network and with individual networks, against an earlier commit", rows
    )


if __name__ == "__main__":
    main()
