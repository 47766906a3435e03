"""Which values of the world file to change after a diagnosis, and in which direction."""

from collections.abc import Callable, Iterator
from typing import Any

from ecs_eco.analysis.why.case import Case, look_up

Advice = tuple[str, str, str]  # key, "higher" or "lower", what it does
MOST = 6


def advise(
    case: Case, diagnosis: dict[str, Any], limits: dict[str, str | None] | None = None
) -> list[dict[str, Any]]:
    """Values to change for a verdict, the likeliest first: key, value now, direction, effect.

    Values at the end of their range are left out.
    """
    chosen: dict[str, dict[str, Any]] = {}
    if diagnosis["species"] is None:
        of_limits = [
            (s, line) for s, limit in (limits or {}).items() for line in list(_of_limit(case, s, limit))[:2]
        ]
        lines = [(key, way, f"for more {s}: {effect}") for s, (key, way, effect) in of_limits]
    else:
        lines = list(REMEDIES[diagnosis["verdict"]](case, diagnosis["species"], diagnosis["victim"]))
    for key, way, effect in lines:
        value = look_up(case.config, key)
        if (
            isinstance(value, bool | int | float | list)
            and key not in chosen
            and not _at_end(key, value, way)
        ):
            chosen[key] = {"key": key, "value": value, "turn": way, "effect": effect}
    return list(chosen.values()) if diagnosis["species"] is None else list(chosen.values())[:MOST]


def _at_end(key: str, value: Any, way: str) -> bool:
    """Whether a value cannot go further that way: numbers below 1, chances above 1;
    species without growth by light stay so."""
    if way == "higher":
        return (key.endswith(".chance") and value >= 1) or (key.endswith(".growth") and value == 0)
    return value == 0 or (key.endswith(".count") and value <= 1)


def _growth(case: Case, s: str) -> Iterator[Advice]:
    """Changes for more of a plant or of prey."""
    base = f"species.{s}"
    yield f"{base}.reproduction.rate", "higher", f"{s} grow back faster"
    yield f"{base}.reproduction.seed_rain", "higher", f"{s} come back where they are gone"
    yield f"{base}.metabolism.growth", "higher", f"{s} make more energy of light"


def _appetite(case: Case, eater: str, food: str) -> Iterator[Advice]:
    """Changes that let one eater take less of one food."""
    for f in case.diet(eater):
        if f.eats == food:
            yield f"{f.key}.chance", "lower", f"{eater} take {food} more slowly"
            yield f"{f.key}.until", "lower", f"sated {eater} leave {food} alone"
            yield f"{f.key}.reach", "lower", f"{eater} must come closer to eat"
    yield f"species.{eater}.metabolism.digestion", "higher", f"a meal keeps {eater} busy"


def _catch(case: Case, eater: str) -> Iterator[Advice]:
    """Changes that let an eater take in more."""
    for f in case.diet(eater):
        if f.gain > f.poison and not f.deadly:
            yield f"{f.key}.chance", "higher", f"{eater} take {f.eats} sooner"
            yield f"{f.key}.gain", "higher", f"a meal of {f.eats} is worth more"
            yield f"{f.key}.reach", "higher", f"{eater} catch {f.eats} from further away"


def _upkeep(case: Case, s: str) -> Iterator[Advice]:
    yield f"species.{s}.metabolism.basal", "lower", f"{s} live longer without food"
    costs = (case.of(s).get("locomotion") or {}).get("cost") or {}
    if costs:
        yield (
            f"species.{s}.locomotion.cost.{max(costs, key=lambda g: costs[g])}",
            "lower",
            f"moving costs {s} less",
        )


def _births(case: Case, s: str, way: str) -> Iterator[Advice]:
    """Changes for more births of a species, or fewer."""
    base, other = f"species.{s}.reproduction", {"higher": "lower", "lower": "higher"}[way]
    yield f"{base}.rate", way, f"{s} bear {'more' if way == 'higher' else 'fewer'} young"
    yield f"{base}.energy_min", other, f"{'leaner' if way == 'higher' else 'only fatter'} {s} breed"
    yield f"{base}.spacing", other, f"{s} {'crowd closer' if way == 'higher' else 'need room of their own'}"


def _life(case: Case, s: str) -> Iterator[Advice]:
    for i, limit in enumerate(case.of(s).get("lethal") or ()):
        if limit["property"] == "age" and limit.get("max") is not None:
            yield f"species.{s}.lethal.{i}.max", "higher", f"{s} live longer"


def _overgrazing(case: Case, s: str, victim: str) -> Iterator[Advice]:
    foods = [f.eats for f in case.diet(s) if f.gain > 0 and not case.is_animal(f.eats)]
    for food in foods:
        yield from list(_appetite(case, s, food))[:1]
        yield from list(_growth(case, food))[:1]
    yield from list(_births(case, s, "lower"))[:1]
    for food in foods:
        yield from list(_growth(case, food))[1:]
        yield from list(_appetite(case, s, food))[1:]
    yield f"species.{s}.count", "lower", "fewer at the start"
    for hunter in case.eaters(s):
        yield f"species.{hunter}.count", "higher", f"more {hunter} hold {s} down"


def _too_good(case: Case, s: str, victim: str) -> Iterator[Advice]:
    yield from list(_appetite(case, s, victim))[:2]
    yield from list(_births(case, s, "lower"))[:3:2]
    yield from list(_appetite(case, s, victim))[2:]
    yield from list(_births(case, victim, "higher"))[:1]
    yield f"species.{s}.count", "lower", "fewer at the start"


def _too_few(case: Case, s: str, victim: str) -> Iterator[Advice]:
    yield from list(_catch(case, s))[:1]
    yield from list(_births(case, s, "higher"))[:2]
    yield f"species.{s}.count", "higher", "more at the start"
    yield from list(_catch(case, s))[1:]
    yield from _upkeep(case, s)
    yield from _life(case, s)


def _newborns(case: Case, s: str, victim: str) -> Iterator[Advice]:
    base = f"species.{s}.reproduction"
    yield f"{base}.energy_given", "higher", f"newborn {s} last longer until their first meal"
    yield f"{base}.energy_min", "higher", f"parents of {s} can afford to give more"
    yield f"{base}.dispersal", "higher", f"newborn {s} come to places that are not eaten bare"
    yield from _catch(case, s)
    yield from _upkeep(case, s)


def _poisoned(case: Case, s: str, victim: str) -> Iterator[Advice]:
    for f in case.diet(s):
        if f.deadly:
            yield f"{f.key}.deadly", "lower", f"{f.eats} no longer kill their eaters"
            yield f"{f.key}.chance", "lower", f"{s} take {f.eats} more rarely"
        if f.poison > 0:
            yield f"species.{f.eats}.defence.poison", "lower", f"{f.eats} cost their eater less"
            if (look_up(case.config, f"{f.key}.gain") or 0) < 0:
                yield f"{f.key}.gain", "higher", f"{f.eats} cost their eater less"
                yield f"{f.key}.chance", "lower", f"{s} take {f.eats} more rarely"
            yield f"species.{f.eats}.count", "lower", f"fewer {f.eats} to be taken"
    yield f"species.{s}.reflex", "higher", f"a reflex may keep {s} from eating it"


def _starved(case: Case, s: str, victim: str) -> Iterator[Advice]:
    yield from _catch(case, s)
    yield from _upkeep(case, s)
    for i, sensor in enumerate(case.of(s).get("sensors") or ()):
        if sensor.get("target") in {f.eats for f in case.diet(s)}:
            yield f"species.{s}.sensors.{i}.radius", "higher", f"{s} see {sensor['target']} from further away"


def _ran_out(case: Case, s: str, victim: str) -> Iterator[Advice]:
    yield f"species.{s}.metabolism.growth", "higher", f"{s} make more energy of light"
    yield from _upkeep(case, s)


def _failed(case: Case, s: str, victim: str) -> Iterator[Advice]:
    yield f"species.{s}.count", "higher", f"more {s} at the start"
    yield from _growth(case, s)
    yield from _catch(case, victim)


def _unborn(case: Case, s: str, victim: str) -> Iterator[Advice]:
    yield from _births(case, s, "higher")
    yield f"species.{s}.reproduction.reach", "higher", "mates find each other from further away"
    yield from _life(case, s)
    yield f"species.{s}.max_count", "higher", "more may live at once"


def _removed(case: Case, s: str, victim: str) -> Iterator[Advice]:
    for i, intervention in enumerate(case.config.get("interventions") or ()):
        if intervention.get("kind") == "cull" and intervention.get("species") == s:
            yield f"interventions.{i}.share", "lower", f"fewer {s} are taken"
            yield f"interventions.{i}.count", "lower", f"fewer {s} are taken"
            yield f"interventions.{i}.every", "higher", f"{s} are taken more rarely"


def _surroundings(case: Case, s: str, victim: str) -> Iterator[Advice]:
    for i, limit in enumerate(case.of(s).get("lethal") or ()):
        if limit["property"] not in ("energy", "age"):
            yield f"species.{s}.lethal.{i}.max", "higher", f"{s} bear more {limit['property']}"
            yield f"species.{s}.lethal.{i}.min", "lower", f"{s} bear less {limit['property']}"


def _of_limit(case: Case, s: str, limit: str | None) -> Iterator[Advice]:
    """Changes that would make a species more numerous, given what limits it."""
    if limit == "food":
        yield from list(_catch(case, s))[:1]
        yield from list(_upkeep(case, s))[:1]
    elif limit == "predators":
        for hunter in case.eaters(s):
            yield from list(_appetite(case, hunter, s))[:1]
    elif limit == "poison":
        yield from _poisoned(case, s, s)
    elif limit == "age":
        yield from _life(case, s)
    elif limit == "room":
        yield f"species.{s}.reproduction.spacing", "lower", f"{s} crowd closer"
        yield f"species.{s}.max_count", "higher", "more may live at once"
    elif limit == "removal":
        yield from _removed(case, s, s)
    elif limit == "surroundings":
        yield from _surroundings(case, s, s)


REMEDIES: dict[str, Callable[[Case, str, str], Iterator[Advice]]] = {
    "overgrazing": _overgrazing,
    "predators too good": _too_good,
    "predators too few": _too_few,
    "newborns starve": _newborns,
    "poisoned": _poisoned,
    "starved amid plenty": _starved,
    "food failed": _failed,
    "energy ran out": _ran_out,
    "too few births": _unborn,
    "removed": _removed,
    "surroundings": _surroundings,
}
