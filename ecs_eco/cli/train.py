"""The command train: trains a world's policies before it is run."""

import shlex
from typing import Any

from ecs_eco.analysis.learning import write_training
from ecs_eco.analysis.page import number
from ecs_eco.cli.folders import results
from ecs_eco.cli.options import On, Out, Quiet, Seed, Set, Ticks, Trust, World, words
from ecs_eco.cli.terminal import exits, numbers, progress, refuse, say, stopped
from ecs_eco.cli.trust import allow
from ecs_eco.config import load
from ecs_eco.lab.executors import LOCAL, check_engine, engine
from ecs_eco.lab.pretraining import train_and_evaluate


@exits
def train(
    world: World,
    ticks: Ticks = None,
    seed: Seed = None,
    set_: Set = None,
    out: Out = None,
    quiet: Quiet = False,
    on: On = LOCAL,
    trust: Trust = False,
) -> None:
    """Train a world's policies and save them."""
    allow(trust, world, set_)
    check_engine(on)
    config = load(world, set_ or [])
    seed, ticks = config.seed if seed is None else seed, ticks or config.training.ticks
    if not any(species.policy.thinks for species in config.species.values()):
        refuse("WORLD", "no species has a policy to train", world, 'a world with policy.kind = "shared"')
    with (
        results(out, f"{config.name}-policies-{seed}") as claim,
        progress(f"training {config.name}", quiet) as bar,
    ):
        out = claim.path
        try:
            if on == LOCAL:
                result = train_and_evaluate(config, seed, ticks, out, bar)
            else:
                with engine(on, 1) as pool:
                    result = pool.submit(train_and_evaluate, config, seed, ticks, out.absolute()).result()
        except KeyboardInterrupt:
            stopped(bar.done, ticks, out)
    say(f"policies of {config.name}, {ticks} ticks, seed {seed}, in {out}{numbers(result)}")
    _tell(result)
    shades = {name: species.color for name, species in config.species.items()}
    say(f"written: {write_training(result, out, shades)}")
    say(f"to use them: ecs-eco {shlex.join(['run', world, *words(policies=out, set=set_)])}")


def _tell(result: dict[str, Any]) -> None:
    """Print how each species learned, and how its results compare with those from random policies."""
    for name, of in result["learning"].items():
        cut = max(1, len(of["tick"]) // 10)
        ends = {
            w: [[v for v in part if v is not None] for part in (of[w][:cut], of[w][-cut:])]
            for w in ("reward", "entropy", "approx_kl", "explained_variance")
        }
        told = ", ".join(
            f"{w.replace('approx_kl', 'KL').replace('_', ' ')} "
            + " → ".join(number(sum(v) / len(v)) if v else "–" for v in both)
            for w, both in ends.items()
        )
        say(f"  {name}: {len(of['tick'])} updates; means of the first and last tenth: {told}")
    for name, by_word in result["against_random"].items():
        for word, of in by_word.items():
            mean, low, high = of["difference"]
            sure = "" if low is None else f" (95% interval {number(low)} to {number(high)})"
            say(
                f"  {name}: {word} {number(of['trained'][0])}, random {number(of['random'][0])}, "
                f"difference {number(mean)}{sure}"
            )
