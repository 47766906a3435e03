"""The matter ledger of a recording: one row for each tick, holder and substance."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ecs_eco.life.matter import FLOWS, MIGRATION, Books, stocks
from ecs_eco.record.frame import as_table, joined, under

if TYPE_CHECKING:
    from ecs_eco.space.world import SpatialWorld

LEDGER = ("stock_before", *FLOWS, "stock_after")
"""The columns of the matter ledger [mol]; flows into the holder of the substance are positive."""


def imbalance(ledger: Mapping[str, Any]) -> Any:
    """Return the imbalance [mol] of a matter ledger (any object with its columns); 0 if it closes."""
    flows = [*FLOWS, *(flow for flow in MIGRATION if flow in ledger)]
    return ledger["stock_before"] + sum(ledger[flow] for flow in flows) - ledger["stock_after"]


class MatterPages:
    """The rows of a world's matter ledger that have not yet been written."""

    def __init__(self, world: SpatialWorld) -> None:
        self.books: Books = world.matter
        self.books.turn(stocks(world, self.books))
        self.substances = list(world.substances)
        self.names = ("stock_before", *self.books.ways, "stock_after")
        self.blocks: dict[str, list[dict[str, np.ndarray]]] = {"matter": []}  # blocks in memory, by kind
        self.ticks: list[int] = []
        self.pages: list[np.ndarray] = []  # f64[holders, substances, columns]

    def turn(self, world: SpatialWorld) -> None:
        """Finish this tick's page and start the next."""
        books, after = self.books, stocks(world, self.books)
        page = np.concatenate([books.stock[:, :, None], books.flows, after[:, :, None]], 2)
        self.ticks.append(world.tick)
        self.pages.append(page)
        books.turn(after)

    def columns(self) -> dict[str, np.ndarray]:
        """Return the pages as flat columns, sorted by tick, then holder, then substance."""
        n, (h, s) = len(self.ticks), self.books.stock.shape
        each = np.reshape(self.pages, (n * h * s, len(self.names)))
        out: dict[str, np.ndarray] = {
            "tick": np.repeat(np.array(self.ticks, np.int64), h * s),
            "holder": np.tile(np.repeat(np.arange(h, dtype=np.int16), s), n),
            "substance": np.tile(np.arange(s, dtype=np.int16), n * h),
        }
        return out | {name: each[:, i].copy() for i, name in enumerate(self.names)}

    @property
    def words(self) -> dict[str, list[str]]:
        """Return the strings that numbers in columns stand for: column → strings."""
        return {"holder": self.books.names, "substance": self.substances}

    def flush(self, sink: Callable[[str, dict[str, np.ndarray]], None] | None) -> None:
        """Pass the pages to the sink, or keep them as a block."""
        if sink is not None:
            sink("matter", self.columns())
        else:
            self.blocks["matter"].append(self.columns())
        self.ticks, self.pages = [], []

    def series(self) -> Any:
        """Return all pages still in memory as a pyarrow.Table."""
        return as_table([*self.blocks["matter"], self.columns()], self.words)

    def state(self) -> dict[str, np.ndarray]:
        """Return the open page, and the blocks in memory, after `flush`."""
        out = {"stock": self.books.stock.copy(), "flows": self.books.flows.copy()}
        return out | joined(self.blocks["matter"], "series/")

    def load(self, state: Mapping[str, np.ndarray]) -> None:
        """Continue from a `state()`."""
        self.ticks, self.pages = [], []
        if "stock" in state:
            self.books.stock[...], self.books.flows[...] = state["stock"], state["flows"]
        block = under(state, "series/")
        self.blocks["matter"] = [block] if block else []
