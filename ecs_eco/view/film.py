"""Films of a recorded run: frames piped to ffmpeg, or a GIF."""

import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecs_eco.engine import files

CODECS = {
    ".mp4": "libx264 -pix_fmt yuv420p -preset medium -crf 20 -movflags +faststart",
    ".mkv": "libx264 -pix_fmt yuv420p -preset medium -crf 20",
    ".mov": "libx264 -pix_fmt yuv420p -preset medium -crf 20 -movflags +faststart",
    ".webm": "libvpx-vp9 -pix_fmt yuv420p -crf 32 -b:v 0",
}
"""The ffmpeg arguments after `-c:v`, by file suffix."""
ENDINGS = (*CODECS, ".gif")
SECONDS = 60  # default maximum length of a film


class FilmError(RuntimeError):
    """Raised if a film cannot be made because ffmpeg is missing or failed."""


def ticks_of(first: int, last: int, fps: float, step: int | None = None) -> range:
    """Return the ticks of a film's frames, `step` ticks apart. By default, the film lasts at most SECONDS."""
    n = last + 1 - first
    return range(first, last + 1, step or max(1, -(-n // max(1, round(fps * SECONDS)))))


# the scenes of a story, as in static/tour.js
MOST, LONGEST = 10, 8  # maximum number of events; maximum length of a scene [s]
LEAD, TAIL = 30, 10  # ticks before and after an event
RANK = ("extinct", "sweep", "birth", "return", "boom", "crash")  # of too many, the last kinds are left out


class Scene(NamedTuple):
    """A part of a story: its ticks and its caption, "" for the beginning and the end."""

    first: int
    last: int
    caption: str


def scenes_of(entries: Sequence[dict[str, Any]], first: int, last: int) -> list[Scene]:
    """Return the scenes of a run's story in order; each begins where the one before has ended, or later."""
    ranked = sorted(entries, key=lambda entry: RANK.index(entry["kind"]))[:MOST]
    ranked.sort(key=lambda entry: entry["tick"])
    scenes, nexts = [Scene(first, min(last, first + TAIL), "")], [*(e["tick"] for e in ranked[1:]), last]
    for entry, after in zip(ranked, nexts, strict=False):
        begin, tick = max(scenes[-1].last, entry["tick"] - LEAD), entry["tick"]
        end = max(begin + 1, tick + min(TAIL, -(-(after - tick) // 2)))
        text = " ".join(filter(None, (f"Tick {tick:,}. {entry['text']}.", entry["cause"])))
        scenes.append(Scene(begin, min(last, end), text))
    return [*scenes, Scene(max(scenes[-1].last, last - TAIL), last, "")]


def frames_of(scenes: Sequence[Scene], fps: float) -> list[int]:
    """Return the tick of each frame of a story, which lasts at most SECONDS."""
    n = round(fps * min(LONGEST, SECONDS / len(scenes)))
    return [
        tick
        for scene in scenes
        for tick in np.linspace(scene.first, scene.last, n).round().astype(int).tolist()
    ]


def encoder(path: Path) -> str:
    """Return the encoder for films with this suffix ("" for a GIF); raise FilmError if it is missing."""
    if path.suffix.lower() == ".gif":
        return ""
    program = shutil.which("ffmpeg")
    if program is None:
        raise FilmError("ffmpeg is not installed")
    return program


def write(
    path: Path,
    ticks: Sequence[int],
    paint: Callable[[int], np.ndarray],
    size: tuple[int, int],
    fps: float,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Path:
    """Write a film of these ticks, painted as u8[height, width, 3]. The file appears only once it is complete.
    Raises FilmError, OSError."""

    def painted() -> Iterator[np.ndarray]:
        frame = np.zeros(0, np.uint8)
        for done, tick in enumerate(ticks, 1):
            frame = frame if done > 1 and tick == ticks[done - 2] else paint(tick)
            yield frame
            progress(done, len(ticks))

    program = encoder(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with files.writing(path) as beside:
        if program:
            _pipe(program, beside, path.suffix.lower(), painted(), size, fps)
        else:
            _gif(beside, painted(), fps)
    return path


def _pipe(
    program: str, path: Path, kind: str, frames: Iterator[np.ndarray], size: tuple[int, int], fps: float
) -> None:
    raw = f"-y -loglevel error -f rawvideo -pix_fmt rgb24 -s {size[0]}x{size[1]} -r {fps:g} -i -"
    muxer = {".mkv": "matroska"}.get(kind, kind[1:])
    coded = f"-an -c:v {CODECS[kind]} -f {muxer}"
    command = [program, *raw.split(), *coded.split(), str(path)]
    with tempfile.TemporaryFile() as log:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=log)
        assert process.stdin is not None
        try:
            for frame in frames:
                process.stdin.write(frame.tobytes())
        except BrokenPipeError:
            pass  # ffmpeg has exited; its log gives the reason
        except BaseException:
            process.kill()
            raise
        finally:
            with suppress(BrokenPipeError):
                process.stdin.close()
            process.wait()
        if process.returncode:
            log.seek(0)
            lines = log.read().decode(errors="replace").strip().splitlines()
            raise FilmError(
                f"ffmpeg exited with code {process.returncode}: "
                f"{lines[-1] if lines else 'it printed no reason'}"
            )


def _gif(path: Path, frames: Iterator[np.ndarray], fps: float) -> None:
    """Write a GIF in which every frame uses the palette of the first frame."""
    from PIL import Image

    first = Image.fromarray(next(frames)).quantize(colors=128, dither=Image.Dither.NONE)

    def rest() -> Iterator[Any]:
        for frame in frames:
            yield Image.fromarray(frame).quantize(palette=first, dither=Image.Dither.NONE)

    first.save(
        path, format="GIF", save_all=True, append_images=rest(), duration=max(20, round(1000 / fps)), loop=0
    )
