"""A recorded run as one file: the viewer's page together with the run's data, which opens without a server.

The file stores all lives, and the states of all organisms at some ticks, as columns. In the page,
static/shelf.js takes the server's place and interpolates between these ticks.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from collections.abc import Callable
from html import escape

import numpy as np

from ecs_eco.engine.errors import RecordingError
from ecs_eco.view.account import of_run
from ecs_eco.view.modules import STATIC, modules
from ecs_eco.view.recording import GeneValues
from ecs_eco.view.replay import Replay
from ecs_eco.view.scene import drawn
from ecs_eco.view.source import Message, text

MOST = 10_000_000  # [bytes] default maximum size of a file
SAMPLES = 200  # maximum number of ticks at which states are stored
ROWS = 3_000_000  # maximum number of stored states of a species
FINE, COARSE = 65534, 254  # steps of stored values, from 1; 0: unknown
AXES, EVENT = "xyz", ("uid", "species", "x", "y", "z", "energy")
STYLE = re.compile(r'<link rel="stylesheet" href="(\w+\.css)">')
OFFLINE = {"socket.js": "shelf.js"}  # the module that connects a page to its server, and its replacement
POLICY = (
    "default-src 'none'; script-src 'sha256-{}' blob:; style-src 'unsafe-inline'; img-src data: blob:; "
    "media-src blob:; base-uri 'none'; form-action 'none'"
)
Table = dict[str, np.ndarray]


def page(
    replay: Replay, most: int = MOST, progress: Callable[[int, int], None] = lambda done, total: None
) -> str:
    """Return a recorded run as the HTML text of one page, which needs neither a server nor a network.

    Population sizes, births and deaths are exact in every tick. States are stored at no more than `SAMPLES`
    ticks. If the page would be larger than `most`, it has only every second, fourth, … organism of the
    species with the most data. The page reports how it was thinned.

    Parameters
    ----------
    replay : Replay
        The recorded run.
    most : int, optional
        Maximum size of the page [bytes].
    progress : callable, optional
        Called with the number of finished steps and the number of all steps.

    Raises
    ------
    RecordingError
        If `most` is too small for a page with organisms.

    Examples
    --------
    >>> from ecs_eco.runs.run import run_to_folder
    >>> from ecs_eco.view.export import page
    >>> from ecs_eco.view.replay import Replay
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=5, out="to-share", report=False)
    >>> page(Replay("to-share"))[:15]
    '<!doctype html>'
    """
    stored = _Stored(replay, progress)
    kinds = {name: stored.kind(name) for name in replay.species}
    clock, shell = stored.clock(), _shell(str(replay.hello()["title"]))
    while True:
        head = stored.head({"clock": clock[0], "kinds": [head for head, _ in kinds.values()]})
        parts = [_squeezed(text(head).encode()), clock[1], *(part for _, part in kinds.values())]
        data = "\n".join(f'<script type="text/plain" data-part>{part}</script>' for part in parts)
        if len(shell.encode()) + len(data) <= most:
            return shell.replace("<!-- run -->", data)
        name = max(kinds, key=lambda name: len(kinds[name][1]))
        if not kinds[name][0]["columns"][0][2]:  # no organism is left
            raise RecordingError(f"{replay.recording.path}: does not fit into {most / 1e6:g} MB")
        stored.every[name] *= 2
        kinds[name] = stored.kind(name)


class _Stored:
    """The run as stored in a file: of each species, the organisms whose uids are multiples of `every`."""

    def __init__(self, replay: Replay, progress: Callable[[int, int], None]) -> None:
        r = self.recording = replay.recording
        self.replay, self.genes = replay, GeneValues(r)
        known = 1 if r.manifest.get("record") == "full" else r.every  # ticks between recorded states
        self.step = step = known * -(-(r.last + 1 - r.first) // (known * SAMPLES))
        ticks = range(-(-r.first // step) * step, r.last + 1, step)
        self.n = r.column("n").astype(np.uint32)
        sizes = self.n[ticks.start - r.first :: step].sum(axis=0, dtype=np.int64) // ROWS
        self.every = {s: 1 << int(size).bit_length() for s, size in zip(r.species, sizes, strict=True)}
        states: dict[str, list[Table]] = {name: [] for name in r.species}
        for done, tick in enumerate(ticks, 1):
            for name, rows in states.items():
                state = r.organisms(tick, name)._asdict()
                rows.append(_every(state | {"tick": np.full(state["uid"].size, tick)}, self.every[name]))
            progress(done, len(ticks))
        self.seen = {
            name: {key: np.concatenate([part[key] for part in rows]) for key in rows[0]}
            for name, rows in states.items()
        }
        born = r.births.between(-(2**62), r.last, (*EVENT, "parent", "parent2"))
        died = r.deaths.between(-(2**62), r.last, (*EVENT, "cause", "killer"))
        self.born, self.died = (
            {name: _where(rows, rows["species"] == s) for s, name in enumerate(r.species)}
            for rows in (born, died)
        )

    def kind(self, name: str) -> tuple[Message, str]:
        """Return the lives of a species, sorted by uid, and the states of one life after the other."""
        r, step = self.recording, self.step
        born, died, seen = (_every(of[name], self.every[name]) for of in (self.born, self.died, self.seen))
        uid = np.union1d(born["uid"], seen["uid"]).astype(np.uint64)
        died = _where(died, np.isin(died["uid"], uid))
        b, d, s = (np.searchsorted(uid, rows["uid"].astype(np.uint64)) for rows in (born, died, seen))
        begin, latest = np.full(uid.size, r.last + 1), np.full(uid.size, r.first - 1)
        np.minimum.at(begin, s, seen["tick"])
        np.maximum.at(latest, s, seen["tick"])
        begin[b] = born["tick"]
        # without a death, an organism that a later state lacks has left the world
        gone = np.maximum(begin, latest) // step < r.last // step
        end = np.where(gone, (np.maximum(begin, latest) // step + 1) * step, r.last + 1)
        end[d] = died["tick"]
        first = -(-np.maximum(begin, r.first) // step)
        start = np.append(0, np.cumsum(np.maximum(0, -(-end // step) - first)))
        row = start[s] + seen["tick"] // step - first[s]
        s, seen, row = s[row < start[s + 1]], _where(seen, row < start[s + 1]), row[row < start[s + 1]]

        full = r.energy_max(name)
        scales = {"energy": [0.0, full]}
        if (happy := seen["happiness"][np.isfinite(seen["happiness"])]).size:
            scales["happiness"] = [float(happy.min()), float(happy.max())]
        out: Table = {
            "uid": np.diff(uid, prepend=np.uint64(0)),
            "born": np.diff(begin, prepend=0),
            "span": end - begin,
            "dies": np.isin(uid, died["uid"]),
        }
        for axis, length in zip(AXES, r.size, strict=False):
            at = np.zeros(uid.size, np.uint16)  # states and deaths are stored relative to births
            at[s[::-1]], at[b] = _share(seen[axis], length)[::-1], _share(born[axis], length)
            out |= {axis: at, f"{axis} at death": _filled(uid.size, d, _share(died[axis], length) - at[d])}
            out[f"{axis} later"] = _filled(start[-1], row, _share(seen[axis], length) - at[s])
        turn = np.floor(seen["heading"] * (256 / (2 * np.pi)) + 0.5).astype(np.int64) & 255
        out["heading later"] = _filled(start[-1], row, turn.astype(np.uint8))
        out["energy"] = _filled(uid.size, b, _code(born["energy"], scales["energy"]))
        out["energy at death"] = _filled(uid.size, d, _code(died["energy"], scales["energy"]))
        for state in scales:
            out[f"{state} later"] = _filled(start[-1], row, _code(seen[state], scales[state]))
        for key, rows, of in (("parent", born, b), ("parent2", born, b), ("killer", died, d)):
            out[key] = _filled(uid.size, of, rows[key].astype(np.uint64))
        out["cause"] = _filled(uid.size, d, died["cause"].astype(np.int16))
        out["family"] = self.replay.families.values(name, uid)
        for gene, code in self.replay.genes.get(name, {}).items():
            scales[f"gene:{gene}"] = [float(code.low), float(code.high)]
            values = self.genes.expressed(name, uid, gene)
            out[f"gene:{gene}"] = _code(values, scales[f"gene:{gene}"], COARSE).astype(np.uint8)
        oldest = int((end - begin).max(initial=1))
        columns, part = _packed(out)
        return {"name": name, "scales": scales, "every": self.every[name], "oldest": oldest, **columns}, part

    def clock(self) -> tuple[Message, str]:
        """Return population sizes and light in every tick, and all objects, which never change."""
        r, replay = self.recording, self.replay
        out = {f"n {name}": self.n[:, s] for s, name in enumerate(r.species)}
        if replay.hello()["day"] is not None:
            out["light"], out["sun"] = np.array([r.sky(tick) for tick in range(r.first, r.last + 1)]).T
        frame = np.frombuffer(replay.frame(0, "species"), "<u4")[7:]
        counts, words = np.split(frame, [len(r.species) + len(replay.objects)])
        alive, there = (3 * int(of.sum()) for of in np.split(counts, [len(r.species)]))
        out["objects"] = np.append(counts[len(r.species) :], words[alive : alive + there])
        return _packed(out)

    def head(self, columns: Message) -> Message:
        """Return everything that the page needs besides columns, and the descriptions of the columns."""
        r, replay = self.recording, self.replay
        hello = replay.hello() | {"tick": r.first, "fields": [], "file": self.about()}
        hello["species"] = [kind | {"every": self.every[kind["name"]]} for kind in hello["species"]]
        lands = sorted({r.first, *(tick for tick, _ in r.manifest.get("intervened", []))})
        return {
            "hello": hello,
            "story": replay.greeting()[1],
            "marks": [[tick, replay.marks() | {"stretches": []} | drawn(r.land(tick))] for tick in lands],
            "series": replay.series(-1),
            "why": of_run(r.path, r.last),
            "causes": r.causes,
            "step": self.step,
            **columns,
        }

    def about(self) -> list[str]:
        """Return sentences about what the file contains."""
        r = self.recording
        states = (
            "in every tick" if self.step == 1 else f"every {self.step} ticks, and interpolated in between"
        )
        words = "The file contains 1 in {1} {0}; numbers and charts count all of them."
        return [
            f"This page is a file with a recorded run of {r.last + 1 - r.first:,} ticks. It needs no server and "
            "no network.",
            "Numbers of organisms, births and deaths are exact in every tick. Positions, energy and happiness "
            f"are stored {states}.",
            *(words.format(name, every) for name, every in self.every.items() if every > 1),
            "The file does not contain what animals sensed and decided, genomes, family trees, the table of all "
            "organisms, or maps of fields. To see these, watch the run's folder: ecs-eco watch DIR.",
        ]


def _where(rows: Table, keep: np.ndarray) -> Table:
    return {key: column[keep] for key, column in rows.items()}


def _every(rows: Table, every: int) -> Table:
    return _where(rows, rows["uid"].astype(np.uint64) % np.uint64(every) == 0)


def _filled(size: int, at: np.ndarray, values: np.ndarray) -> np.ndarray:
    out = np.zeros(size, values.dtype)
    out[at] = values
    return out


def _share(place: np.ndarray, length: float) -> np.ndarray:
    """Return positions [m] as in frames: u16 shares of the world's length."""
    share = np.float32(65535 / length) if length > 0 else np.float32(0)
    return np.floor(np.clip(place * share, 0, 65535) + np.float32(0.5)).astype(np.uint16)


def _code(values: np.ndarray, scale: list[float], steps: int = FINE) -> np.ndarray:
    """Return values as numbers from 1 to `steps` + 1 on their scale, 0 if unknown: u16[n]."""
    share = np.clip((values.astype(np.float64) - scale[0]) / max(scale[1] - scale[0], 1e-30), 0, 1)
    return np.nan_to_num(1 + np.rint(steps * share)).astype(np.uint16)


def _packed(columns: Table) -> tuple[Message, str]:
    """Return the name, type and length of each column, and all columns, compressed."""
    plain = {key: _narrow(column) for key, column in columns.items()}
    told = [(key, column.dtype.str[1:], column.size) for key, column in plain.items()]
    return {"columns": told}, _squeezed(b"".join(column.tobytes() for column in plain.values()))


def _narrow(column: np.ndarray) -> np.ndarray:
    """Return a column in the smallest type that represents its integers exactly; floats in single precision."""
    if column.dtype.kind == "f":
        return column.astype("<f4")
    low, high = (int(column.min()), int(column.max())) if column.size else (0, 0)
    kinds = {"|u1": (0, 2**8), "<u2": (0, 2**16), "<u4": (0, 2**32), "<i4": (-(2**31), 2**31)}
    return column.astype(next((kind for kind, (a, b) in kinds.items() if a <= low and high < b), "<f8"))


def _squeezed(data: bytes) -> str:
    return base64.b64encode(gzip.compress(data, 6, mtime=0)).decode()


def _shell(title: str) -> str:
    """Return the page with its scripts and styles; `<!-- run -->` marks the place of the data."""

    def read(name: str) -> str:
        return (STATIC / name).read_text(encoding="utf-8")

    code, unpack = (
        _squeezed(json.dumps(list(modules("main.js", OFFLINE).items())).encode()),
        read("unpack.js"),
    )
    policy = POLICY.format(base64.b64encode(hashlib.sha256(unpack.encode()).digest()).decode())
    html = STYLE.sub(lambda match: f"<style>{read(match[1])}</style>", read("index.html"))
    for old, new in {
        "<head>": f'<head>\n    <meta http-equiv="Content-Security-Policy" content="{policy}">',
        "<title>ecs-eco</title>": f"<title>{escape(title)} · ecs-eco</title>",
        '<script type="module" src="main.js"></script>': "",
        "</body>": f'<script type="text/plain" id="code">{code}</script>\n<!-- run -->\n'
        f"<script>{unpack}</script>\n</body>",
    }.items():
        html = html.replace(old, new)
    return html
