"""Which stretches of a recorded run have details of organisms: recorded so, or run again later."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ecs_eco.view.recording import Recording
from ecs_eco.view.rerun import Stretch


def stretches(recording: Recording, again: Sequence[Stretch]) -> list[dict[str, Any]]:
    """Return the stretches of `marks`: kind ("full", "focal" or "filled"), first and last tick, species,
    the number of focal organisms, and the first tick at which a filled one differs from the record."""
    record = str(recording.manifest.get("record") or "")
    kind, _, most = record.partition("=")
    out: list[dict[str, Any]] = []
    for name in recording.species:
        for first, last in spans(recording, name):
            same = next((s for s in out if (s["first"], s["last"]) == (first, last)), None)
            if same is not None:
                same["species"].append(name)
            else:
                out.append(
                    {
                        "kind": "full" if kind == "full" else "focal",
                        "first": first,
                        "last": last,
                        "species": [name],
                        "n": int(most) if most.isdecimal() else None,
                        "wrong": None,
                    }
                )
    return out + [
        {
            "kind": "filled",
            "first": s.first,
            "last": s.last,
            "species": sorted(s.details),
            "n": None,
            "wrong": s.wrong,
        }
        for s in again
    ]


def spans(recording: Recording, species: str) -> list[tuple[int, int]]:
    """Return first and last tick of each stretch in which details of a species were recorded."""
    out: list[tuple[int, int]] = []
    for first, last in sorted(group.ticks for group in recording.details[species].groups if group.rows):
        first, last = max(first, recording.first), min(last, recording.last)
        if out and first <= out[-1][1] + 1:
            out[-1] = out[-1][0], max(last, out[-1][1])
        elif first <= last:
            out.append((first, last))
    return out


def note(recording: Recording) -> str:
    """Say which data are exact, and which are interpolated."""
    r = recording
    detailed = [name for name in r.species if r.details[name].rows]
    text = "Recorded in every tick."
    if r.every > 1:
        text = (
            f"Recorded every {r.every} ticks; in between, "
            "births and deaths are exact and places are on straight lines."
        )
    return text + (f" Details of {', '.join(detailed)}: {r.manifest.get('record')}." if detailed else "")
