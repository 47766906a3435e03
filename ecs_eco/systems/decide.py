"""Organisms decide: H(y + z)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Memory, Motor, Nervous
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.system import System
from ecs_eco.learning import choose
from ecs_eco.learning.continuous import draw_numbers
from ecs_eco.nervous.decision import Will, decide, uniforms
from ecs_eco.nervous.organs import disable
from ecs_eco.nervous.thoughts import Thoughts

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.nervous.nerves import Nerves
    from ecs_eco.nervous.outside import Answer
    from ecs_eco.space.world import SpatialWorld

NO_REFLEX = np.zeros((1, 1), np.int8)
NO_THOUGHT = np.zeros((0, 0), np.float32), np.zeros(0, np.float32)


class Decide(System):
    """The reflex network blocks (−1), leaves (0) or forces (+1) each action; the policy selects one action in
    each group.

    For each continuous action, the policy selects a number, which the reflex then shifts.
    """

    needs = (Nervous,)
    phase = "decide"
    divisible = True
    submodel = Submodel(
        "Decision",
        where=("actions",),
        reads=("actions", "default_action", "always_on", "reflex", "policy"),
        rules={
            "": "The decision is `H(y + z)`, with `H(v) = 1` if v > 0 and 0 otherwise (Strannegård et al. "
            "2021). The reflex network outputs y: −1 blocks an action, 0 leaves it to the policy, 1 forces "
            "it. The policy network outputs z, which is 1 for the action chosen in each group; z is also 1 "
            "for automatic actions. The first active action in each group is executed; if none is active, "
            "the default action is.",
            "policy.kind=individual": "Each individual has its own policy network: layers of tanh units "
            "(`hidden`), then a softmax over the actions of each group, from which the action is drawn, and a "
            "linear output for the predicted value.",
            "policy.kind=shared": "All individuals of the species share one policy network: layers of tanh "
            "units (`hidden`), then a softmax over the actions of each group, from which the action is "
            "drawn, and a linear output for the predicted value.",
            "policy.network": "The network is a torch module defined in the world's Python code.",
            "policy.kind=function": "A function chooses the actions.",
            "policy.kind=external": "A program outside the model chooses the actions.",
            "actions.continuous": "A continuous action is drawn from a normal distribution, and reflexes "
            "shift it.",
        },
        changes=("Nervous.decision", "Motor", "Memory", "Experience"),
        draws="the action in each group, with the policy's probabilities",
    )

    def update(self, table: Table, world: SpatialWorld) -> None:
        """Write the decisions of one species, and record them for its learner."""
        nerves = table.species.nerves
        n, groups, continuous = len(nerves.rows), len(nerves.offsets) - 1, len(nerves.ranges.groups)
        choice, log_probability = np.zeros((n, groups), np.int16), np.empty(n, np.float32)
        thinks, logits, values, outside = _think(nerves, table, world)
        decides, reaction = nerves.policy and n > 0, nerves.react(table)
        reacts, y = reaction is not None, NO_REFLEX if reaction is None else reaction
        uid, key, decision = table.uid.take(nerves.rows), world.key, table[Nervous].decision
        numbers = np.empty((n, continuous), np.float32)
        will = Will(nerves.offsets, nerves.targets, nerves.policy, y, reacts, nerves.always)
        given = will, nerves.rows
        if outside is None:
            world.split(resolve, n, key, uid, thinks, logits, *given, choice, log_probability, decision)
        else:
            if thinks:
                chance = np.empty((n, groups), np.float32)
                uniforms(0, n, key, uid, 0, chance)
                choose(logits, nerves.offsets, chance, choice, log_probability)
            _follow(outside, outside.choice, choice, slice(0, n))
            decide(0, n, choice, *given, decision)
        if continuous:
            if thinks:
                _draw(nerves, logits, key, uid, numbers, log_probability)
            if outside is not None:
                _follow(outside, outside.numbers, numbers, slice(None))
            ranges = nerves.ranges.of(table, nerves.rows)
            table[Motor].command[nerves.rows] = ranges.command(numbers if decides else None, nerves.shift)
        if table.species.traits:
            disable(table, nerves.rows)
        if outside is not None:
            logits = _unknown(nerves, logits, outside.told)
        nerves.thoughts = Thoughts(
            world.tick,
            uid,
            logits if decides else None,
            y if reacts else None,
            choice,
            numbers if decides else None,
            nerves.shift,
        )
        if thinks and nerves.learning:
            nerves.remember(table, choice, numbers, log_probability, values)
        if thinks and Memory in table:
            nerves.keep(table)


def _think(
    nerves: Nerves, table: Table, world: SpatialWorld
) -> tuple[bool, np.ndarray, np.ndarray, Answer | None]:
    """Return whether a species' network is needed, its output, and an external policy's choices."""
    if not nerves.policy or not len(nerves.rows):
        return False, *NO_THOUGHT, None
    outside = nerves.outside
    answer = None if outside is None else outside.answer(nerves, table, world)
    if answer is None or outside.partial:
        return True, *nerves.think(table, world), answer
    return False, *NO_THOUGHT, answer


def _follow(answer: Answer, given: np.ndarray, into: np.ndarray, here: slice) -> None:
    """Replace the network's choices [n, …] with external ones."""
    if answer.told is None:
        into[here] = given[here]
    else:
        into[here][answer.told[here]] = given[here][answer.told[here]]


def _unknown(nerves: Nerves, logits: np.ndarray, told: np.ndarray | None) -> np.ndarray:
    """Return logits f32[n, options], with NaN for external choices."""
    if told is None:
        return np.full((len(nerves.rows), sum(nerves.choices)), np.nan, np.float32)
    return np.where(told[:, None], np.float32(np.nan), logits)


def _draw(
    nerves: Nerves,
    logits: np.ndarray,
    key: np.uint64,
    uid: np.ndarray,
    numbers: np.ndarray,
    log_probability: np.ndarray,
) -> None:
    """Draw numbers f32[n, k] for continuous actions, uniformly over the range if there is no network, and
    add their log-probabilities; the draws depend only on the seed, tick and uid."""
    chance = np.empty((len(uid), 2 * numbers.shape[1]), np.float32)
    uniforms(0, len(uid), key, uid, len(nerves.offsets) - 1, chance)
    if nerves.brain is None and nerves.individuals is None:
        numbers[...] = 2 * chance[:, ::2] - 1
    else:
        draw_numbers(logits[:, nerves.offsets[-1] :], chance, numbers, log_probability)


@njit
def resolve(
    first: int,
    last: int,
    key: np.uint64,
    uid: np.ndarray,
    thinks: bool,
    logits: np.ndarray,
    will: Will,
    rows: np.ndarray,
    choice: np.ndarray,
    log_probability: np.ndarray,
    decision: np.ndarray,
) -> None:
    """Draw choices and their log-probabilities for organisms first … last − 1 if a network decides, and write
    the organisms' decisions."""
    if thinks:
        chance, here = np.empty((last, choice.shape[1]), np.float32), slice(first, last)
        uniforms(first, last, key, uid, 0, chance)
        choose(logits[here], will.offsets, chance[here], choice[here], log_probability[here])
    decide(first, last, choice, will, rows, decision)
