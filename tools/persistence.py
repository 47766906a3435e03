"""The opening lines for every study of running worlds: the number of runs in which all species persisted, by
arm, and the first species to go extinct."""

from collections.abc import Callable, Mapping
from typing import Any

SEEDS = ("seed", "training", "ticks")  # case keys that do not identify its arm
NOTES = {"from_scratch": "Respawn holds numbers constant while policies learn, so no species can die out."}


def _persisted(result: Mapping[str, Any]) -> bool:
    return bool(result["persisted"])


def _none_extinct(result: Mapping[str, Any]) -> bool:
    return result["extinct"] in (None, False)


def _all_at_the_end(result: Mapping[str, Any]) -> bool:
    """Return whether all species persisted; a species that was absent from the start (in an arm without
    grazers) does not count."""
    return all(n > 0 for s, n in result["end"].items() if result["numbers"][s] > 0)


def _with_interventions(result: Mapping[str, Any]) -> bool:
    return all(n > 0 for numbers in result["numbers at the end, without and with it"] for n in numbers)


KINDS: tuple[tuple[tuple[str, ...], str, Callable[[Mapping[str, Any]], bool]], ...] = (
    (("persisted",), "All species persisted", _persisted),
    (("extinct",), "All animals persisted", _none_extinct),
    (("end", "numbers"), "All species persisted", _all_at_the_end),
    (("numbers at the end, without and with it",), "All species persisted", _with_interventions),
    (
        ("rabbits, fewest at the end of a block",),
        "All species persisted",
        lambda r: r["rabbits, fewest at the end of a block"] > 0,
    ),
    (
        ("lambs", "alive"),
        "Lambs are a cohort without offspring, so all die in time. Some lived to the end",
        lambda r: r["alive"] > 0,
    ),
)  # the result's keys, its label, and the test


MOST = 30  # arms named by all their factors


def opening(record: Mapping[str, Any]) -> str:
    """Return one or two sentences; "" for a study that does not run any world to its end.

    A study may provide its own text as record["persistence"].
    """
    if note := record.get("persistence") or NOTES.get(record["name"]):
        return str(note)
    entries = record["cases"]
    for keys, words, holds in KINDS:
        if entries and all(key in entry["result"] for entry in entries for key in keys):
            return _count(entries, words, holds)
    return ""


def _count(entries: list[dict[str, Any]], words: str, holds: Callable[[Mapping[str, Any]], bool]) -> str:
    of = [[str(v) for k, v in entry["case"].items() if k not in SEEDS] for entry in entries]
    factors = None if len(set(map(tuple, of))) <= MOST else 1  # of many arms, only the first factor is named
    arms: dict[str, list[bool]] = {}
    for entry, values in zip(entries, of, strict=True):
        arms.setdefault(", ".join(values[:factors]), []).append(holds(entry["result"]))
    n, kept = len(entries), sum(map(sum, arms.values()))
    each = "; ".join(f"{arm} {sum(runs)} of {len(runs)}" for arm, runs in arms.items())
    first = f"{words} in {kept} of {n} run{'s' * (n != 1)} ({kept / n:.0%})" + (
        f": {each}." if len(arms) > 1 and kept < n else "."
    )
    gone = [who for entry in entries if isinstance(who := entry["result"].get("extinct"), str)]
    who = ", ".join(f"{s} in {gone.count(s)}" for s in dict.fromkeys(gone))
    return first + (f" First to die out: {who}." if who else "")
