"""Advice after a diagnosis: which values in the world file to change, and in which direction."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from ecs_eco.analysis.why.case import Case, look_up

Advice = tuple[str, str, str]  # key, "higher" or "lower", effect
MOST = 6
# {s}: the species; {food}: its food; {line}: the key of that diet entry
GROWTH: tuple[Advice, ...] = (
    ("species.{s}.reproduction.rate", "higher", "{s} regrow faster"),
    ("species.{s}.reproduction.seed_rain", "higher", "{s} return to areas from which they have disappeared"),
    ("species.{s}.metabolism.photosynthesis", "higher", "{s} gain more energy from light"),
)
APPETITE: tuple[Advice, ...] = (
    ("{line}.chance", "lower", "{s} eat {food} more slowly"),
    ("{line}.satiation", "lower", "sated {s} do not eat {food}"),
    ("{line}.reach", "lower", "{s} must be closer to their food to eat"),
)
CATCH: tuple[Advice, ...] = (
    ("{line}.chance", "higher", "{s} eat {food} sooner"),
    ("{line}.gain", "higher", "a meal of {food} gives more energy"),
    ("{line}.reach", "higher", "{s} catch {food} from farther away"),
)
MORE_BIRTHS: tuple[Advice, ...] = (
    ("species.{s}.reproduction.rate", "higher", "{s} have more offspring"),
    ("species.{s}.reproduction.energy_min", "lower", "{s} can breed with less energy"),
    ("species.{s}.reproduction.spacing", "lower", "{s} can live at higher density"),
)
FEWER_BIRTHS: tuple[Advice, ...] = (
    ("species.{s}.reproduction.rate", "lower", "{s} have fewer offspring"),
    ("species.{s}.reproduction.energy_min", "higher", "{s} need more energy to breed"),
    ("species.{s}.reproduction.spacing", "higher", "{s} need more space"),
)
NEWBORN: tuple[Advice, ...] = (
    ("species.{s}.reproduction.energy_given", "higher", "newborn {s} survive longer until their first meal"),
    ("species.{s}.reproduction.energy_min", "higher", "parents of {s} can afford to give more energy"),
    ("species.{s}.reproduction.dispersal", "higher", "newborn {s} reach areas that are not overgrazed"),
)
DEADLY: tuple[Advice, ...] = (
    ("{line}.deadly", "lower", "{food} no longer kill their eaters"),
    ("{line}.chance", "lower", "{s} eat {food} less often"),
)
COSTLY: tuple[Advice, ...] = (
    ("{line}.gain", "higher", "{food} cost their eater less"),
    ("{line}.chance", "lower", "{s} eat {food} less often"),
)
REMOVED: tuple[Advice, ...] = (
    ("interventions.{i}.share", "lower", "fewer {s} are removed"),
    ("interventions.{i}.count", "lower", "fewer {s} are removed"),
    ("interventions.{i}.every", "higher", "{s} are removed less often"),
)
LETHAL: tuple[Advice, ...] = (
    ("species.{s}.lethal.{i}.max", "higher", "{s} tolerate more {property}"),
    ("species.{s}.lethal.{i}.min", "lower", "{s} tolerate less {property}"),
)
FEWER: Advice = ("species.{s}.count", "lower", "fewer at the start")
ROOM: Advice = ("species.{s}.max_count", "higher", "more can be alive at once")


def advise(
    case: Case, diagnosis: dict[str, Any], limits: dict[str, str | None] | None = None
) -> list[dict[str, Any]]:
    """Return values to change for a verdict, best remedy first, unless they are at the end of their range."""
    chosen: dict[str, dict[str, Any]] = {}
    lines: list[Advice] = []
    if (species := diagnosis["species"]) is not None:
        lines += REMEDIES[diagnosis["verdict"]](case, species, diagnosis["victim"])
    for s, limit in (limits or {}).items() if species is None else ():
        found = LIMITS[limit](case, s, s) if limit in LIMITS else ()
        lines += [(key, way, f"for more {s}: {effect}") for key, way, effect in list(found)[:2]]
    for key, way, effect in lines:
        value = look_up(case.config, key)
        usable = isinstance(value, bool | int | float | list) and not _at_end(key, value, way)
        if usable and key not in chosen:
            chosen[key] = {"key": key, "value": value, "turn": way, "effect": effect}
    return list(chosen.values())[: MOST if species is not None else None]


def _at_end(key: str, value: Any, way: str) -> bool:
    """Return whether a value must not change in this direction; advice never makes a species photosynthesize."""
    if way == "higher":
        return (key.endswith(".chance") and value >= 1) or (key.endswith(".photosynthesis") and value == 0)
    return value == 0 or (key.endswith(".count") and value <= 1)


def _filled(lines: Iterable[Advice], **words: object) -> list[Advice]:
    """Fill the placeholders in advice with names."""
    return [(key.format(**words), way, effect.format(**words)) for key, way, effect in lines]


def _appetite(case: Case, s: str, food: str) -> list[Advice]:
    """Return changes that make a species eat less of a food."""
    of = [a for f in case.diet(s) if f.eats == food for a in _filled(APPETITE, s=s, food=food, line=f.key)]
    return [*of, (f"species.{s}.metabolism.handling_time", "higher", f"{s} spend longer on each meal")]


def _catch(case: Case, s: str) -> list[Advice]:
    """Return changes that make a species take in more energy."""
    good = [f for f in case.diet(s) if f.gain > f.poison and not f.deadly]
    return [a for f in good for a in _filled(CATCH, s=s, food=f.eats, line=f.key)]


def _upkeep(case: Case, s: str) -> list[Advice]:
    out = [(f"species.{s}.metabolism.basal", "lower", f"{s} survive longer without food")]
    if costs := (case.of(s).get("locomotion") or {}).get("cost"):
        dearest = max(costs, key=lambda gait: costs[gait])
        out.append((f"species.{s}.locomotion.cost.{dearest}", "lower", f"movement costs {s} less energy"))
    return out


def _life(case: Case, s: str, victim: str) -> Iterator[Advice]:
    for i, limit in enumerate(case.of(s).get("lethal") or ()):
        if limit["property"] == "age" and limit.get("max") is not None:
            yield f"species.{s}.lethal.{i}.max", "higher", f"{s} live longer"


def _overgrazing(case: Case, s: str, victim: str) -> Iterator[Advice]:
    foods = [f.eats for f in case.diet(s) if f.gain > 0 and not case.is_animal(f.eats)]
    less, more = ({f: _appetite(case, s, f) for f in foods}, {f: _filled(GROWTH, s=f) for f in foods})
    for food in foods:
        yield from (less[food][0], more[food][0])
    yield from _filled(FEWER_BIRTHS[:1], s=s)
    for food in foods:
        yield from (*more[food][1:], *less[food][1:])
    yield from _filled([FEWER], s=s)
    for hunter in case.eaters(s):
        yield f"species.{hunter}.count", "higher", f"more {hunter} reduce {s}"


def _too_good(case: Case, s: str, victim: str) -> Iterator[Advice]:
    less, fewer = _appetite(case, s, victim), _filled(FEWER_BIRTHS, s=s)
    yield from (*less[:2], *fewer[::2], *less[2:])
    yield from (*_filled(MORE_BIRTHS[:1], s=victim), *_filled([FEWER], s=s))


def _too_few(case: Case, s: str, victim: str) -> Iterator[Advice]:
    more = _catch(case, s)
    yield from (*more[:1], *_filled(MORE_BIRTHS[:2], s=s))
    yield f"species.{s}.count", "higher", "more at the start"
    yield from (*more[1:], *_upkeep(case, s), *_life(case, s, s))


def _poisoned(case: Case, s: str, victim: str) -> Iterator[Advice]:
    for f in case.diet(s):
        if f.deadly:
            yield from _filled(DEADLY, s=s, food=f.eats, line=f.key)
        if f.poison > 0:
            yield f"species.{f.eats}.defence.poison", "lower", f"{f.eats} cost their eater less"
            if (look_up(case.config, f"{f.key}.gain") or 0) < 0:
                yield from _filled(COSTLY, s=s, food=f.eats, line=f.key)
            yield f"species.{f.eats}.count", "lower", f"fewer {f.eats} can be eaten"
    yield f"species.{s}.reflex", "higher", f"a reflex may prevent {s} from eating it"


def _starved(case: Case, s: str, victim: str) -> Iterator[Advice]:
    yield from (*_catch(case, s), *_upkeep(case, s))
    for i, sensor in enumerate(case.of(s).get("sensors") or ()):
        if sensor.get("target") in {f.eats for f in case.diet(s)}:
            yield f"species.{s}.sensors.{i}.range", "higher", f"{s} see {sensor['target']} from farther away"


def _failed(case: Case, s: str, victim: str) -> Iterator[Advice]:
    yield f"species.{s}.count", "higher", f"more {s} at the start"
    yield from (*_filled(GROWTH, s=s), *_catch(case, victim))


def _unborn(case: Case, s: str, victim: str) -> Iterator[Advice]:
    yield from _filled(MORE_BIRTHS, s=s)
    yield f"species.{s}.reproduction.reach", "higher", "mates find each other from farther away"
    yield from (*_life(case, s, s), *_filled([ROOM], s=s))


def _removed(case: Case, s: str, victim: str) -> Iterator[Advice]:
    for i, order in enumerate(case.config.get("interventions") or ()):
        if order.get("kind") == "cull" and order.get("species") == s:
            yield from _filled(REMOVED, s=s, i=i)


def _surroundings(case: Case, s: str, victim: str) -> Iterator[Advice]:
    for i, limit in enumerate(case.of(s).get("lethal") or ()):
        if limit["property"] not in ("energy", "age"):
            yield from _filled(LETHAL, s=s, i=i, property=limit["property"])


Remedies = Callable[[Case, str, str], Iterable[Advice]]  # (case, species responsible, its victim) → advice
LIMITS: dict[str | None, Remedies] = {
    "food": lambda case, s, _: [*_catch(case, s)[:1], *_upkeep(case, s)[:1]],
    "predators": lambda case, s, _: [_appetite(case, hunter, s)[0] for hunter in case.eaters(s)],
    "poison": _poisoned,
    "age": _life,
    "room": lambda case, s, _: _filled([MORE_BIRTHS[2], ROOM], s=s),
    "removal": _removed,
    "surroundings": _surroundings,
}
"""Changes that would make a species more numerous, by limiting factor."""
REMEDIES: dict[str, Remedies] = {
    "overgrazing": _overgrazing,
    "predators too good": _too_good,
    "predators too few": _too_few,
    "newborns starve": lambda case, s, _: [*_filled(NEWBORN, s=s), *_catch(case, s), *_upkeep(case, s)],
    "poisoned": _poisoned,
    "starved amid plenty": _starved,
    "food failed": _failed,
    "energy ran out": lambda case, s, _: [*_filled(GROWTH[2:], s=s), *_upkeep(case, s)],
    "too few births": _unborn,
    "removed": _removed,
    "surroundings": _surroundings,
}
