"""Messages to pages as text."""

from __future__ import annotations

import json
from typing import Any

from ecs_eco.view.source import Message


def text(message: Message) -> str:
    """Return a message as JSON."""
    return json.dumps(message, separators=(",", ":"), allow_nan=False)


def refusal(words: str, field: str | None = None) -> str:
    """Return what a page is told whose request, or its part `field`, is refused."""
    return text(
        {"kind": "said", "level": "error", "text": words} | ({} if field is None else {"field": field})
    )


def short(value: Any) -> str:
    """Return a value as JSON, cut where it is long."""
    words = json.dumps(value)
    return words if len(words) <= 60 else words[:59] + "…"
