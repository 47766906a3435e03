"""Do copepods migrate, flee and avoid the smell of krill, and how much of this remains when one factor is
removed?

Each case combines an arm, a training seed and a world seed; the training seed is the replicate. All arms
share the policies trained in the shipped world (where happiness is energy alone), except `untrained` and
`retrained:`, whose policies were trained with light as part of happiness, without krill, or both. Each arm
measures one of these:

    life      20 days after the first: cosinor of mean depth
    held      the same for 8 days with population sizes held constant by respawn, as in training but with the
              run's krill; it compares trained with untrained policies, which starve within a day
    approach  a krill-sized object approaches copepods head-on in the dark
    survival  the share alive 6 ticks after a krill came within 2 m, and the number killed, with population
              sizes held constant and the 100 krill used in training
    plume     the smell of krill without krill, in the dark: whether copepods move away from it,
              and whether the horizontal components of their moves do

We chose the krill's approach, the plumes' positions and the larger light weight after seeing results for
training seed 1; the world's README reports the results of the first designs.

Each combination of protocol and training seed needs one trained policy, which takes about 50 s of CPU time
and is then stored. In addition, a 20-day case takes 10 s of CPU time and other cases take 1 to 5 s. The whole
study takes about an hour on two cores.
"""

from typing import Any

import numpy as np

from studies.common.study import Study, verdict
from studies.common.training_seeds import by_training, contrast, in_words, interval, none, swing

CONSTANT, INVERTED = {"sun.kind": "constant"}, {"sun.kind": "inverted"}
NO_KRILL = {"species.krill.count": 0, 'training.set."species.krill.count"': 0}
AS_IN_LIFE = {'training.set."species.krill.count"': 40}
NO_NOSE = {"species.copepod.sensors.4.scale": 1e30, "species.copepod.sensors.5.scale": 1e30}
NO_FLOW = {"species.copepod.sensors.3.range": 1e-6}
LIT = {"species.copepod.happiness.formula": "energy - 0.3 * light"}
MORE_LIT = {"species.copepod.happiness.formula": "energy - 0.6 * light"}
TRAINED: dict[str, dict[str, Any]] = {
    "shipped": {},
    "light": LIT,
    "light without krill": LIT | NO_KRILL,
    "energy without krill": NO_KRILL,
    "twice the light without krill": MORE_LIT | NO_KRILL,
}
ARMS: dict[str, dict[str, Any]] = {  # each arm's measure, policies and world
    "shipped": {"what": "life"},
    "constant light": {"what": "life", "set": CONSTANT},
    "inverted light": {"what": "life", "set": INVERTED},
    "no krill": {"what": "life", "set": NO_KRILL},
    "no smell": {"what": "life", "set": NO_NOSE},
    "retrained: light": {"what": "life", "policies": "light"},
    "retrained: light without krill": {"what": "life", "policies": "light without krill", "set": NO_KRILL},
    "retrained: twice the light without krill": {
        "what": "life",
        "policies": "twice the light without krill",
        "set": NO_KRILL,
    },
    "retrained: energy without krill": {"what": "life", "policies": "energy without krill", "set": NO_KRILL},
    "held: trained": {"what": "held", "set": AS_IN_LIFE},
    "held: untrained": {"what": "held", "set": AS_IN_LIFE, "policies": "untrained"},
    "held: constant light": {"what": "held", "set": AS_IN_LIFE | CONSTANT},
    "held: energy without krill": {"what": "held", "policies": "energy without krill", "set": NO_KRILL},
    "approach: krill": {"what": "approach", "kind": "swimming"},
    "approach: krill, no nose": {"what": "approach", "kind": "swimming", "set": NO_NOSE},
    "approach: krill, neither nose nor flow": {
        "what": "approach",
        "kind": "swimming",
        "set": NO_NOSE | NO_FLOW,
    },
    "approach: krill that drift": {"what": "approach", "kind": "drifting"},
    "approach: object": {"what": "approach", "kind": "object"},
    "approach: krill, untrained": {"what": "approach", "kind": "swimming", "policies": "untrained"},
    "survival": {"what": "survival"},
    "survival: bursts no faster than cruising": {
        "what": "survival",
        "set": {"species.copepod.locomotion.speed.burst": 0.7},
    },
    "plume": {"what": "plume"},
    "plume: no nose": {"what": "plume", "set": NO_NOSE},
}
# version of each measure: cases from earlier versions are rerun
MEASURED = {"approach": 2, "survival": 2, "plume": 2}
TRAINING_SEEDS, SEEDS = tuple(range(1, 9)), (101, 102, 103, 104)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Train or reuse the policies, run one world, and measure."""
    from ecs_eco import World
    from ecs_eco.config import load
    from studies.common.sea import approach, chemotaxis, encounters, life, policies_of

    arm = ARMS[case["arm"]]
    name, seed = arm.get("policies", "shipped"), case["seed"]
    if name == "untrained":
        # the world seed determines the random networks
        policies, seed = "untrained", seed + 1000 * case["training"]
    else:
        says = {"set": config["set"] | TRAINED[name]}
        policies = str(
            policies_of(
                {"world": "diel-migration", "short training": config["training_ticks"]},
                says,
                case["training"],
            )
        )

    def build(changes: dict[str, Any], training: bool = False) -> Any:
        here = load("diel-migration", config["set"] | arm.get("set", {}) | changes)
        return World.from_config(here, seed=seed, policies=policies, learn=False, training=training)

    what = arm["what"]
    if what in ("life", "held"):
        return life(build({}, training=what == "held"), config["days" if what == "life" else "days held"])
    if what == "approach":
        return approach(build, arm["kind"])
    if what == "survival":
        return encounters(build({}, training=True), config["days of encounters"])
    return chemotaxis(build, config["rounds"])


def depends(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Return the configuration entries that a case depends on: its arm, its policies, and the shipped world.

    Versions of corrected measures are also included. In the measure over days, only p was corrected, and only
    the p of `shipped` is used.
    """
    from ecs_eco.config import load

    arm = ARMS[case["arm"]]
    lengths = {"life": "days", "held": "days held", "survival": "days of encounters", "plume": "rounds"}
    return {
        "arm": arm,
        "trained": TRAINED.get(arm.get("policies", "shipped")),
        "world": load("diel-migration").config_hash,
        "set": config["set"],
        "training_ticks": config["training_ticks"],
        "length": config.get(lengths.get(arm["what"], "")),
        **({"measured": n} if (n := 2 if case["arm"] == "shipped" else MEASURED.get(arm["what"])) else {}),
    }


# --- conclusions ----------------------------------------------------------------------------------------------


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Return verdicts on migration, its ablations, escape and chemotaxis, and a table of all arms."""
    there = {c["case"]["arm"] for c in cases}
    results = {arm: [c["result"] for c in cases if c["case"]["arm"] == arm] for arm in ARMS if arm in there}
    out = [
        *_migration(cases, results),
        *_ablations(cases, results),
        *_escape(cases, results),
        *_plume(cases, results),
    ]
    rows = [
        _row(cases, arm, lives) for arm, lives in results.items() if ARMS[arm]["what"] in ("life", "held")
    ]
    head = [
        "arm",
        "policies",
        "runs",
        "runs with a cycle",
        "amplitude in phase with daylight, mean over training seeds (95%)",
        "amplitude, median of runs",
        "runs with r ≥ 0.6",
        "runs in which copepods are deeper by day",
        "mean number of copepods at the end",
        "mean days survived",
    ]
    return {"verdicts": out, "table": {"head": head, "rows": rows}, "notes": NOTES}


NOTES = (
    "Amplitudes, half the height of the wave, are shares of the water's depth. All arms have the policies of the "
    "shipped world, except `retrained:`, whose policies were trained in their own world, and `untrained`."
)


def _row(cases: list[dict[str, Any]], arm: str, lives: list[dict[str, Any]]) -> list[Any]:
    cycles = [r["cycle"] for r in lives if r["cycle"] is not None]
    swings = by_training(cases, arm, swing)
    steady = sum(c["r"] is not None and c["r"] >= 0.6 for c in cycles)
    return [
        arm,
        ARMS[arm].get("policies", "shipped"),
        len(lives),
        len(cycles),
        in_words(interval(swings), len(swings)) if swings else None,
        round(float(np.median([c["amplitude"] for c in cycles])), 3) if cycles else None,
        f"{steady} of {len(cycles)}",
        f"{sum(c['vector'][0] > 0 for c in cycles)} of {len(cycles)}",
        round(float(np.mean([r["copepods"] for r in lives])), 1),
        round(float(np.mean([r["days survived"] for r in lives])), 1),
    ]


def _migration(cases: list[dict[str, Any]], results: dict[str, Any]) -> list[dict[str, Any]]:
    from ecs_eco.analysis.rhythm import Cosinor
    from studies.common.training_seeds import p_common_phase

    cycles = [r["cycle"] for r in results.get("shipped", ())]
    if not cycles:
        return []
    lived = [c for c in cycles if c is not None]
    n = len(cycles)
    seeds = sorted(
        {
            c["case"]["training"]
            for c in cases
            if c["case"]["arm"] == "shipped" and c["result"]["cycle"] is not None
        }
    )
    vectors = [
        np.mean(
            [
                c["result"]["cycle"]["vector"]
                for c in cases
                if c["case"]["arm"] == "shipped"
                and c["case"]["training"] == k
                and c["result"]["cycle"] is not None
            ],
            axis=0,
        )
        for k in seeds
    ]
    fits = [Cosinor(0.0, float(np.hypot(*v)), float(np.arctan2(v[1], v[0]) % (2 * np.pi))) for v in vectors]
    p = p_common_phase(fits) if fits else 1.0
    days = max(1.0 if c is None or c["p"] is None else c["p"] for c in cycles)
    steady = sum(c["r"] is not None and c["r"] >= 0.6 for c in lived) / n
    deeper = sum(c["vector"][0] > 0 for c in lived)
    amplitude = float(np.median([0.0 if c is None else c["amplitude"] for c in cycles]))
    return [
        verdict(
            "population-mean cosinor over training seeds: p-value, by rotating their phases at random",
            round(p, 4),
            "below 0.01",
            p < 0.01,
        ),
        verdict(
            "cosinor of each run: largest p-value, by rotating whole days at random",
            round(days, 4),
            "below 0.01",
            days < 0.01,
        ),
        verdict("runs in which copepods are deeper by day", f"{deeper} of {n}", "all", deeper == n),
        verdict(
            "amplitude as a share of the water's depth, median of runs",
            round(amplitude, 3),
            "at least 0.25",
            amplitude >= 0.25,
        ),
        verdict(
            "share of runs in which mean depth correlates with light by at least 0.6",
            round(steady, 3),
            "at least 0.9",
            steady >= 0.9,
        ),
    ]


def _ablations(cases: list[dict[str, Any]], results: dict[str, Any]) -> list[dict[str, Any]]:
    of = {arm: by_training(cases, arm, swing) for arm in results if ARMS[arm]["what"] in ("life", "held")}
    sizes = {
        arm: by_training(cases, arm, lambda r: None if r["cycle"] is None else r["cycle"]["amplitude"])
        for arm in of
    }
    out = [none(arm) for arm in of if not of[arm]]

    def have(*arms: str) -> bool:
        return all(of.get(arm) for arm in arms)

    def alone(arm: str, words: str, goal: str, met: Any) -> None:
        if have(arm):
            amplitude = interval(of[arm])
            out.append(
                verdict(
                    f"{words}: amplitude in phase with daylight (95%)",
                    in_words(amplitude, len(of[arm])),
                    goal,
                    met(amplitude),
                )
            )

    def less(words: str, one: str, other: str, below: float | None = None) -> None:
        if have(one, other):
            gap, p = contrast(of[one], of[other])
            goal, interval_text = (
                ("above 0", "95%") if below is None else (f"above 0, p < {below:g}", "95%; one-sided p-value")
            )
            out.append(
                verdict(
                    f"{words} ({interval_text})",
                    in_words(gap, min(len(of[one]), len(of[other])), p),
                    goal,
                    gap[1] > 0 and (below is None or p < below),
                )
            )

    for arm, base in (("constant light", "shipped"), ("held: constant light", "held: trained")):
        if have(arm, base):
            share = float(np.mean(sizes[arm]) / np.mean(sizes[base]))
            n = sum(r["cycle"] is not None for r in results[arm])
            words = f"{share:.3f}; {n} of {len(results[arm])} runs survived two days"
            out.append(verdict(f"amplitude of `{arm}` relative to `{base}`", words, "below 0.2", share < 0.2))
    alone("inverted light", "inverted light", "below 0", lambda x: x[2] < 0)
    less(
        "constant numbers: amplitude in phase with daylight, trained minus untrained",
        "held: trained",
        "held: untrained",
    )
    alone(
        "retrained: light without krill",
        "the paper's confound: happiness is energy - 0.3 light, no krill",
        "above 0",
        lambda x: x[1] > 0,
    )
    alone(
        "retrained: twice the light without krill",
        "the paper's confound: happiness is energy - 0.6 light, no krill",
        "above 0",
        lambda x: x[1] > 0,
    )
    alone("shipped", "energy-only with krill", "above 0", lambda x: x[1] > 0)
    words = "amplitude in phase with daylight, trained and living with krill minus without krill"
    less(f"energy-only: {words}", "shipped", "retrained: energy without krill", 0.05)
    less(f"energy-only, constant numbers: {words}", "held: trained", "held: energy without krill", 0.05)
    return out


SENSELESS = "approach: krill, neither nose nor flow"
FLEEING = ("approach: krill", "approach: krill, no nose")


def _escape(cases: list[dict[str, Any]], results: dict[str, Any]) -> list[dict[str, Any]]:
    out = []
    for arm in (a for a in results if ARMS[a]["what"] == "approach"):
        gain = by_training(cases, arm, lambda r: r.get("gain"))
        if not gain:
            out.append(none(arm))
            continue
        gain_interval, flees = interval(gain), arm in FLEEING
        out.append(
            verdict(
                f"{arm}: top speed within 2 ticks, relative to the speed before (95%)",
                in_words(gain_interval, len(gain)),
                "at least 2, and its interval" if flees else "below 2, and its interval",
                gain_interval[1] >= 2 if flees else gain_interval[2] < 2,
            )
        )
        if flees:
            out.append(_latency(arm, results[arm]))
            out += _directed(cases, arm) if SENSELESS in results else []
    two = ("survival", "survival: bursts no faster than cruising")
    for key, words, sign in (
        ("survived", "share of encounters survived", 1),
        ("kills per copepod per day", "kills per copepod per day", -1),
    ):
        with_, without = (by_training(cases, arm, lambda r, k=key: r[k]) for arm in two)
        if with_ and without:
            gap, _ = contrast(with_, without)
            means = (
                f"{np.mean(with_):.3f} and {np.mean(without):.3f}: "
                f"{in_words(gap, min(len(with_), len(without)))}"
            )
            out.append(
                verdict(
                    f"{words}, fast bursts minus slow bursts (95%)",
                    means,
                    "above 0" if sign > 0 else "below 0",
                    gap[1] > 0 if sign > 0 else gap[2] < 0,
                )
            )
    return out


def _ways(cases: list[dict[str, Any]], arm: str) -> np.ndarray:
    """Return each training seed's mean direction: the component away from the approaching object, and the
    component to the left of that, f64[training seeds, 2]."""
    parts = [by_training(cases, arm, lambda r, k=k: r["way"][k] if r.get("way") else None) for k in (0, 1)]
    return np.array(parts).T.reshape(-1, 2)


def _directed(cases: list[dict[str, Any]], arm: str) -> list[dict[str, Any]]:
    """Test whether copepods swim away more than copepods that cannot sense krill, which also end up moving
    away because krill overshoot.

    The difference between a training seed's mean directions is one direction in the V-test.
    """
    from ecs_eco.analysis.tracks import v_test

    here, control = _ways(cases, arm), _ways(cases, SENSELESS)
    if not len(here) or len(here) != len(control):
        return [none(arm)]
    beyond = here - control
    p = v_test(beyond[:, 0] / np.hypot(*beyond.T))[1] if len(beyond) > 1 else float("nan")
    difference = interval(beyond[:, 0].tolist())
    means = (
        f"{here[:, 0].mean():.2f} against {control[:, 0].mean():.2f}: {in_words(difference, len(here), p)}"
    )
    words = (
        f"{arm}: mean direction, component away from the krill in that tick and the next two, minus that of "
        "copepods that sense neither smell nor flow (95%; p-value by V-test over training seeds)"
    )
    return [verdict(words, means, "above 0, p < 0.001", difference[1] > 0 and p < 0.001)]


def _latency(arm: str, results: list[dict[str, Any]]) -> dict[str, Any]:
    known = [
        (r["latency"], r["latency [s]"])
        for r in results
        if r.get("latency") is not None and r["latency"] <= 2
    ]
    ticks, seconds = np.median(known, axis=0) if known else (float("nan"),) * 2
    words = f"{ticks:g} ticks, {seconds:g} s; {len(known)} of {len(results)} runs"
    return verdict(
        f"{arm}: ticks until the speed has doubled, median of runs",
        words,
        "within 2, in all runs",
        len(known) == len(results),
    )


def _plume(cases: list[dict[str, Any]], results: dict[str, Any]) -> list[dict[str, Any]]:
    out, of = [], {"whole paths": lambda r: r["index"], "level parts of paths": lambda r: r["level"]["index"]}
    for words, value in of.items():
        smelt, unsmelt = (by_training(cases, arm, value) for arm in ("plume", "plume: no nose"))
        if smelt:
            here = interval(smelt)
            out.append(
                verdict(
                    f"chemotaxis index near krill smell without krill, in the dark, {words} (95%)",
                    in_words(here, len(smelt)),
                    "above 0",
                    here[1] > 0,
                )
            )
        if unsmelt:
            here = interval(unsmelt)
            out.append(
                verdict(
                    f"the same without a sense of smell, {words}",
                    in_words(here, len(unsmelt)),
                    "contains 0",
                    here[1] <= 0 <= here[2],
                )
            )
    for arm in (a for a in results if ARMS[a]["what"] == "plume"):
        fewest = min(r["n"] for r in results[arm])
        out.append(verdict(f"{arm}: fewest moves counted in a run", fewest, "at least 200", fewest >= 200))
    return out


STUDY = Study(
    name="diel_migration",
    claim="Copepods that are rewarded for energy alone migrate with the sun, flee what approaches and "
    "avoid the smell of krill, in one world with one policy.",
    config={
        "set": {},
        "days": 20,
        "days held": 8,
        "days of encounters": 6,
        "rounds": 30,
        "training_ticks": None,
    },
    cases=[{"arm": arm, "training": t, "seed": s} for s in SEEDS for arm in ARMS for t in TRAINING_SEEDS],
    run=run,
    summarise=summarise,
    depends=depends,
    short_cases=[
        {"arm": arm, "training": 1, "seed": 101}
        for arm in ("shipped", "held: untrained", FLEEING[0], SENSELESS, "survival", "plume")
    ],
    short_config={
        "days": 2,
        "days held": 2,
        "days of encounters": 1,
        "rounds": 1,
        "training_ticks": 20,
        "set": {
            "sun.day": 60.0,
            "species.copepod.count": 40,
            "species.phytoplankton.count": 200,
            "species.copepod.ppo.horizon": 10,
        },
    },
)

if __name__ == "__main__":
    STUDY.main()
