"""Checks of one species' action groups."""

import math
import re
from collections.abc import Iterator

from ecs_eco.config.models.species import MOTIONS, Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.config.rules import Key, named, once
from ecs_eco.engine.errors import Problem, listed, unknown
from ecs_eco.inputs.code import SHIPPED
from ecs_eco.inputs.section import LARGEST


def check_actions(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    """Yield all problems with the species' action groups."""
    wrong = [*_check_groups(config, key, species)]
    yield from wrong
    if not wrong:  # otherwise a valid group or action name could be rejected
        yield from _check_neutral(key, species)
        yield from _check_automatic(key, species)


def _check_groups(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    groups, ranges = species.known_groups(), species.ranges()
    others = [*groups_of_systems(config), *_groups_of_exchange(species)]
    for group, actions in species.groups().items():
        at = (*key, "actions", group)
        if group not in (*groups, *others):
            if not _may_act(config):
                yield unknown(at, "action group", group, [*groups, *others])
        elif group in ranges:
            yield from _check_range(config, (*at, "continuous"), species, group, group in others)
        elif group in others:
            yield from _check_free_group(at, actions)
        else:
            yield from _check_known_group(config, at, species, group, *groups[group])


def _check_known_group(
    config: WorldConfig, at: Key, species: Species, group: str, word: str, known: list[str]
) -> Iterator[Problem]:
    """Check an action group that shipped systems handle."""
    actions = species.groups()[group]
    if group == "pitch":
        allowed = "{ continuous = [min, max] }, or the group climb with up, none and down"
        yield Problem(at, "must be continuous", actions, allowed)
        return
    if not actions:
        yield Problem(at, "is empty", actions, listed(known))
    for i, action in enumerate(actions):
        yield from named((*at, i), word, action, known)
    yield from once(at, actions, listed(known))
    ways = {"turn": ("turn",), "climb": ("climb", "pitch")}.get(group, ())
    if ways and not any(getattr(species.locomotion, way, 0) for way in ways):
        fault = f"it cannot {group}: locomotion.{group} is missing or 0"
        yield Problem(at, fault, actions, f"locomotion.{group} > 0, or remove this action group")
    if group == "climb" and config.dims == 2:
        yield Problem(at, "a plane has no up and down", actions, "a 3D space, or remove this action group")
    if group == "eat" and not species.diet:
        yield Problem(at, "it has no diet", actions, "a diet, or remove this action group")


def _check_neutral(key: Key, species: Species) -> Iterator[Problem]:
    ranges = species.ranges()
    for group, rest in species.default_action.items():
        at = (*key, "default_action", group)
        if group not in species.actions:
            yield unknown(at, "action group of the species", group, species.actions)
        elif group not in ranges:
            yield from named(at, f"action in the group {group}", str(rest), species.groups()[group])
        elif isinstance(rest, str) or not ranges[group][0] <= rest <= ranges[group][1]:
            low, high = ranges[group]
            yield Problem(at, "not a possible value of this continuous action", rest, f"{low:g} to {high:g}")


def _check_range(
    config: WorldConfig, key: Key, species: Species, group: str, free: bool
) -> Iterator[Problem]:
    """Check a continuous action; if it is `free`, a custom system handles it."""
    low, high = species.ranges()[group]
    given, at = {"continuous": [low, high]}, key[:-1]
    if not low < high:
        yield Problem(
            key, "the minimum is not below the maximum", [low, high], "two numbers, the smaller one first"
        )
    elif free:
        return
    elif group not in MOTIONS:
        allowed = f"a list of actions; only {listed(MOTIONS)} can be continuous"
        yield Problem(at, "cannot be continuous", given, allowed)
    elif species.locomotion is None:
        yield Problem(at, "locomotion is missing", given, "locomotion, or remove this action group")
    else:
        if group in ("climb", "pitch") and config.dims == 2:
            yield Problem(at, "a plane has no up and down", given, "a 3D space, or remove this action group")
        if group == "pitch" and "climb" in species.actions:
            yield Problem(at, "it already moves up and down with climb", given, "either climb or pitch")
        ends = {"speed": (0.0, max(species.locomotion.speed.values())), "pitch": (-math.pi / 2, math.pi / 2)}
        least, most = ends.get(group, (-LARGEST, LARGEST))
        if low < least or high > most:
            words = "speeds up to the fastest gait" if group == "speed" else "angles"
            yield Problem(key, "out of range", [low, high], f"{words}, {least:g} to {most:g}")


def groups_of_systems(config: WorldConfig) -> list[str]:
    """Return the action groups that the world's custom systems handle."""
    return [group for system in config.systems for group in getattr(config.known(system), "acts", ())]


def _groups_of_exchange(species: Species) -> list[str]:
    """Return the action groups during which a species exchanges or converts substances."""
    used = {getattr(way, "action", None) for way in (*species.exchange, *species.reactions)}
    known = species.known_groups()
    return [g for g, actions in species.groups().items() if g not in known and not used.isdisjoint(actions)]


def _may_act(config: WorldConfig) -> bool:
    """Return whether systems that are not yet loaded could handle unknown action groups."""
    return not config._code.allowed and any(
        isinstance(name := getattr(s, "use", s), str) and name not in SHIPPED for s in config.systems
    )


def _check_free_group(key: Key, actions: list[str]) -> Iterator[Problem]:
    if not actions:
        yield Problem(key, "is empty", actions, "names of actions")
    for i, action in enumerate(actions):
        if not re.fullmatch(r"[A-Za-z]\w{0,39}", action):
            yield Problem((*key, i), "not a name", action, "a letter, then letters, digits or _ (at most 40)")
    yield from once(key, actions, "each name once")


def _check_automatic(key: Key, species: Species) -> Iterator[Problem]:
    rows, pairs, groups = species.action_rows(), species.action_list(), species.groups()
    for i, action in enumerate(species.always_on):
        at = (*key, "always_on", i)
        if action not in rows:
            yield unknown(at, "action of the species", action, rows)
        elif (group := pairs[rows[action]][0]) in species.ranges():
            yield Problem(at, "is continuous and so always executed", action, "the only action of its group")
        elif len(groups[group]) > 1:
            allowed = f"the only action of its group: {listed(a[0] for a in groups.values() if len(a) == 1)}"
            yield Problem(at, f"the policy chooses among the actions of {group}", action, allowed)
