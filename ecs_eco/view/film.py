"""Films of a recorded run: frames piped to ffmpeg, or a GIF."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

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

    Raises FilmError, OSError.
    """

    def painted() -> Iterator[np.ndarray]:
        for done, tick in enumerate(ticks, 1):
            yield paint(tick)
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
