"""The commands draw, picture and video: images without a browser."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from ecs_eco.analysis.nervous_figure import draw_nervous_system, draw_nervous_systems, save
from ecs_eco.cli.options import Quiet, Run, Set, Size, Trust, World, number
from ecs_eco.cli.terminal import complain, exits, progress, recorded, refuse, say
from ecs_eco.cli.trust import allow
from ecs_eco.config import load
from ecs_eco.engine.errors import RecordingError
from ecs_eco.runs.begin import config_of
from ecs_eco.view import film
from ecs_eco.view.inspect import drawable
from ecs_eco.view.paint import Painter
from ecs_eco.view.replay import Replay
from ecs_eco.view.rerun import compute

SIZES = (320, 7680)  # [px]
DRAWINGS = (".png", ".svg", ".pdf")


@exits
def draw(
    world: World,
    species: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Only this species. Default: all with a nervous system."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="A .png, .svg or .pdf file. Default: WORLD-NAME.png in the current folder."
        ),
    ] = None,
    set_: Set = None,
) -> None:
    """Draw the nervous systems of a world's species."""
    config = load(world, set_ or [])
    name = f"{config.name}-{species or 'nerves'}.png"
    path = _file(out or Path(name), DRAWINGS, "--out", "unsupported format")
    figure = draw_nervous_systems(config, [species] if species else [])
    with _writing(path, "--out"):
        say(f"Drawn in {save(figure, path)}")


@exits
def picture(
    folder: Run,
    out: Annotated[
        Path | None, typer.Argument(metavar="FILE", help="A PNG. Default: WORLD-TICK.png.")
    ] = None,
    tick: Annotated[int | None, number("The tick. Default: the last tick.", least=0, metavar="T")] = None,
    organism: Annotated[
        int | None,
        number("Instead, draw this organism's nervous system at that tick.", most=2**63 - 1, metavar="UID"),
    ] = None,
    size: Size = "1280x720",
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Draw a tick of a recorded run."""
    allow(trust, folder)
    recorded(folder)
    replay = Replay(folder)
    tick = _tick(replay, tick, "--tick", replay.recording.last)
    if organism is not None:
        _draw_nerves(replay, folder, out, tick, organism, quiet)
        return
    path = _file(out or Path(f"{replay.recording.manifest['world']}-{tick}.png"), (".png",))
    with _writing(path):
        say(f"Drawn in {Painter(replay, _size(size)).save(tick, path)}")


@exits
def video(
    folder: Run,
    out: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE",
            help="A .gif file or, with ffmpeg, .mp4, .mkv, .mov or .webm. Default: "
            "WORLD.mp4 in the current folder.",
        ),
    ] = None,
    fps: Annotated[float, typer.Option(metavar="N", help="Frames per second.")] = 30.0,
    from_: Annotated[int | None, number("First tick.", "--from", least=0, metavar="T")] = None,
    to: Annotated[int | None, number("Last tick.", least=0, metavar="T")] = None,
    step: Annotated[
        int | None, number("Ticks between frames. Default: chosen so that the video lasts at most a minute.")
    ] = None,
    story: Annotated[
        bool,
        typer.Option(
            "--story", help="Only the events of the run's story, with captions, in at most a minute."
        ),
    ] = False,
    size: Size = "1280x720",
    quiet: Quiet = False,
) -> None:
    """Make a video of a recorded run."""
    recorded(folder)
    replay = Replay(folder)
    path = _file(out or Path(f"{replay.recording.manifest['world']}.mp4"), film.ENDINGS)
    try:
        film.encoder(path)
    except film.FilmError as error:
        allowed = "a .gif file, which needs no other program, or an installed ffmpeg"
        refuse("OUT", str(error), str(path), allowed, f"{path.stem}.gif")
    first = _tick(replay, from_, "--from", replay.recording.first)
    last = _tick(replay, to, "--to", replay.recording.last)
    if first > last:
        refuse("--to", f"is before --from {first}", last, f"{first} to {replay.recording.last}")
    if not 1 <= fps <= 240:
        refuse("--fps", "invalid value", fps, "1 to 240 frames per second")
    if story and step is not None:
        refuse("--step", "does not apply to --story", step, "only one of these options")
    entries = [entry for entry in replay.story.entries if first <= entry["tick"] <= last] if story else []
    scenes = film.scenes_of(entries, first, last) if story else []
    pixels, each = _size(size), film.ticks_of(first, last, fps, step)
    ticks = film.frames_of(scenes, fps) if story else each
    painter = Painter(replay, pixels, scenes)
    with progress(path.name, quiet, "frames") as bar, _writing(path):
        try:
            film.write(path, ticks, painter.paint, pixels, fps, bar)
        except film.FilmError as error:
            allowed = "an ffmpeg build that supports this format, or a .gif file"
            refuse("OUT", str(error), str(path), allowed)
    how = f"{len(entries)} events" if story else f"one every {each.step} ticks"
    say(f"{len(ticks)} frames, {len(ticks) / fps:.1f} s, {how}, in {path}")


def _draw_nerves(replay: Replay, folder: Path, out: Path | None, tick: int, uid: int, quiet: bool) -> None:
    """Draw one organism's nervous system, from the recording or from a rerun of that part of the run."""
    path = _file(out or Path(f"{replay.recording.manifest['world']}-{uid}-{tick}.png"), DRAWINGS)
    replay.handle({"kind": "seek", "tick": tick})
    try:
        state = replay.organism(uid)
    except KeyError as error:
        refuse("--organism", str(error.args[0]), uid, "the uid of an organism in this run (see births/)")
    species = state["species"]
    if not replay.recording.manifest["config"]["species"][species].get("actions"):
        refuse("--organism", f"is a {species}, which has no nervous system", uid, "an animal")
    if not state["alive"] and state["nerves"] is None:
        ended = state["died"]["tick"] if state["died"] else None
        refuse(
            "--tick",
            f"organism {uid} is not alive at this tick",
            tick,
            f"{state['born'] + 1} to {ended or replay.recording.last}",
        )
    if state["nerves"] is None:
        state = _again(replay, uid, quiet)
    if state["nerves"] is None:
        refuse("--tick", f"organism {uid} has not sensed yet", tick, f"{state['born'] + 1} or later")
    if state["note"]:
        complain(state["note"])

    figure = draw_nervous_system(
        config_of(replay.recording.manifest, path=folder), species, drawable(state["nerves"])
    )
    with _writing(path):
        say(f"Drawn in {save(figure, path)}")


def _again(replay: Replay, uid: int, quiet: bool) -> dict[str, Any]:
    """Rerun the part of the run around the tick, and return the organism's state."""
    r = replay.recording
    with progress("rerunning", quiet) as bar:
        stretch = compute(r.path, r.manifest, replay.tick, min(r.last, replay.tick), r.recorded, bar)
    if stretch.wrong is not None:
        raise RecordingError(
            f"{r.path}: the rerun differs from the recording at tick {stretch.wrong}: "
            "it was recorded with different versions or on a different machine"
        )
    replay.stretches.append(stretch)
    return dict(replay.organism(uid))


def _tick(replay: Replay, tick: int | None, option: str, default: int) -> int:
    r = replay.recording
    if tick is not None and not r.first <= tick <= r.last:
        refuse(option, "was not recorded", tick, f"{r.first} to {r.last}")
    return default if tick is None else tick


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    low, high = SIZES
    if match is None or not all(low <= int(n) <= high for n in match.groups()):
        refuse("--size", "invalid value", text, f"WIDTHxHEIGHT, each {low} to {high}", "1280x720")
    return int(match[1]) // 2 * 2, int(match[2]) // 2 * 2  # encoders need even sizes


def _file(
    path: Path, endings: tuple[str, ...], source: str = "OUT", fault: str = "cannot be written"
) -> Path:
    if path.suffix.lower() not in endings:
        refuse(source, fault, str(path), f"a file ending in {', '.join(endings)}", f"{path.stem}{endings[0]}")
    if path.is_dir():
        refuse(source, "is a folder", str(path), "a file")
    return path


@contextmanager
def _writing(path: Path, source: str = "OUT") -> Iterator[None]:
    """Report a failure to write the file as an invalid argument."""
    try:
        yield
    except OSError as error:
        refuse(
            source, f"cannot be written: {error.strerror or error}", str(path), "a file that can be created"
        )
