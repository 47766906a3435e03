"""The outcome for one truncated or damaged file in a run: a clear error, the same content, or a failure."""

from __future__ import annotations

import json
import random
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from studies.common.fuzz.guard import guarded
from studies.common.fuzz.sources import parsed, sources
from studies.common.fuzz.worlds import counted

TICKS, EVERY = 24, 8
KINDS = ("series", "births", "deaths", "snapshots")


def tried(chunk: dict[str, Any], files: int) -> dict[str, Any]:
    """Return outcome counts by kind for one chunk of damaged files, and details of the failures."""
    items = [(chunk["source"], chunk["what"], chunk["seed"] * 1_000_000 + i) for i in range(files)]
    with tempfile.TemporaryDirectory(prefix="ecs-eco-fuzz-") as folder:
        whole = Path(folder) / "whole"
        recorded(chunk["source"], whole)
        judge = {"checkpoint": _Checkpoints, "recording": _Recordings}[chunk["what"]](
            whole, Path(folder) / "damaged"
        )
        return counted(list(guarded(judge, items, seconds=30.0)), items)


def recorded(source: str, folder: Path) -> None:
    """Return a short run's folder, with checkpoints."""
    from ecs_eco.record import run_to_folder

    text, home = _text(source)
    data = parsed(text)
    for species in data["species"].values():
        if species.get("policy", {}).get("kind", "none") != "none":
            species["policy"]["learn"] = True
        if home is not None and "file" in species.get("policy", {}):
            species["policy"]["file"] = str(home / species["policy"]["file"])
    run_to_folder(data, ticks=TICKS, out=folder, report=False, snapshot_every=EVERY, checkpoint_every=EVERY)


@cache
def _text(source: str) -> tuple[str, Path | None]:
    return sources()[source]


def damage(raw: bytes, chance: random.Random) -> bytes:
    """Return the bytes truncated, or with some of them changed, removed or inserted; the result always
    differs."""
    ways = (_truncated, _truncated, _flipped, _flipped, _flipped, _overwritten, _lost, _put_in)
    while (out := chance.choice(ways)(raw, chance)) == raw:
        pass
    return out


def _place(raw: bytes, chance: random.Random) -> int:
    """Return a random position, sometimes near an end, where file formats keep headers and footers."""
    n, near = len(raw), min(len(raw), chance.choice((16, 256, 4096)))
    return min(
        max(chance.choice((chance.randrange(n), chance.randrange(near), n - 1 - chance.randrange(near))), 0),
        n - 1,
    )


def _truncated(raw: bytes, chance: random.Random) -> bytes:
    return raw[: _place(raw, chance)]


def _flipped(raw: bytes, chance: random.Random) -> bytes:
    out = bytearray(raw)
    for _ in range(chance.choice((1, 1, 1, 1, 2, 8, 64))):
        out[_place(raw, chance)] ^= 1 << chance.randrange(8)
    return bytes(out)


def _overwritten(raw: bytes, chance: random.Random) -> bytes:
    at, n = _place(raw, chance), chance.choice((1, 8, 512, 4096))
    n = min(n, len(raw) - at)
    return raw[:at] + chance.choice((b"\0" * n, b"\xff" * n, chance.randbytes(n))) + raw[at + n :]


def _lost(raw: bytes, chance: random.Random) -> bytes:
    at = _place(raw, chance)
    return raw[:at] + raw[at + chance.choice((1, 8, 512, 4096)) :]


def _put_in(raw: bytes, chance: random.Random) -> bytes:
    at = chance.choice((_place(raw, chance), len(raw)))
    return raw[:at] + chance.randbytes(chance.choice((1, 8, 512))) + raw[at:]


def _copied(whole: Path, folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(whole, folder)


class _Judge:
    """Puts a damaged file into a copy of an intact folder and runs every reader of that file."""

    def __init__(self, whole: Path, folder: Path) -> None:
        self.whole, self.folder = whole, folder
        _copied(whole, folder)

    def __call__(self, item: tuple[str, str, int]) -> dict[str, Any]:
        import traceback

        chance = random.Random(item[2])
        path = chance.choice(self.files())
        raw = (self.whole / path).read_bytes()
        (self.folder / path).write_bytes(damage(raw, chance))
        try:
            outcome = self.asked(path, item[2])
        except Exception:
            outcome = {"kind": "traceback", "said": traceback.format_exc()[-1500:]}
        (self.folder / path).write_bytes(raw)
        return outcome | {"file": str(path)}

    def files(self) -> list[Path]:
        raise NotImplementedError

    def asked(self, path: Path, seed: int) -> dict[str, Any]:
        raise NotImplementedError


class _Checkpoints(_Judge):
    def files(self) -> list[Path]:
        return [sorted((self.whole / "checkpoints").glob("tick-*"))[-1].relative_to(self.whole)]

    def asked(self, path: Path, seed: int) -> dict[str, Any]:
        from ecs_eco.engine.errors import CheckpointError
        from ecs_eco.record import checkpoint

        damaged, (meta, arrays) = self.folder / path, checkpoint.read(self.whole / path)
        try:
            loaded = checkpoint.read(damaged)
        except CheckpointError as error:
            if str(damaged) not in str(error):
                return {"kind": "no location", "said": str(error)}
            return self._without(damaged, str(error), seed)
        same = (
            loaded[0] == meta
            and loaded[1].keys() == arrays.keys()
            and all(_equal(loaded[1][k], arrays[k]) for k in arrays)
        )
        return (
            {"kind": "same content"}
            if same
            else {"kind": "wrong load", "said": "read() returns something else"}
        )

    def _without(self, damaged: Path, message: str, seed: int) -> dict[str, Any]:
        """Check that readers use the checkpoint before the damaged one and, in some trials, that the resumed
        run ends in the same state as the intact run."""
        from ecs_eco.engine.errors import CheckpointError
        from ecs_eco.record import checkpoint

        try:
            if checkpoint.describe(damaged) != checkpoint.describe(
                self.whole / damaged.relative_to(self.folder)
            ):
                return {"kind": "wrong load", "said": "describe() returns something else"}
        except CheckpointError:
            pass
        before = sorted(damaged.parent.glob("tick-*"))[-2]
        if checkpoint.latest(damaged.parent, complain=lambda text: None) != before:
            return {"kind": "wrong load", "said": "latest() does not return the previous checkpoint"}
        if seed % 250 == 0:
            wrong = _command("resume", str(self.folder), "--quiet", "--no-report")
            end = json.loads((self.folder / "manifest.json").read_text())["digest"]
            _copied(self.whole, self.folder)
            if wrong or end != json.loads((self.whole / "manifest.json").read_text())["digest"]:
                return {"kind": "wrong load", "said": wrong or "the resumed run ends differently"}
        words = {
            "its header is damaged": "header",
            "the part": "part",
            "is not a complete checkpoint": "incomplete",
            "is not a checkpoint": "incomplete",
        }
        word = next((words[w] for w in words if w in message), "other")
        return {"kind": "refused", "problems": {f"checkpoint: {word}": 1}}


class _Recordings(_Judge):
    def files(self) -> list[Path]:
        parts = [
            p.relative_to(self.whole) for kind in KINDS for p in sorted((self.whole / kind).glob("*.parquet"))
        ]
        return [Path("manifest.json"), *parts]

    def asked(self, path: Path, seed: int) -> dict[str, Any]:
        from ecs_eco.engine.errors import RecordingError

        refused, readers = [], _readers(path)
        for name, read in readers.items():
            try:
                if not _equal(read(self.folder), self.content(name)):
                    return {"kind": "wrong load", "said": f"{name} gives something else"}
            except RecordingError as error:
                if str(self.folder / path) not in str(error):
                    return {"kind": "no location", "said": f"{name}: {error}"}
                refused.append(name)
        for words in [
            ("lineage", str(self.folder)),
            *([("report", str(self.folder))] if seed % 125 == 0 else []),
        ]:
            if wrong := _command(*words):
                return {"kind": "traceback", "said": wrong}
        if not refused:
            return {"kind": "same content"}
        what = "manifest" if path.suffix == ".json" else "part"
        return {"kind": "refused", "problems": {f"{what}: {reader}": 1 for reader in refused}}

    def content(self, name: str) -> Any:
        """Return a reader's report on the intact folder."""
        self.kept: dict[str, Any] = getattr(self, "kept", {})
        if name not in self.kept:
            self.kept[name] = _ALL[name](self.whole)
        return self.kept[name]


def _series(folder: Path) -> Any:
    from ecs_eco.analysis.runs import load_series

    series = load_series(folder)
    return [series.ticks, series.species, series.columns, series.manifest]


def _lineage(folder: Path) -> Any:
    from ecs_eco.analysis.lineage import Lineage

    return vars(Lineage.read(folder))


def _report(folder: Path) -> Any:
    from ecs_eco.analysis.report.write import ages_at_death, last_snapshot

    return [ages_at_death(folder), last_snapshot(folder, ("grass", "goat", "moss", "ram", "lynx"))]


def _parts(folder: Path) -> Any:
    from ecs_eco.record.parquet import read_parts

    return {kind: read_parts(folder / kind).to_pydict() for kind in KINDS if (folder / kind).is_dir()}


_ALL = {"load_series": _series, "Lineage.read": _lineage, "report": _report, "read_parts": _parts}


def _readers(path: Path) -> dict[str, Any]:
    return _ALL


def _equal(a: Any, b: Any) -> bool:
    """Return whether two readings are identical bit for bit; NaN equals itself."""
    if isinstance(a, np.ndarray) and a.dtype != object:
        return (
            isinstance(b, np.ndarray)
            and a.dtype == b.dtype
            and a.shape == b.shape
            and a.tobytes() == b.tobytes()
        )
    if isinstance(a, dict):
        return isinstance(b, dict) and list(a) == list(b) and all(_equal(a[k], b[k]) for k in a)
    if isinstance(a, list | tuple | np.ndarray):
        return len(a) == len(b) and all(_equal(x, y) for x, y in zip(a, b, strict=True))
    return a is b or a == b or (a != a and b != b)


def _command(*words: str) -> str:
    """Return what is wrong with how a command exited; "" if it succeeded or ended with a clear error."""
    from typer.testing import CliRunner

    from ecs_eco.cli.app import app

    done = CliRunner().invoke(app, list(words))
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        return f"{words[0]}: {type(done.exception).__name__}: {done.exception}"
    if "Traceback" in done.output or done.exit_code not in (0, 1, 2):
        return f"{words[0]}: ends with {done.exit_code}: {done.output[-500:]}"
    return (
        ""
        if done.exit_code == 0 or done.stderr.strip()
        else f"{words[0]}: ends with {done.exit_code} and prints nothing"
    )
