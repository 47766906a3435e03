"""Heredity: the genome, traits and brain weights that a newborn inherits."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ecs_eco.compiled.jit import njit
from ecs_eco.components import Genome, Policy, Traits
from ecs_eco.engine import random
from ecs_eco.engine.random import draw, mix
from ecs_eco.engine.table import Table
from ecs_eco.engine.world import World
from ecs_eco.genomes.traits import Trait

Values = dict[tuple[type, str], np.ndarray]


class Heredity:
    """The columns that one species' newborns inherit.

    `targets` maps a gene's name to the (component, field, index or None) to which its value is written.
    `derived` contains each derived trait's formula and trait, ordered so that a formula reads only earlier
    ones. `mutation`, `expression` and `shuffled` are switches for treatments. Without expression, genes are
    inherited and mutate but have no effect; if shuffled, a newborn's genes come from random living members
    instead of its parents. Founders have random letters, unless `alike` is given: a row u8[loci], and which
    of its letters all founders share, bool[loci].
    """

    def __init__(
        self,
        layout: Any = None,
        operators: Any = None,
        targets: Mapping[str, tuple[type, str, int | None]] | None = None,
        *,
        minds: Any = None,
        inherit: str = "none",
        noise: float = 0.0,
        founder: np.ndarray | None = None,
        alike: tuple[np.ndarray, np.ndarray] | None = None,
        derived: Mapping[str, tuple[Any, Trait]] | None = None,
    ) -> None:
        self.layout, self.operators, self.targets = layout, operators, dict(targets or {})
        self.derived = dict(derived or {})
        self._read = frozenset(self.targets).union(*(formula.names for formula, _ in self.derived.values()))
        self.minds, self.inherit, self.noise, self.founder, self.alike = (
            minds,
            inherit,
            float(noise),
            founder,
            alike,
        )
        self.mutation = self.expression = True
        self.shuffled = False

    def state(self) -> dict[str, np.ndarray]:
        """Return the state that is not stored in columns: the founders' weights (empty if random), and how
        often strings of variable length reached the limit."""
        out = (
            {}
            if self.minds is None
            else {"founder": np.zeros(0, np.float32) if self.founder is None else self.founder}
        )
        counts = getattr(self.operators, "at_limit", None)
        return out if counts is None else out | {"at_limit": counts.copy()}

    def load(self, state: Mapping[str, np.ndarray]) -> None:
        """Load a `state()`."""
        if "founder" in state:
            self.founder = state["founder"] if state["founder"].size else None
        if "at_limit" in state:
            self.operators.at_limit[:] = state["at_limit"]

    def founders(self, world: World, table: Table, identity: np.ndarray) -> Values:
        """Return the inherited columns of organisms without parents; `identity` u64[k] distinguishes them."""
        keys = hashed(keys_of(world, table), identity)
        values: Values = {}
        if self.layout is not None:
            loci = self.layout.random(keys)
            if self.alike is not None:
                own, coded = self.alike
                loci[:, coded] = own[coded]
            values = {(Genome, "loci"): loci} | self.express(table, loci)
        if self.minds is not None and (Policy, "weights") not in values:
            if self.founder is None:
                values[Policy, "weights"] = self.minds.draw(identity, keys_of(world, table))
            else:
                values[Policy, "weights"] = self._noisy(
                    np.repeat(self.founder[None], identity.size, axis=0), keys
                )
        self._prune(table, values)
        return values

    def offspring(
        self,
        world: World,
        table: Table,
        first: np.ndarray,
        second: np.ndarray | None,
        identity: np.ndarray,
        sperm: np.ndarray | None = None,
    ) -> Values:
        """Return the inherited columns of the children of rows `first` i64[k] and `second` i64[k] (−1: dead).

        `identity` u64[k] distinguishes the newborns of a tick; `sperm` u8[k, loci] are the fathers' genomes.
        """
        keys = hashed(keys_of(world, table), identity)
        values: Values = {}
        if self.shuffled:
            first, second, sperm = (
                _anyone(table, keys, 0),
                None if second is None else _anyone(table, keys, 1),
                None,
            )
        if self.layout is not None:
            loci = table[Genome].loci
            fathers = None if second is None else (loci[second] if sperm is None else sperm)
            self.operators.mutation = self.mutation
            children = self.operators.offspring(loci[first], fathers, keys)
            values = {(Genome, "loci"): children} | self.express(table, children)
        if self.minds is not None and (Policy, "weights") not in values:
            if self.inherit == "learned":
                values[Policy, "weights"] = self._noisy(
                    table[Policy].weights[_one_of(keys, first, second)], keys
                )
                if hidden_units(table):  # a child can have units that the parent lacked
                    self.minds.complete(
                        values[Policy, "weights"], self.minds.draw(identity, keys_of(world, table))
                    )
            else:
                values[Policy, "weights"] = self.minds.draw(identity, keys_of(world, table))
        self._prune(table, values)
        return values

    def _prune(self, table: Table, values: Values) -> None:
        """Keep only as many hidden units in networks as genes specify."""
        for layer, at in hidden_units(table).items():
            if (Policy, "weights") in values and (Traits, "value") in values:
                values[Policy, "weights"] = np.ascontiguousarray(values[Policy, "weights"])
                self.minds.prune(
                    values[Policy, "weights"], values[Traits, "value"][:, at].astype(np.int64), layer
                )

    def express(self, table: Table, loci: np.ndarray) -> Values:
        """Return the traits of genomes u8[k, loci] as columns."""
        if not self.expression:
            return {}
        out: Values = {}
        decoded = self.layout.decode(loci, self._read)
        for name, (formula, _) in self.derived.items():
            decoded[name] = formula({gene: decoded[gene] for gene in formula.names})
        decoded |= {name: trait.nearest(decoded[name]) for name, (_, trait) in self.derived.items()}
        for gene, (component, field, index) in self.targets.items():
            default = table.defaults[component][field]
            if index is None:
                out[component, field] = np.asarray(decoded[gene], default.dtype)
                continue
            if (component, field) not in out:
                out[component, field] = np.repeat(default[None], len(loci), axis=0)
            out[component, field][:, index] = decoded[gene]
        return out

    def _noisy(self, weights: np.ndarray, keys: np.ndarray) -> np.ndarray:
        """Add inheritance noise to copies of weights f32[k, w]."""
        if self.noise > 0 and self.mutation:
            blur(keys, np.float32(self.noise), weights)
        return weights


def hidden_units(table: Table) -> dict[int, int]:
    """Return the hidden layers whose number of units is heritable, with their positions in Traits."""
    traits = {} if table.species is None else table.species.traits
    return {int(key.rpartition(".")[2]): at for key, at in traits.items() if key.startswith("policy.hidden.")}


def keys_of(world: World, table: Table) -> np.uint64:
    """Return the random key for one species' newborns in this tick."""
    return np.uint64(random.mix_int(int(world.key) ^ ((table.place + 1) << 32)))


def _anyone(table: Table, keys: np.ndarray, number: int) -> np.ndarray:
    """Return a random living row for each key: i64[k]. All rows are equally likely."""
    rows = table.by_uid()
    return rows[(draws(keys, random.GENES + ((2 + number) << 8)) * rows.size).astype(np.int64)]


def _one_of(keys: np.ndarray, first: np.ndarray, second: np.ndarray | None) -> np.ndarray:
    """Return one parent of each child: i64[k]. Both are equally likely, unless one is dead (−1)."""
    if second is None:
        return first
    return np.where((draws(keys, random.BRAIN) < 0.5) | (second < 0), first, second)


@njit
def hashed(key, identity):
    """Return a well-mixed key for each number: u64[k]."""
    out = np.empty(identity.size, np.uint64)
    for i in range(identity.size):
        out[i] = mix(key ^ mix(identity[i]))
    return out


@njit
def draws(keys, purpose):
    """Draw a number in [0, 1) for each key: f32[k]."""
    out = np.empty(keys.size, np.float32)
    for i in range(keys.size):
        out[i] = draw(keys[i], np.uint64(0), purpose)
    return out


@njit
def blur(keys, deviation, weights):
    """Add normal noise to weights f32[k, w] (Box & Muller 1958, two draws each)."""
    for i in range(weights.shape[0]):
        for j in range(weights.shape[1]):
            u = np.float32(1.0) - draw(keys[i], np.uint64(j), random.BRAIN + (1 << 8))
            v = draw(keys[i], np.uint64(j), random.BRAIN + (2 << 8))
            weights[i, j] += (
                deviation * np.sqrt(np.float32(-2.0) * np.log(u)) * np.cos(np.float32(6.2831855) * v)
            )
