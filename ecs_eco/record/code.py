"""Storage of a run's code: sources in the run's folder, and their hashes in the manifest and checkpoints."""

import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ecs_eco.config import WorldConfig, load
from ecs_eco.config.document import read_document
from ecs_eco.config.names import code_of, names_in
from ecs_eco.engine import files
from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError
from ecs_eco.inputs.code import Code, read
from ecs_eco.inputs.section import function_name
from ecs_eco.inputs.session import is_interactive
from ecs_eco.inputs.sources import Source
from ecs_eco.inputs.trust import allowed_here
from ecs_eco.record.land import folder_of_land

FOLDER = "code"  # in a run's folder
Noted = list[dict[str, str]]


def sources(config: WorldConfig | None, names: Iterable[str] = ()) -> tuple[Source, ...]:
    """Return the sources of the code that a world lists, of the modules of objects passed in Python, and of
    other `names` ("module:name"). Each object defined in an interactive session has its own source."""
    listed, names = () if config is None else config._code.sources, list(names)
    entries = [] if config is None else code_of(config)
    entries += [name.partition(":")[0] for name in names]
    if "__main__" in entries and is_interactive():
        used = () if config is None else names_in(config)
        names += [function_name(thing) for key, thing in used if key[0] != "search"]
        entries = [e for e in entries if e != "__main__"] + [n for n in names if n.startswith("__main__:")]
    known = {word for source in listed for word in (source.module, source.entry)}
    more = dict.fromkeys(e for e in entries if e.removesuffix(".py") not in known)
    return (*listed, *read(more, [])[0].sources)


def noted(sources: Iterable[Source]) -> Noted:
    """Return the code's entry for manifests and checkpoints: the name and hash of each source."""
    return [{"entry": s.entry, "sha256": s.sha256} for s in sources]


def keep_copies(sources: Iterable[Source], folder: Path) -> None:
    """Write the sources that are files to a run's folder."""
    if sources := [s for s in sources if s.is_file]:
        (folder / FOLDER).mkdir(exist_ok=True)
        keep_beside(sources, folder / FOLDER)


def keep_beside(sources: Iterable[Source], folder: Path) -> None:
    """Write the sources that are files to a folder."""
    for source in sources:
        if source.is_file and source.text is not None:
            files.write(folder / source.entry, source.text)


def check_code(listed: Any, places: Sequence[Path], where: str, trust: bool = False) -> Code:
    """Return the listed code; raise CheckpointError if it is missing, or has changed without permission."""
    try:
        wanted = {str(n["entry"]): str(n["sha256"]) for n in listed}
    except (TypeError, KeyError):
        raise CheckpointError(f"{where}: its list of code is damaged") from None
    code, problems = read(wanted, places, wanted)
    if problems:
        raise CheckpointError(
            f"{where}: needs code that is missing here: {problems[0].value}: {problems[0].what}"
        )
    changed = [s for s in code.sources if s.sha256 != wanted[s.entry] and not allowed_here(s.sha256)]
    if trust:
        code.allow()
        for source in changed:
            if source.of_session:
                warnings.warn(
                    f"{where}: {source.entry}, or what it reads, has changed; using the current version",
                    stacklevel=2,
                )
    elif changed:
        how, read_too = ("trust=True", ", or what it reads,") if changed[0].of_session else ("--trust", "")
        raise CheckpointError(
            f"{where}: {changed[0].entry}{read_too} has changed: {changed[0].path or 'it'} has the "
            f"SHA-256 {changed[0].sha256}, expected {wanted[changed[0].entry]}; restore it, or use the "
            f"current version: {how}"
        )
    return code


def recorded(path: Path, manifest: Mapping[str, Any], config: Any = None, trust: bool = False) -> WorldConfig:
    """Return a recorded run's configuration, or `config`, with its code. Raises ConfigError, RecordingError."""
    try:
        code = check_code(manifest.get("code", []), [path / FOLDER], str(path), trust)
    except CheckpointError as error:
        raise RecordingError(str(error)) from None
    try:
        document = read_document(manifest["config"] if config is None else config)
        document.folder = folder_of_land(document.data, path, document.folder)
        if any(source.of_session for source in code.sources):
            document.code = code
        return load(document, trust=trust, places=[path / FOLDER])
    except ConfigError as error:
        source = str(path / "manifest.json")
        problems = [p.moved(source=source) if p.source == "dict" else p for p in error.problems]
        raise type(error)(problems, error.title.replace("dict:", f"{source}:", 1)) from None
