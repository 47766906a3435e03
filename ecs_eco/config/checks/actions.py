"""Checks of one species' groups of actions."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from ecs_eco.config.checks.matter import Key
from ecs_eco.config.models.species import MOTIONS, Species
from ecs_eco.config.models.world import WorldConfig
from ecs_eco.engine.code import SHIPPED
from ecs_eco.engine.errors import Problem, listed, unknown
from ecs_eco.engine.section import LARGEST


def check_actions(config: WorldConfig, key: Key, species: Species) -> Iterator[Problem]:
    """All problems of the species' groups of actions."""
    groups = species.known_groups()
    others = [*_groups_of_systems(config), *_groups_of_exchange(species)]
    ranges = species.ranges()
    for group, actions in species.groups().items():
        at = (*key, "actions", group)
        if group not in (*groups, *others):
            if _may_act(config):
                continue
            yield unknown(at, "group of actions", group, [*groups, *others])
            continue
        if group in ranges:
            yield from _check_range(config, (*at, "continuous"), species, group, group in others)
            continue
        if group in others:
            yield from _check_free_group(at, actions)
            continue
        yield from _check_known_group(config, at, species, group, actions, *groups[group])
    yield from _check_neutral(key, species)
    yield from _check_automatic(key, species)


def _check_known_group(
    config: WorldConfig,
    at: Key,
    species: Species,
    group: str,
    actions: list[str],
    word: str,
    known: list[str],
) -> Iterator[Problem]:
    """Check a group that shipped systems carry out."""
    if group == "pitch":
        yield Problem(
            at,
            "has no single actions",
            actions,
            "{ continuous = [least, most] }; or up, none and down in the group climb",
        )
        return
    if not actions:
        yield Problem(at, "is empty", actions, listed(known))
    for i, action in enumerate(actions):
        if action not in known:
            yield unknown((*at, i), word, action, known)
        elif action in actions[:i]:
            yield Problem((*at, i), "named twice", action, listed(known))
    ways = {"turn": ("turn",), "climb": ("climb", "pitch")}.get(group, ())
    if ways and not any(getattr(species.locomotion, way, 0) for way in ways):
        fault = f"it cannot {group}: locomotion.{group} is missing or 0"
        yield Problem(at, fault, actions, f"locomotion.{group} > 0, or no such group")
    if group == "climb" and config.dims == 2:
        yield Problem(at, "no up and down in a plane", actions, "a space of three sizes, or no such group")
    if group == "eat" and not species.diet:
        yield Problem(at, "it has no diet", actions, "a diet, or no such group")


def _check_neutral(key: Key, species: Species) -> Iterator[Problem]:
    ranges = species.ranges()
    for group, rest in species.neutral.items():
        if group not in species.actions:
            yield unknown(
                (*key, "neutral", group), "group among the species' actions", group, species.actions
            )
        elif group in ranges:
            low, high = ranges[group]
            if isinstance(rest, str) or not low <= rest <= high:
                yield Problem(
                    (*key, "neutral", group),
                    "not a number of this continuous action",
                    rest,
                    f"{low:g} to {high:g}",
                )
        elif rest not in species.groups()[group]:
            yield unknown(
                (*key, "neutral", group), f"action in the group {group}", str(rest), species.groups()[group]
            )


def _check_range(
    config: WorldConfig, key: Key, species: Species, group: str, free: bool
) -> Iterator[Problem]:
    """Check a continuous action; one that is `free` is carried out by a system of the world's own."""
    low, high = species.ranges()[group]
    if not low < high:
        yield Problem(key, "the second is the most", [low, high], "two numbers, the first below the second")
        return
    if free:
        return
    if group not in MOTIONS:
        yield Problem(
            key[:-1],
            "cannot be continuous",
            {"continuous": [low, high]},
            f"a list of actions; continuous may be {listed(MOTIONS)}",
        )
        return
    if species.locomotion is None:
        yield Problem(
            key[:-1],
            "it cannot move: locomotion is missing",
            {"continuous": [low, high]},
            "locomotion, or no such group",
        )
        return
    if group in ("climb", "pitch") and config.dims == 2:
        yield Problem(
            key[:-1],
            "no up and down in a plane",
            {"continuous": [low, high]},
            "a space of three sizes, or no such group",
        )
    if group == "pitch" and "climb" in species.actions:
        yield Problem(
            key[:-1], "it goes up and down by climb", {"continuous": [low, high]}, "one of climb and pitch"
        )
    gaits = species.locomotion.speed.values()
    least, most = {"speed": (0.0, max(gaits)), "pitch": (-math.pi / 2, math.pi / 2)}.get(
        group, (-LARGEST, LARGEST)
    )
    if low < least or high > most:
        words = "speeds up to that of the fastest gait" if group == "speed" else "angles"
        yield Problem(key, "out of range", [low, high], f"{words}, {least:g} to {most:g}")


def _groups_of_systems(config: WorldConfig) -> list[str]:
    """The groups of actions that the world's own systems carry out."""
    groups: list[str] = []
    for system in config.systems:
        groups += getattr(config.known(system), "acts", ())
    return groups


def _groups_of_exchange(species: Species) -> list[str]:
    """The groups of actions by which a species exchanges or converts substances, of any name."""
    ways = [*species.exchange, *species.reactions]
    used = {action for way in ways if (action := getattr(way, "action", None)) is not None}
    return [
        group
        for group, actions in species.groups().items()
        if group not in species.known_groups() and not used.isdisjoint(actions)
    ]


def _may_act(config: WorldConfig) -> bool:
    """Whether the world names systems that are not loaded, which may carry out any group of actions."""
    return not config._code.allowed and any(
        isinstance(name := getattr(s, "use", s), str) and name not in SHIPPED for s in config.systems
    )


def _check_free_group(key: Key, actions: list[str]) -> Iterator[Problem]:
    if not actions:
        yield Problem(key, "is empty", actions, "names of actions")
    for i, action in enumerate(actions):
        if not re.fullmatch(r"[A-Za-z]\w{0,39}", action):
            yield Problem((*key, i), "not a name", action, "a letter, then letters, digits or _ (at most 40)")
        elif action in actions[:i]:
            yield Problem((*key, i), "named twice", action, "each name once")


def _check_automatic(key: Key, species: Species) -> Iterator[Problem]:
    rows, pairs = species.action_rows(), species.action_list()
    for i, action in enumerate(species.automatic):
        at = (*key, "automatic", i)
        if action not in rows:
            yield unknown(at, "action of the species", action, rows)
        elif (group := pairs[rows[action]][0]) in species.ranges():
            yield Problem(at, "is continuous: it is done always", action, "an action alone in its group")
        elif len(species.groups()[group]) > 1:
            alone = [names[0] for names in species.groups().values() if len(names) == 1]
            fault = f"the policy chooses among the group {group}"
            yield Problem(at, fault, action, f"an action alone in its group: {listed(alone)}")
