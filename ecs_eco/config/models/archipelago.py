"""Islands: worlds built from the same file, each with its own values, that exchange migrants."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from ecs_eco.config.models.search import Ticks
from ecs_eco.engine.submodel import Submodel
from ecs_eco.engine.uids import MOST_ISLANDS, first_uid
from ecs_eco.inputs.section import Name, Section, Share, about, quantity, table


def _named(islands: object) -> Any:
    """Return islands as a table: a number becomes that many entries, and nested tables become dotted keys."""
    if isinstance(islands, int) and not isinstance(islands, bool):
        return {f"island_{i}": {} for i in range(1, min(islands, MOST_ISLANDS + 1) + 1)}
    if isinstance(islands, dict):
        return {name: dict(_flat(own, "")) if isinstance(own, dict) else own for name, own in islands.items()}
    return islands


def _flat(values: dict[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    """Yield dotted keys with their values; a key that contains a dot is already dotted."""
    for key, value in values.items():
        if isinstance(value, dict) and value:
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


class Archipelago(Section):
    """Islands: one world per entry, connected only by migrants, which are exchanged at regular ticks
    (barriers). Values that an island does not set come from the rest of the file."""

    submodel = Submodel(
        "Migration",
        reads=("archipelago",),
        rules={
            "": "Every `migration_interval` ticks, each individual leaves its island with the probability "
            "given in `migration_probability` and arrives on a neighboring island, all being equally likely."
        },
        draws="which individuals migrate, and their destinations",
    )

    islands: Annotated[
        dict[Name, dict[str, Any]], BeforeValidator(_named), Field(min_length=2, max_length=MOST_ISLANDS)
    ] = about(
        "name = { dotted key = the island's value, … }, as with --set; or the number of identical islands"
    )
    migration_interval: Ticks = quantity("time between exchanges of migrants", "ticks", former="every")
    graph: Literal["ring", "grid", "full", "own"] = about(
        "neighbors of each island: ring, the next and the previous island; grid, the four adjacent islands "
        "in a square filled row by row; full, all other islands; own, as listed in `edges`",
        "ring",
    )
    edges: list[Annotated[list[Name], Field(min_length=2, max_length=2)]] = about(
        '[from, to] of each one-way connection, for graph = "own"', [], omit=True
    )
    migration_probability: dict[Name, Share] = table(
        "species = probability that a member leaves for a random neighboring island at an exchange",
        dict,
        former="emigration",
    )
    here: Name | None = about(
        "the island that this world represents; a run sets it for each island", omit=True
    )

    @property
    def names(self) -> list[str]:
        """The names of the islands, ordered by number, from 0."""
        return list(self.islands)

    @property
    def number(self) -> int:
        """The number of the island that this world represents; 0 if it represents none."""
        return 0 if self.here is None else self.names.index(self.here)

    @property
    def first_uid(self) -> int:
        """The first uid that this world assigns."""
        return first_uid(self.number)

    def neighbours(self) -> list[list[int]]:
        """Return, for each island, the numbers of its neighbors in ascending order."""
        names, n, edges = self.names, len(self.islands), {tuple(edge) for edge in self.edges}
        width = math.ceil(math.sqrt(n))

        def leads(i: int, j: int) -> bool:
            if self.graph == "own":
                return (names[i], names[j]) in edges
            if self.graph == "grid":
                return abs(i // width - j // width) + abs(i % width - j % width) == 1
            return i != j and (self.graph == "full" or (i - j) % n in (1, n - 1))

        return [[j for j in range(n) if leads(i, j)] for i in range(n)]

    def meets(self, tick: int) -> bool:
        """Return whether migrants leave and arrive before a tick."""
        return tick > 0 and tick % self.migration_interval == 0
