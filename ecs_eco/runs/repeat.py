"""Repeats a recorded run from its start, with all interventions that were carried out."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from ecs_eco.compiled import portable
from ecs_eco.config.models.interventions import AnyIntervention, coming
from ecs_eco.ecosystem import World
from ecs_eco.engine.arguments import called_with
from ecs_eco.engine.errors import RecordingError
from ecs_eco.engine.versions import versions
from ecs_eco.record.claim import Claim
from ecs_eco.runs.begin import start_of
from ecs_eco.runs.run import read_manifest, run_to_folder


def repeatable(manifest: dict[str, Any]) -> dict[str, Any]:
    """Return the world file of a recorded run as a dict, with the interventions that were carried out.

    When run with the manifest's seed, policies, learn and controls for the recorded number of ticks, it ends
    with the manifest's digest.

    Parameters
    ----------
    manifest : dict
        As returned by `read_manifest`.

    Returns
    -------
    dict
        An argument for `World.from_config`. It includes the world file's interventions that were still
        pending, because the digest covers them.

    Raises
    ------
    RecordingError
        If the manifest's interventions are invalid.

    Examples
    --------
    >>> from ecs_eco.runs.repeat import repeatable
    >>> from ecs_eco.runs.run import run_to_folder
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=2, out="my-run", report=False)
    >>> repeatable(manifest)["name"]
    'predator-prey'
    """
    try:
        planned = TypeAdapter(list[AnyIntervention]).validate_python(
            manifest["config"].get("interventions", [])
        )
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]["msg"]
        raise RecordingError(
            f"{manifest['world']}: the recorded interventions are invalid: {fault}"
        ) from None
    interventions = [dict(done) | {"at": tick} for tick, done in manifest.get("intervened", [])]
    interventions += [
        intervention.model_dump(mode="json", exclude_none=True)
        for intervention in coming(planned, manifest["done"])
    ]
    return manifest["config"] | {
        "interventions": interventions,
        "ticks": max(1, manifest["done"], *(1 + intervention["at"] for intervention in interventions)),
    }


def repeat(
    path: str | Path,
    out: str | Path | Claim | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    threads: int = 1,
    trust: bool = False,
) -> dict[str, Any]:
    """Repeat a recorded run up to the end of its recording, and compare the digests.

    Parameters
    ----------
    path : str or Path
        Folder of the run.
    out : str or Path, optional
        Results folder; default: the repetition is not recorded.
    progress : callable, optional
        Called as `progress(done, ticks)` about ten times a second.
    threads : int, default 1
        Number of threads; affects speed, never results.
    trust : bool, default False
        Whether the code in the folder is allowed to run in this process.

    Returns
    -------
    dict
        world, ticks, interventions, digest, recorded (the recorded digest), same (bool), and why (reasons for
        a difference).

    Raises
    ------
    RecordingError
        If the folder contains no run, or contains a fork, an island, or a run that was killed before it ended.

    Examples
    --------
    >>> from ecs_eco.runs.repeat import repeat
    >>> from ecs_eco.runs.run import run_to_folder
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=2, out="my-run", report=False)
    >>> repeat("my-run")["same"]
    True
    """
    called_with("progress", progress, "done", "ticks")
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
    listed = ", ".join(f"{k} {v}" for k, v in other.items())
    why = f"; it was recorded with versions other than {listed}" if other else ""
    if mode := portable.other_mode(manifest):
        why += f"; it {mode}"
    elif (here := portable.target()["cpu"]) != (cpu := manifest.get("target", {}).get("cpu", here)):
        why += f"; it was recorded on another processor ({cpu}; this one is {here})"
    return {
        "world": config.name,
        "ticks": done,
        "interventions": len(manifest.get("intervened", [])),
        "digest": digest,
        "recorded": manifest["digest"],
        "same": digest == manifest["digest"],
        "why": why,
    }
