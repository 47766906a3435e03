"""Checks that a checkpoint fits a world and has valid numbers; a seal only proves that a file is unchanged."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from ecs_eco._lazy import stored_name
from ecs_eco.engine.errors import CheckpointError
from ecs_eco.engine.uids import island_of
from ecs_eco.life.matter import is_island
from ecs_eco.record.plain import stateful
from ecs_eco.space import gate

if TYPE_CHECKING:
    from ecs_eco.engine.table import Table
    from ecs_eco.space.world import SpatialWorld

Arrays = Mapping[str, np.ndarray]
OWN = {"row": np.int64, "uid": np.uint64, "born": np.int64, "cause": np.uint8, "killer": np.uint64}
MOST_ROWS = 1 << 31
COUNTERS = ("learner.steps", "learner.updates")


class ArrayChecks:
    """Checks a file against the world that loads it; each check raises CheckpointError."""

    def __init__(self, world: SpatialWorld, meta: Mapping[str, Any], arrays: Arrays, where: str) -> None:
        self.world, self.meta, self.arrays, self.where = world, meta, arrays, where

    def construction(self) -> None:
        """Check that the tables, fields, systems and parts of the world match the file."""
        world, meta = self.world, self.meta
        tables, saved = list(world.tables), list(meta["tables"])
        if not any(a.any() for name, a in self.arrays.items() if name.endswith("/barren")):
            tables, saved = sorted(tables), sorted(saved)  # the order matters only for `barren`
        former = [] if world.config is None else list(world.config.substances)  # in the world file's order
        self.same("the tables", tables, saved)
        self.same("the substances", list(world.substances), meta.get("substances", former))
        self.same("the fields", sorted(world.fields), meta["fields"])
        self.same("the environment functions", sorted(world.environment), meta["environment"])
        if world.dt != (dt := meta["clock"]["dt"]):
            self.fail(f"was saved with dt = {dt!r:.40} s, but this world has {world.dt:g} s")
        systems = [s for s in meta["systems"] if s != "Recorder"]
        mine = [type(s).__name__ for s in world.systems]
        self.same("the systems", [name for name in mine if name != "Recorder"], systems)
        for name, table in world.tables.items():
            made = {
                stored_name(c): {f: [a.dtype.str, list(a.shape[1:])] for f, a in vars(held).items()}
                for c, held in table.columns.items()
            }
            theirs = meta["tables"][name]["columns"]
            for component in {**made, **theirs}:
                if (here := made.get(component)) != (there := theirs.get(component)):
                    self.fail(
                        f"{component} of {name} was saved with the columns {there}, but this world has {here}"
                    )
        kept = {owner: sorted(state) for owner, part in stateful(world).items() if (state := part.state())}
        for owner in {**kept, **meta["stateful"]}:
            has, had = kept.get(owner, []), meta["stateful"].get(owner, [])
            if has != had:
                self.fail(f"contains {_words(had)} of {owner}, but this world has {_words(has)}")

    def same(self, part: str, mine: list[str], theirs: list[str]) -> None:
        """Check that the world's names match the file's."""
        if mine != theirs:
            self.fail(f"was saved with {part} {_words(theirs)}, but this world has {_words(mine)}")

    def numbers(self) -> None:
        """Check that all numbers in the file are valid for the world."""
        self.clock()
        seen = [self.table(name, table) for name, table in self.world.tables.items()]
        uids = np.sort(np.concatenate([np.zeros(0, np.uint64), *seen]))
        if (again := np.flatnonzero(uids[1:] == uids[:-1])).size:
            self.fail(f"uid {uids[again[0]]} occurs twice; expected unique uids")
        for name, array in self.arrays.items():
            if name.endswith(COUNTERS):
                self.counter(name, array)
        for name, field in self.world.fields.items():
            value = self.array(f"field/{name}", field.value.dtype, field.value.shape)
            if not np.isfinite(value).all():
                self.fail(
                    f"the part 'field/{name}' contains {value[~np.isfinite(value)][0]}; expected finite numbers"
                )

    def fail(self, what: str) -> NoReturn:
        """Raise the error."""
        raise CheckpointError(f"{self.where}: {what}")

    def array(self, name: str, dtype: Any, shape: tuple[int, ...]) -> np.ndarray:
        """Return a part of the file after checking its type and shape."""
        kept = self.arrays.get(name)
        if kept is None:
            self.fail(f"the part {name!r} is missing")
        if kept.dtype != dtype or kept.shape != shape:
            self.fail(
                f"the part {name!r} is {kept.dtype}{list(kept.shape)}; expected for this world: "
                f"{np.dtype(dtype)}{list(shape)}"
            )
        return kept

    def clock(self) -> None:
        """Check the clock, the causes of death and the ambient values."""
        clock, causes, ambient = self.meta["clock"], self.meta["causes"], self.meta["ambient"]
        for key, least, most in (("tick", 0, 2**62), ("next_uid", 1, 2**62), ("seed", -(2**64), 2**64)):
            if type(clock[key]) is not int or not least <= clock[key] <= most:
                self.fail(f"clock.{key} is {clock[key]!r}; expected: an integer of at least {least}")
        if not all(isinstance(c, str) for c in causes) or len(causes) > 255 or len(set(causes)) < len(causes):
            self.fail(f"causes are {str(causes)[:80]}; expected: at most 255 different names")
        for key, value in ambient.items():
            if not isinstance(value, int | float) or not math.isfinite(value):
                self.fail(f"ambient.{key} is {value!r}; expected finite numbers")

    def table(self, name: str, table: Table) -> np.ndarray:
        """Check the organisms and newborns of one table; return the uids of living organisms."""
        prefix, made = f"table/{name}", self.meta["tables"][name]
        rows = self.arrays.get(f"{prefix}/row")
        n = 0 if rows is None else len(np.atleast_1d(rows))
        own = {word: self.array(f"{prefix}/{word}", dtype, (n,)) for word, dtype in OWN.items()}
        rows, uid, capacity = own["row"], own["uid"], made["capacity"]
        if n and (rows[0] < 0 or (rows[1:] <= rows[:-1]).any()):
            self.fail(f"the part '{prefix}/row' is not an increasing list of indices: {rows[:9].tolist()}")
        if type(capacity) is not int or not (rows[-1] if n else 0) < capacity <= MOST_ROWS:
            self.fail(
                f"{name} has a capacity of {capacity!r}, but its last row is {rows[-1] if n else 'none'}"
            )
        # organisms on an island can have uids from other islands
        next_uid = self.meta["clock"]["next_uid"]
        mine = uid[(uid == 0) | (island_of(uid) == island_of(next_uid))] if is_island(self.world) else uid
        self.range(f"{prefix}/uid", mine, 1, next_uid - 1)
        self.range(f"{prefix}/born", own["born"], np.iinfo(np.int64).min, self.meta["clock"]["tick"])
        self.range(f"{prefix}/cause", own["cause"], 0, len(self.meta["causes"]))
        for component, held in table.columns.items():
            for field, column in vars(held).items():
                self.array(f"{prefix}/{stored_name(component)}.{field}", column.dtype, (n, *column.shape[1:]))
        self.limits(table, prefix, f"{name}, uid {{}}", uid)
        for i, birth in enumerate(made["births"]):
            self.births(table, f"{prefix}/births/{i}", birth)
        return uid

    def range(self, part: str, values: np.ndarray, least: int, most: int) -> None:
        """Check that integers are within limits."""
        ends = (values.min(), values.max()) if values.size else ()
        if wrong := [v for v in ends if not least <= int(v) <= most]:
            self.fail(f"the part {part!r} contains {wrong[0]}; expected: {least} to {most}")

    def counter(self, part: str, array: np.ndarray) -> None:
        """Check that a counter is a single integer."""
        if array.dtype.kind not in "iu" or array.size != 1:
            self.fail(f"the part {part!r} is {array.dtype}{list(array.shape)}; expected: one integer")
        self.range(part, array, 0, 2**53)

    def limits(self, table: Table, prefix: str, label: str, uid: np.ndarray | None = None) -> None:
        """Check that the values in the file are within the limits of their fields."""
        for limits in gate.limits_of(self.world, table, heavy=True):
            values = self.arrays.get(f"{prefix}/{stored_name(limits.component)}.{limits.field}")
            if values is not None and (wrong := limits.outside(values)).any():
                first = int(np.flatnonzero(wrong)[0])
                try:
                    limits.refuse(label.format(first if uid is None else uid[first]), values[wrong])
                except ValueError as error:
                    self.fail(str(error))

    def births(self, table: Table, prefix: str, birth: Mapping[str, Any]) -> None:
        """Check requested births."""
        k = len(np.atleast_1d(self.arrays.get(f"{prefix}/parent", np.zeros(0))))
        for word in ("parent", *(["second"] if birth["second"] else [])):
            self.array(f"{prefix}/{word}", np.uint64, (k,))
        known = {
            f"{stored_name(c)}.{f}": d for c, fields in table.defaults.items() for f, d in fields.items()
        }
        for word in birth["values"]:
            if word not in known:
                self.fail(f"newborns of {table.name!r} have {word!r}, which their table lacks")
            self.array(f"{prefix}/{word}", known[word].dtype, (k, *known[word].shape))
        self.limits(table, prefix, f"newborn {{}} of {table.name!r}")


def check_arrays(world: SpatialWorld, meta: Mapping[str, Any], arrays: Arrays, where: str) -> None:
    """Raise CheckpointError if the world was built differently, or the file's numbers are invalid for it."""
    checks = ArrayChecks(world, meta, arrays, where)
    checks.construction()
    try:
        checks.numbers()
    except (KeyError, TypeError, AttributeError, IndexError, OverflowError) as error:
        raise CheckpointError(
            f"{where}: its description of the world is malformed: {type(error).__name__}: {error}"
        ) from None


def _words(names: list[str]) -> str:
    return ", ".join(names) or "none"
