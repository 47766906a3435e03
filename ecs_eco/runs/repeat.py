"""Repeats a recorded run: from the same start, with all interventions that were carried out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from ecs_eco.compiled import portable
from ecs_eco.config.models.interventions import AnyIntervention, coming
from ecs_eco.ecosystem import World
from ecs_eco.engine.errors import RecordingError
from ecs_eco.engine.versions import versions
from ecs_eco.record.claim import Claim
from ecs_eco.runs.begin import start_of
from ecs_eco.runs.run import read_manifest, run_to_folder


def repeatable(manifest: dict[str, Any]) -> dict[str, Any]:
    """Return the world file of a recorded run as a dict, with the interventions that were carried out.

    Interventions of the world file that were still due are kept, because the digest covers them, and `ticks`
    extends beyond the first of each. Run for the recorded number of ticks with the manifest's seed, policies,
    learn and controls, the world ends with the manifest's digest.
    """
    done = [dict(intervention) | {"at": tick} for tick, intervention in manifest.get("intervened", [])]
    interventions = done + _to_come(manifest)
    return manifest["config"] | {
        "interventions": interventions,
        "ticks": max(1, manifest["done"], *(1 + intervention["at"] for intervention in interventions)),
    }


def _to_come(manifest: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the interventions of the world file that are due after the recorded ticks, each from its next
    tick on."""
    planned = TypeAdapter(list[AnyIntervention]).validate_python(manifest["config"].get("interventions", []))
    return [
        intervention.model_dump(mode="json", exclude_none=True)
        for intervention in coming(planned, manifest["done"])
    ]


def repeat(
    path: str | Path,
    out: str | Path | Claim | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    threads: int = 1,
    trust: bool = False,
) -> dict[str, Any]:
    """Repeat a recorded run up to the end of its recording, into a folder or without one, and compare.

    Returns world, ticks, interventions, digest, recorded (the digest of the record), same, and the likely
    reason for a difference. `trust` allows the code in the run's folder to run in this process. Raises
    RecordingError for a fork, whose start is not in its folder, and for a folder without a run.
    """

    manifest = read_manifest(Path(path))
    if "forked" in manifest:
        raise RecordingError(
            f"{path}: is a fork of {manifest['forked']['from']}; repeat that run, then fork it again"
        )
    if "island" in manifest:
        raise RecordingError(
            f"{path}: is the island {manifest['island']} of an archipelago; run the archipelago "
            "again, and compare the digests"
        )
    if not manifest.get("digest"):
        raise RecordingError(
            f"{path}: was killed before its end was recorded; resume it with: ecs-eco resume {path}"
        )
    how, done = start_of(Path(path), manifest, repeatable(manifest), trust), manifest["done"]
    config = how.pop("config")
    if out is None:
        world = World.from_config(config, threads=threads, record=False, **how).run(done, progress)
        digest = world.digest()
    else:
        digest = run_to_folder(
            config, ticks=done, out=out, progress=progress, threads=threads, report=False, **how
        )["digest"]
    other = {k: v for k, v in versions().items() if manifest["versions"].get(k) != v}
    why = (
        f"; it was recorded with other versions: {', '.join(f'{k} {v}' for k, v in other.items())}"
        if other
        else ""
    )
    why += f"; it {mode}" if (mode := portable.other_mode(manifest)) else ""
    return {
        "world": config.name,
        "ticks": done,
        "interventions": len(manifest.get("intervened", [])),
        "digest": digest,
        "recorded": manifest["digest"],
        "same": digest == manifest["digest"],
        "why": why,
    }
