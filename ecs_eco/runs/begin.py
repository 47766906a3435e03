"""Start a recorded run by writing its policies, a first checkpoint and its manifest, or restart it."""

import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ecs_eco.config import WorldConfig
from ecs_eco.config.measurements import measured
from ecs_eco.ecosystem import World
from ecs_eco.engine import files
from ecs_eco.engine.errors import RecordingError
from ecs_eco.learning.weights import hash_of
from ecs_eco.record import belonging, checkpoint, freeze as frozen
from ecs_eco.record.claim import DATA, Claim, claimed, remove_start
from ecs_eco.record.code import keep_copies, noted, recorded, sources
from ecs_eco.record.folder import Folder
from ecs_eco.record.genomes import genes_of
from ecs_eco.record.land import keep_land
from ecs_eco.record.recorder import Recorder
from ecs_eco.record.seal import write_manifest
from ecs_eco.worlds.policies import Policies

POLICIES = "policies"  # the folder with the initial policies of a run


@contextmanager
def begun(out: str | Path | Claim) -> Iterator[Claim]:
    """Claim a folder for a run; if the run ends before it has a manifest, it leaves nothing behind."""
    with claimed(out) as claim:
        try:
            yield claim
        except BaseException:
            if not (claim.path / "manifest.json").exists():
                remove_start(claim.path)
            raise


def begin(
    world: World,
    claim: Claim,
    manifest: dict[str, Any],
    weights: Mapping[str, Path],
    prepare: Callable[[Any], None] | None,
) -> Folder:
    """Begin a recording in a claimed folder: write policies, a first checkpoint and finally the manifest.

    Raises ConfigError if a species waits for external decisions.
    """
    folder = opened(world, claim, manifest, weights, prepare)
    keep_checkpoint(world, folder, manifest)
    manifest |= folder.written
    keep_manifest(folder, manifest)
    return folder


def opened(
    world: World,
    claim: Claim,
    manifest: dict[str, Any],
    weights: Mapping[str, Path],
    prepare: Callable[[Any], None] | None = None,
) -> Folder:
    """Write a run's policies, code, data and land to its folder, begin its recording, complete its manifest."""

    if world.awaited is not None:
        world.awaited.require()
    manifest["weights"] = {
        name: _copy(file, claim.path / POLICIES / f"{name}.safetensors") for name, file in weights.items()
    }
    manifest["id"] = belonging.identity(manifest)
    folder = recording(claim, world, manifest)
    if prepare is not None:
        prepare(world)
    manifest |= {
        "species": world.recorder.names,
        "causes": world.causes,
        "finished": False,
        "done": world.tick,
        "colors": {name: world.tables[name].species.color for name in world.recorder.names},
        "code": noted(sources(world.config)),
        "genomes": {name: genes for name in world.recorder.names if (genes := genes_of(world.tables[name]))},
    }
    keep_copies(sources(world.config), claim.path)
    if "forked" not in manifest:
        _keep_data(world.config, claim.path)
    if (land := keep_land(world, claim.path)) is not None:
        manifest["land"] = land
    return folder


def recording(claim: Claim, world: World, manifest: Mapping[str, Any]) -> Folder:
    """Return a run's folder, and record the world in it unless the world already has a recorder; all parts
    contain the run's id."""
    run = {"run": manifest["id"], "world": manifest["world"], "seed": manifest["seed"]}
    folder = Folder(claim.path, world, run, claim)
    if world.recorder is None:
        Recorder(world, folder.sink, snapshot_every=manifest["snapshot_every"], record=manifest.get("record"))
    return folder


def keep_checkpoint(world: World, folder: Folder, manifest: Mapping[str, Any]) -> None:
    """Write a checkpoint of a run, and delete all but the last `keep`."""
    meta, arrays = frozen.freeze(world)
    meta["run"] = {"id": manifest["id"], **folder.written}
    place = folder.path / "checkpoints"
    if folder.claim is not None:
        folder.claim.check()
    checkpoint.write(place / checkpoint.name_of(world.tick), meta, arrays)
    for old in sorted(place.glob(f"tick-*{checkpoint.SUFFIX}"))[: -max(1, manifest["keep"])]:
        old.unlink(missing_ok=True)


def keep_manifest(folder: Folder, manifest: Mapping[str, Any]) -> None:
    """Write a run's manifest to its claimed folder."""
    if folder.claim is not None:
        folder.claim.check()
    write_manifest(folder.path, manifest)


def start_of(
    path: Path, manifest: Mapping[str, Any], config: Mapping[str, Any] | None = None, trust: bool = False
) -> dict[str, Any]:
    """Return the arguments of `World.from_config` that restart a recorded run with its own policies, even if
    its folder has moved.

    `config` replaces the manifest's configuration. Raises RecordingError if a policy differs from the run's
    initial policy; can also raise ConfigError.
    """
    policies, weights = manifest["policies"], manifest.get("weights", {})
    for name, wanted in weights.items():
        _check_policy(path / POLICIES / f"{name}.safetensors", wanted)
    if weights:
        names = manifest["config"]["species"]
        others = policies if isinstance(policies, dict) else dict.fromkeys(names, policies)
        policies = {
            name: str(path / POLICIES) if name in weights else others.get(name, "trained") for name in names
        }
    return {
        "config": config_of(manifest, config, path, trust),
        "seed": manifest["seed"],
        "policies": policies,
        "learn": manifest["learn"],
        "controls": manifest.get("controls", ()),
    }


def config_of(
    manifest: Mapping[str, Any],
    config: Mapping[str, Any] | None = None,
    path: Path = Path(),
    trust: bool = False,
) -> Any:
    """Return the configuration of a recorded run, whose policies are in its folder. Raises ConfigError."""

    data = dict(manifest["config"] if config is None else config)
    if "id" in manifest:
        data["species"] = {
            name: species | {"policy": (species.get("policy") or {}) | {"file": None}}
            for name, species in data["species"].items()
        }
    return recorded(path, manifest, data, trust)


def policies_as_json(policies: Policies) -> Any:
    """Return the initial policies in JSON form: a name or a folder, or a dict of these by species."""
    return (
        {name: str(source) for name, source in policies.items()}
        if isinstance(policies, Mapping)
        else str(policies)
    )


def _copy(file: Path, into: Path) -> str:
    """Copy a policy file, and return its SHA-256 hash."""
    content = files.read_bytes(file)
    into.parent.mkdir(exist_ok=True)
    files.write(into, content)
    return hashlib.sha256(content).hexdigest()


def _check_policy(file: Path, wanted: str) -> None:

    try:
        actual = hash_of(file)
    except OSError as error:
        what = "the initial policy of this run cannot be read"
        raise RecordingError(f"{file}: {what}: {error.strerror}") from None
    if actual != wanted:
        raise RecordingError(
            f"{file}: is not the initial policy of this run: its SHA-256 is {actual[:12]}…, expected "
            f"{wanted[:12]}…"
        )


def _keep_data(config: WorldConfig, folder: Path) -> None:
    """Copy the data file named in [data], if available, to a run's folder for its report.

    Raises ConfigError if the data file cannot be used.
    """
    if config.data is not None and measured(config, config._source) is not None:
        files.write(folder / DATA, files.read_bytes(config.file(config.data.file)))
