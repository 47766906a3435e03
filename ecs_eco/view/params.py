"""The values of a world file that may change while its world lives, for the page's list."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from ecs_eco.config.mutable_keys import may_change
from ecs_eco.engine.section import LARGEST, Use, function_name

NOT_NOW = frozenset({"ticks", "seed", "training", "interventions"})


def parameters(config: Any) -> list[dict[str, Any]]:
    """Return every number and switch that an intervention of kind "set" may change: key, value, unit,
    low, high, about.

    `low` and `high` are null if the file sets no bound. Values that genes code for are left out.
    """
    coded = {f"species.{name}.{gene.trait}" for name, s in config.species.items() if s.genome
             for gene in s.genome.genes if gene.trait}
    rows = _walk(config, (), {})
    return [row for row in rows if row["key"] not in coded and row["key"].split(".")[0] not in NOT_NOW
            and may_change(row["key"])]


def _walk(value: Any, key: tuple[str, ...], field: dict[str, Any]) -> Iterator[dict[str, Any]]:
    if isinstance(value, Use):
        for name, inner in value.parameters.items():
            about = f"parameter of {function_name(value)}"
            yield from _walk(inner, (*key, name), {"unit": "", "low": None, "high": None, "about": about})
    elif isinstance(value, BaseModel):
        for name, info in type(value).model_fields.items():
            yield from _walk(getattr(value, name), (*key, name), _field(info))
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from _walk(inner, (*key, str(name)), field)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            if isinstance(inner, BaseModel):
                yield from _walk(inner, (*key, str(i)), field)
    elif isinstance(value, bool | int | float) and key:
        yield {"key": ".".join(key), "value": value, **field}


def _field(info: Any) -> dict[str, Any]:
    """Return unit, bounds and description of a field."""
    extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
    bounds: dict[str, float | None] = {"low": None, "high": None}
    for rule in info.metadata:
        for name, words in (("low", ("ge", "gt")), ("high", ("le", "lt"))):
            for word in words:
                bound = getattr(rule, word, None)
                if bound is not None and abs(bound) < LARGEST:
                    bounds[name] = bound
    return {"unit": str(extra.get("unit", "")), **bounds,
            "about": (info.description or "").rpartition(" [")[0] or info.description or ""}
