"""Do copepods migrate, flee and avoid the smell of krill, and what of it is left when one thing is taken away?

A case is an arm, a training seed and a world seed; the training seed is the replicate. Arms live with the same policies, those trained in
the world as it is shipped (happiness is energy alone), but for `untrained` and for `retrained:`, which were trained anew in a world with
light in the happiness, without krill, or both. What an arm measures:

    life      20 days after the first: cosinor of mean depth
    held      the same for 8 days with numbers held constant by respawn, as in training but with the krill of the run: an untrained policy
              starves within a day, so it is compared with the trained one here
    approach  something of the size of a krill comes straight at copepods in the dark
    survival  who lives 6 ticks after a krill came near, with numbers held constant and the 100 krill of the training
    plume     smells of krill without a krill, in the dark

How krill approach, where plumes lie, and the larger weight of light were decided after a first look at training seed 1: the world's
README says what the first designs gave.

A policy for each protocol and training seed is trained once, in about 50 s of CPU, and kept; a case finds it, or trains it first. Beside
that a case of 20 days takes 10 s of CPU, the others 1 to 5 s. All of it takes about an hour on two cores.
"""

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from _study import Study, verdict

CONSTANT, INVERTED = {"sun.kind": "constant"}, {"sun.kind": "inverted"}
NO_KRILL = {"species.krill.count": 0, 'training.set."species.krill.count"': 0}
AS_IN_LIFE = {'training.set."species.krill.count"': 40}
NO_NOSE = {"species.copepod.sensors.4.scale": 1e30, "species.copepod.sensors.5.scale": 1e30}
NO_FLOW = {"species.copepod.sensors.3.radius": 1e-6}
LIT = {"species.copepod.happiness.formula": "energy - 0.3 * light"}
MORE_LIT = {"species.copepod.happiness.formula": "energy - 0.6 * light"}
TRAINED: dict[str, dict[str, Any]] = {"shipped": {}, "light": LIT, "light without krill": LIT | NO_KRILL, "energy without krill": NO_KRILL,
                                      "twice the light without krill": MORE_LIT | NO_KRILL}  # fmt: skip
ARMS: dict[str, dict[str, Any]] = {  # what is measured, with which policies, in what world
    "shipped": {"what": "life"},
    "constant light": {"what": "life", "set": CONSTANT},
    "inverted light": {"what": "life", "set": INVERTED},
    "no krill": {"what": "life", "set": NO_KRILL},
    "no smell": {"what": "life", "set": NO_NOSE},
    "retrained: light": {"what": "life", "policies": "light"},
    "retrained: light without krill": {"what": "life", "policies": "light without krill", "set": NO_KRILL},
    "retrained: twice the light without krill": {"what": "life", "policies": "twice the light without krill", "set": NO_KRILL},
    "retrained: energy without krill": {"what": "life", "policies": "energy without krill", "set": NO_KRILL},
    "held: trained": {"what": "held", "set": AS_IN_LIFE},
    "held: untrained": {"what": "held", "set": AS_IN_LIFE, "policies": "untrained"},
    "held: constant light": {"what": "held", "set": AS_IN_LIFE | CONSTANT},
    "held: energy without krill": {"what": "held", "policies": "energy without krill", "set": NO_KRILL},
    "approach: krill": {"what": "approach", "kind": "swimming"},
    "approach: krill, no nose": {"what": "approach", "kind": "swimming", "set": NO_NOSE},
    "approach: krill, neither nose nor flow": {"what": "approach", "kind": "swimming", "set": NO_NOSE | NO_FLOW},
    "approach: krill that drift": {"what": "approach", "kind": "drifting"},
    "approach: object": {"what": "approach", "kind": "object"},
    "approach: krill, untrained": {"what": "approach", "kind": "swimming", "policies": "untrained"},
    "survival": {"what": "survival"},
    "survival: bursts no faster than cruising": {"what": "survival", "set": {"species.copepod.locomotion.speed.burst": 0.7}},
    "plume": {"what": "plume"},
    "plume: no nose": {"what": "plume", "set": NO_NOSE},
}  # fmt: skip
TRAINING_SEEDS, SEEDS = tuple(range(1, 9)), (101, 102, 103, 104)


def run(config: dict[str, Any], case: dict[str, Any]) -> dict[str, Any]:
    """Train, or find the policies, let one world live, and measure."""
    from _sea import approach, chemotaxis, encounters, life, policies_of

    from ecs_eco import World
    from ecs_eco.config import load

    arm = ARMS[case["arm"]]
    name, seed = arm.get("policies", "shipped"), case["seed"]
    if name == "untrained":
        policies, seed = "untrained", seed + 1000 * case["training"]  # networks are drawn by the seed of the world
    else:
        says = {"set": config["set"] | TRAINED[name]}
        policies = str(policies_of({"world": "diel-migration", "short training": config["training_ticks"]}, says, case["training"]))

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
    """What of the configuration a case depends on: its own arm, the policies that it lives with, and the world as it is shipped."""
    from ecs_eco.config import load

    arm = ARMS[case["arm"]]
    lengths = {"life": "days", "held": "days held", "survival": "days of encounters", "plume": "rounds"}
    return {"arm": arm, "trained": TRAINED.get(arm.get("policies", "shipped")), "world": load("diel-migration").config_hash, "set": config["set"],
            "training_ticks": config["training_ticks"], "length": config.get(lengths.get(arm["what"], ""))}  # fmt: skip


# --- what the cases say ------------------------------------------------------------------------------------------------


def interval(values: list[float]) -> list[float]:
    """Mean of values by training seed and its 95 % interval by Student's t: [mean, low, high]; no width for one value."""
    from scipy.stats import t

    mean, n = float(np.mean(values)), len(values)
    half = float(t.ppf(0.975, n - 1) * np.std(values, ddof=1) / np.sqrt(n)) if n > 1 else 0.0
    return [round(mean, 3), round(mean - half, 3), round(mean + half, 3)]


def contrast(a: list[float], b: list[float]) -> tuple[list[float], float]:
    """Difference of the means of two sets of training seeds with its 95 % interval, and p, one-sided, by Welch's t."""
    from scipy.stats import ttest_ind

    if min(len(a), len(b)) < 2:
        return [round(float(np.mean(a) - np.mean(b)), 3)] * 3, float("nan")
    found = ttest_ind(a, b, equal_var=False)
    low, high = found.confidence_interval(0.95)
    p = float(found.pvalue) / 2 if found.statistic > 0 else 1 - float(found.pvalue) / 2
    return [round(float(np.mean(a) - np.mean(b)), 3), round(float(low), 3), round(float(high), 3)], p


def with_p(found: list[float], p: float) -> str:
    """An interval and a p in words."""
    return f"{found[0]:.3g} ({found[1]:.3g} … {found[2]:.3g}), p = {p:.2g}"


def by_training(cases: list[dict[str, Any]], arm: str, value: Any) -> list[float]:
    """Mean over world seeds of a value of results, by training seed; what is None is left out."""
    found: dict[int, list[float]] = {}
    for c in cases:
        if c["case"]["arm"] == arm and (v := value(c["result"])) is not None and np.isfinite(v):
            found.setdefault(c["case"]["training"], []).append(float(v))
    return [float(np.mean(v)) for _, v in sorted(found.items())]


def swing(result: dict[str, Any]) -> float | None:
    """Amplitude along the day, as a share of the water: above zero where they are deepest around noon."""
    return None if result["cycle"] is None else result["cycle"]["vector"][0]


def summarise(cases: list[dict[str, Any]]) -> dict[str, Any]:
    """Verdicts on migration, its ablations, escape and chemotaxis, and a table of all arms."""
    there = {c["case"]["arm"] for c in cases}
    results = {arm: [c["result"] for c in cases if c["case"]["arm"] == arm] for arm in ARMS if arm in there}
    out = [*_migration(cases, results), *_ablations(cases, results), *_escape(cases, results), *_plume(cases, results)]
    rows = [_row(cases, arm, found) for arm, found in results.items() if ARMS[arm]["what"] in ("life", "held")]
    head = ["arm", "policies", "runs", "with a cycle", "amplitude along the day, by training seed: mean (95 %)", "amplitude, median of runs",
            "r ≥ 0.6", "deeper by day", "copepods at the end, mean", "days lived, mean"]  # fmt: skip
    return {"verdicts": out, "table": {"head": head, "rows": rows}, "notes": NOTES}


NOTES = ("Amplitudes are shares of the depth of the water, half of the height of the wave. Arms live with the policies of the shipped world, "
         "the same in all, but `retrained:`, whose policies were trained in the world that they live in, and `untrained`.")  # fmt: skip


def _row(cases: list[dict[str, Any]], arm: str, found: list[dict[str, Any]]) -> list[Any]:
    cycles = [r["cycle"] for r in found if r["cycle"] is not None]
    swings = by_training(cases, arm, swing)
    steady = sum(c["r"] is not None and c["r"] >= 0.6 for c in cycles)
    return [arm, ARMS[arm].get("policies", "shipped"), len(found), len(cycles), interval(swings) if swings else None,
            round(float(np.median([c["amplitude"] for c in cycles])), 3) if cycles else None, f"{steady} of {len(cycles)}",
            f"{sum(c['vector'][0] > 0 for c in cycles)} of {len(cycles)}", round(float(np.mean([r["copepods"] for r in found])), 1),
            round(float(np.mean([r["days lived"] for r in found])), 1)]  # fmt: skip


def _migration(cases: list[dict[str, Any]], results: dict[str, Any]) -> list[dict[str, Any]]:
    from ecs_eco.analysis.migration import Cosinor, p_common_phase

    cycles = [r["cycle"] for r in results.get("shipped", ())]
    if not cycles:
        return []
    lived = [c for c in cycles if c is not None]
    n = len(cycles)
    seeds = sorted({c["case"]["training"] for c in cases if c["case"]["arm"] == "shipped" and c["result"]["cycle"] is not None})
    vectors = [np.mean([c["result"]["cycle"]["vector"] for c in cases if c["case"]["arm"] == "shipped" and c["case"]["training"] == k
                        and c["result"]["cycle"] is not None], axis=0) for k in seeds]  # fmt: skip
    fits = [Cosinor(0.0, float(np.hypot(*v)), float(np.arctan2(v[1], v[0]) % (2 * np.pi))) for v in vectors]
    p = p_common_phase(fits) if fits else 1.0
    days = max((c["p"] for c in lived if c["p"] is not None), default=1.0)
    steady = sum(c["r"] is not None and c["r"] >= 0.6 for c in lived) / n
    deeper = sum(c["vector"][0] > 0 for c in lived)
    amplitude = float(np.median([0.0 if c is None else c["amplitude"] for c in cycles]))
    return [
        verdict("population-mean cosinor over training seeds: p by turning their phases", round(p, 4), "below 0.01", p < 0.01),
        verdict("cosinor of each run: largest p by turning whole days", round(days, 4), "below 0.01", days < 0.01),
        verdict("runs in which copepods are deeper by day", f"{deeper} of {n}", "all", deeper == n),
        verdict("amplitude as a share of the water, median of runs", round(amplitude, 3), "at least 0.25", amplitude >= 0.25),
        verdict("share of runs in which mean depth correlates with light by at least 0.6", round(steady, 3), "at least 0.9", steady >= 0.9),
    ]


def _ablations(cases: list[dict[str, Any]], results: dict[str, Any]) -> list[dict[str, Any]]:
    of = {arm: by_training(cases, arm, swing) for arm in results if ARMS[arm]["what"] in ("life", "held")}
    sizes = {arm: by_training(cases, arm, lambda r: None if r["cycle"] is None else r["cycle"]["amplitude"]) for arm in of}
    out = []

    def have(*arms: str) -> bool:
        return all(of.get(arm) for arm in arms)

    for arm, base in (("constant light", "shipped"), ("held: constant light", "held: trained")):
        if have(arm, base):
            share = float(np.mean(sizes[arm]) / np.mean(sizes[base]))
            out.append(verdict(f"amplitude of `{arm}` over that of `{base}`", round(share, 3), "below 0.2", share < 0.2))
    if have("inverted light"):
        found = interval(of["inverted light"])
        out.append(verdict("inverted light: amplitude along the day over training seeds, mean (95 %)", found, "below 0", found[2] < 0))
    if have("held: trained", "held: untrained"):
        gap, p = contrast(of["held: trained"], of["held: untrained"])
        out.append(verdict("numbers held: amplitude along the day, trained less untrained (95 %)", gap, "above 0", gap[1] > 0))
    for arm, words in (("retrained: light without krill", "energy - 0.3 light"), ("retrained: twice the light without krill", "energy - 0.6 light")):
        if have(arm):
            found = interval(of[arm])
            out.append(verdict(f"the paper's confound: happiness is {words}, no krill: amplitude along the day (95 %)", found, "above 0", found[1] > 0))
    if have("shipped"):
        found = interval(of["shipped"])
        out.append(verdict("energy-only with krill: amplitude along the day (95 %)", found, "above 0", found[1] > 0))
    for words, with_, without in (("", "shipped", "retrained: energy without krill"), (", numbers held", "held: trained", "held: energy without krill")):
        if have(with_, without):
            gap, p = contrast(of[with_], of[without])
            out.append(verdict(f"energy-only{words}: amplitude along the day, trained and living with krill less without (95 %; p one-sided)",
                               with_p(gap, p), "above 0, p < 0.05", gap[1] > 0 and p < 0.05))
    return out


def _escape(cases: list[dict[str, Any]], results: dict[str, Any]) -> list[dict[str, Any]]:
    out = []
    smelling, blind = "approach: krill", "approach: krill, no nose"
    for arm in (a for a in results if ARMS[a]["what"] == "approach"):
        gain = by_training(cases, arm, lambda r: r.get("gain"))
        if not gain:
            continue
        found, flees = interval(gain), arm in (smelling, blind)
        out.append(verdict(f"{arm}: fastest within 2 ticks over the speed before (95 %)", found, "at least 2" if flees else "below 2",
                           found[0] >= 2 if flees else found[2] < 2))  # fmt: skip
        if flees:
            out += [_directed(cases, arm), _latency(arm, results[arm])]
    for arm, other in ((smelling, "approach: object"), (blind, "approach: krill, neither nose nor flow")):
        two = [by_training(cases, a, _away) for a in (arm, other)]
        if all(two):
            gap, _ = contrast(*two)
            out.append(verdict(f"cosine of the way and away, {arm.removeprefix('approach: ')} less {other.removeprefix('approach: ')} (95 %)", gap, "above 0",
                               gap[1] > 0))  # fmt: skip
    two = ("survival", "survival: bursts no faster than cruising")
    with_, without = (by_training(cases, arm, lambda r: r["survived"]) for arm in two)
    if with_ and without:
        gap, _ = contrast(with_, without)
        out.append(verdict("encounters survived, with fast bursts less with slow ones (95 %)", [interval(with_)[0], interval(without)[0], gap], "above 0",
                           gap[1] > 0))
    return out


def _away(result: dict[str, Any]) -> float | None:
    return result["way"][0] if result.get("way") else None


def _directed(cases: list[dict[str, Any]], arm: str) -> dict[str, Any]:
    """Whether they swim away: the mean way of a training seed is one direction of the V-test."""
    from ecs_eco.analysis.migration import v_test

    parts = [by_training(cases, arm, lambda r, k=k: r["way"][k] if r.get("way") else None) for k in (0, 1)]
    away, aside = np.array(parts)
    p = v_test(away / np.hypot(away, aside))[1]
    found = interval(away.tolist())
    return verdict(f"{arm}: cosine of the way and away in that tick and the next two (95 %); p by V-test of the mean ways of training seeds",
                   with_p(found, p), "above 0, p < 0.001", found[1] > 0 and p < 0.001)  # fmt: skip


def _latency(arm: str, results: list[dict[str, Any]]) -> dict[str, Any]:
    known = [(r["latency"], r["latency [s]"]) for r in results if r.get("latency") is not None]
    ticks, seconds = np.median(known, axis=0) if known else (float("nan"),) * 2
    words = f"{ticks:g} ticks, {seconds:g} s; {len(known)} of {len(results)} runs"
    return verdict(f"{arm}: ticks until twice the speed before, median of runs", words, "stated, in all runs", len(known) == len(results))


def _plume(cases: list[dict[str, Any]], results: dict[str, Any]) -> list[dict[str, Any]]:
    out = []
    for arm in (a for a in results if ARMS[a]["what"] == "plume"):
        found = by_training(cases, arm, lambda r: r["index"])
        fewest = min(r["n"] for r in results[arm])
        if not found:
            continue
        here = interval(found)
        if arm == "plume":
            out.append(verdict("chemotaxis index near smells without a krill, in the dark (95 %)", here, "above 0", here[1] > 0))
            out.append(verdict("moves counted in the run with the fewest", fewest, "at least 200", fewest >= 200))
        else:
            out.append(verdict("the same with the nose off", here, "holds 0", here[1] <= 0 <= here[2]))
    return out


STUDY = Study(
    name="diel_migration",
    claim="Copepods that feel energy alone migrate with the sun, flee what comes near and avoid the smell of krill, in one world with one policy.",
    config={"set": {}, "days": 20, "days held": 8, "days of encounters": 6, "rounds": 30, "training_ticks": None},
    cases=[{"arm": arm, "training": t, "seed": s} for s in SEEDS for arm in ARMS for t in TRAINING_SEEDS],
    run=run,
    summarise=summarise,
    depends=depends,
    short_cases=[{"arm": arm, "training": 1, "seed": 101} for arm in ("shipped", "held: untrained", "approach: krill", "survival", "plume")],
    short_config={"days": 2, "days held": 2, "days of encounters": 1, "rounds": 1, "training_ticks": 20,
                  "set": {"sun.day": 60.0, "species.copepod.count": 40, "species.phytoplankton.count": 200, "species.copepod.ppo.horizon": 10}},
)  # fmt: skip

if __name__ == "__main__":
    STUDY.main()
