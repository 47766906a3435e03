"""The panel of a page: the organism that it has selected, of the world shown or of the one beside it."""

from __future__ import annotations

import math

from ecs_eco.view.messages import refusal, short, text
from ecs_eco.view.shown import Chosen, View
from ecs_eco.view.source import Known, Message, Paired, Source


def choose(source: Source, view: View, request: Message) -> None:
    """Select an organism by its uid, None for none; one of the second world with `second`."""
    uid, second = request.get("uid"), request.get("second", False)
    if uid is not None and (isinstance(uid, bool) or not isinstance(uid, int) or not 0 < uid < 2**63):
        raise ValueError(f"select: uid = {short(uid)}; allowed: the uid of an organism, or null")
    if not isinstance(second, bool):
        raise ValueError(f"select: second = {short(second)}; allowed: true or false")
    if second and uid is not None and _second(source) is None:
        raise ValueError(f"select: #{uid} is asked for of a second world, but there is none beside this one")
    view.selected, view.panel, view.panel_at = None if uid is None else Chosen(uid, second), None, -math.inf


def panel(source: Source, view: View, now: float, out: list[str | bytes]) -> None:
    """Add the state of the selected organism, or that there is none."""
    assert view.selected is not None
    view.panel_at, view.panel = now, (source.tick, view.selected)
    uid, second = view.selected
    known = _second(source) if second else source
    if known is None:  # pages have been told that the other world is closed
        view.selected = None
        return
    try:
        out.append(text(known.organism(uid)))
    except KeyError:
        out.append(refusal(f"no organism {uid} is known here", "select"))
        view.selected = None
    except Exception as error:  # a panel that cannot be made must not end the run
        out.append(refusal(f"organism {uid}: {type(error).__name__}: {error}", "select"))
        view.selected = None


def _second(source: Source) -> Known | None:
    return source.second if isinstance(source, Paired) else None
