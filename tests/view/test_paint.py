import os
import stat
import sys

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from ecs_eco.cli.app import app
from ecs_eco.record import run_to_folder
from ecs_eco.view import film
from ecs_eco.view.paint import Painter, clock
from ecs_eco.view.replay import Replay

SIZE = (640, 360)


def _run(config, out, **options):
    run_to_folder(
        config,
        seed=7,
        out=out,
        **{"ticks": 20, "policies": "random", "report": False, "snapshot_every": 4} | options,
    )
    return out


@pytest.fixture(scope="module")
def folder(menagerie, tmp_path_factory):
    return _run(menagerie(), tmp_path_factory.mktemp("painted") / "run")


@pytest.fixture(scope="module")
def painter(folder):
    return Painter(Replay(folder), SIZE)


def _share(picture, hue, slack=12):
    """What share of a picture has a colour."""
    wanted = np.array([int(hue[i : i + 2], 16) for i in (1, 3, 5)])
    return (np.abs(picture.astype(int) - wanted).max(axis=2) <= slack).mean()


def test_a_picture_shows_every_species_in_its_colour(painter):
    picture = painter.paint(9)
    assert (picture.shape, picture.dtype) == ((360, 640, 3), np.uint8)
    for name in ("moss", "ram", "lynx"):
        assert _share(picture, painter.hues[name], slack=24) > 5e-4  # plants are slightly transparent
    assert _share(picture, "#a8cce6") > 0.005  # the lake
    assert len(set(painter.hues.values())) == 4


def test_the_same_tick_gives_the_same_picture_whatever_was_painted_before(painter, folder):
    first, other = painter.paint(3), painter.paint(14)
    assert (first != other).mean() > 0.002
    assert (painter.paint(3) == first).all()
    assert (Painter(Replay(folder), SIZE).paint(3) == first).all()


def test_who_moves_is_painted_where_it_is(painter):
    picture = painter.paint(8)
    ram = painter.replay.organisms("ram")
    px, py = painter.ax.transData.transform(np.stack([ram.x, ram.y], axis=1)).T
    hue = np.array([int(painter.hues["ram"][i : i + 2], 16) for i in (1, 3, 5)])
    here = [
        np.abs(
            picture[360 - round(y) - 2 : 360 - round(y) + 2, round(x) - 2 : round(x) + 2].astype(int) - hue
        )
        .max(axis=2)
        .min()
        for x, y in zip(px, py, strict=True)
        if 4 < x < 636 and 4 < y < 356
    ]
    assert np.mean(np.array(here) < 60) > 0.8  # some are under others


def test_a_volume_is_painted_from_the_side(menagerie, tmp_path):
    algae = {
        "count": 80,
        "body": {"radius": 0.4, "opaque": False},
        "metabolism": {"energy": 0.5},
        "color": "#1a9641",
    }
    krill = {
        "count": 30,
        "body": {"radius": 0.5},
        "metabolism": {"energy": 0.5},
        "color": "#d7191c",
        "sensors": [{"kind": "light"}],
        "locomotion": {"speed": {"drift": 0.0, "swim": 1.0}, "turn": 0.5, "climb": 0.5},
        "actions": {"speed": ["drift", "swim"], "climb": ["up", "down"]},
        "default_action": {"speed": "swim"},
        "reflex": {"formulas": {"up": "light - 0.5"}},
    }
    sea = {
        "format": 1,
        "name": "sea",
        "space": {"size": [60.0, 60.0, 20.0], "edges": "walls"},
        "species": {"algae": algae, "krill": krill},
    }
    painter = Painter(Replay(_run(sea, tmp_path / "run")), SIZE)
    picture = painter.paint(6)
    assert painter.ax.get_ylabel() == "depth [m]"
    depth = {
        label.get_text(): y
        for label, y in zip(painter.ax.get_yticklabels(), painter.ax.get_yticks(), strict=True)
    }
    assert (depth["0"], depth["20"]) == (20.0, 0.0)  # the floor is below
    assert _share(picture, painter.hues["krill"]) > 2e-4
    painter.replay.recording.scene.environment["light"] = lambda world, x, y, z: np.exp(-(20 - z) / 4).astype(
        np.float32
    )
    dark = painter.paint(6)
    (left, bottom, right, top), high = painter.ax.bbox.extents.astype(int), SIZE[1]
    brightness = dark[high - top + 2 : high - bottom - 2, left + 2 : right - 2].mean(axis=(1, 2))
    assert brightness[:10].mean() > 2 * brightness[-10:].mean()


@pytest.mark.parametrize(
    ("seconds", "day", "words"),
    [
        (0, None, "0 s"),
        (59, None, "59 s"),
        (299, None, "4 min 59 s"),
        (3660, None, "1 h 1 min"),
        (90_000, None, "1 d 1 h"),
        (0, {"length": 100.0, "start": 0.25}, "day 1, 06:00"),
        (150.0, {"length": 100.0, "start": 0.25}, "day 2, 18:00"),
    ],
)
def test_times_in_words(seconds, day, words):
    assert clock(seconds, day) == words


# --- films --------------------------------------------------------------------------------------------------

FAKE = """#!{python}
import sys
data = sys.stdin.buffer.read({limit})
open(sys.argv[-1], "wb").write(b"film of %d bytes" % len(data) + b" " + " ".join(sys.argv[1:-1]).encode())
{end}
"""


@pytest.fixture
def ffmpeg(tmp_path, monkeypatch):
    """A function that puts a program on the path that counts what it is fed."""

    def put(end="", limit=-1):
        place = tmp_path / "bin"
        place.mkdir()
        program = place / "ffmpeg"
        program.write_text(FAKE.format(python=sys.executable, end=end, limit=limit))
        program.chmod(program.stat().st_mode | stat.S_IEXEC)
        monkeypatch.setenv("PATH", str(place))

    return put


def _film(*arguments):
    return CliRunner().invoke(app, ["video", *map(str, arguments)])


def test_a_film_is_frames_to_ffmpeg(folder, tmp_path, ffmpeg):
    ffmpeg()
    done = _film(
        folder,
        tmp_path / "run.mp4",
        "--from",
        4,
        "--to",
        15,
        "--step",
        3,
        "--fps",
        10,
        "--size",
        "640x360",
        "-q",
    )
    assert done.exit_code == 0, done.output
    assert "4 frames, 0.4 s, one every 3 ticks" in done.output
    decoded = (tmp_path / "run.mp4").read_bytes().decode()
    assert decoded.startswith(f"film of {4 * 640 * 360 * 3} bytes")
    assert "-f rawvideo -pix_fmt rgb24 -s 640x360 -r 10 -i - -an -c:v libx264" in decoded
    assert sorted(os.listdir(tmp_path)) == ["bin", "run.mp4"]  # nothing half-made is left


@pytest.mark.parametrize("limit", [-1, 1000])
def test_what_ffmpeg_complains_of_is_said(folder, tmp_path, ffmpeg, limit):
    ffmpeg('print("Unknown encoder", file=sys.stderr); sys.exit(3)', limit)
    done = _film(folder, tmp_path / "run.mp4", "--step", 5, "--size", "640x360", "-q")
    assert done.exit_code == 2
    assert "ffmpeg exited with code 3: Unknown encoder" in done.output
    assert sorted(os.listdir(tmp_path)) == ["bin"]


def test_without_ffmpeg_a_gif_is_offered(folder, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    done = _film(folder, tmp_path / "run.mp4")
    assert done.exit_code == 2
    assert "ffmpeg is not installed; expected: a .gif file" in done.output
    assert 'did you mean "run.gif"' in done.output


def test_a_gif_needs_nothing(folder, tmp_path):
    done = _film(folder, tmp_path / "run.gif", "--to", 8, "--step", 4, "--size", "640x360", "--fps", 5, "-q")
    assert done.exit_code == 0, done.output
    with Image.open(tmp_path / "run.gif") as gif:
        assert (gif.n_frames, gif.size, gif.info["duration"]) == (3, (640, 360), 200)


def test_a_film_of_a_long_run_lasts_a_minute():
    ticks = film.ticks_of(0, 9_999, 30)
    assert (ticks.step, len(ticks)) == (6, 1667)
    assert film.ticks_of(0, 99, 30) == range(100)
    assert film.ticks_of(5, 9, 30, 2) == range(5, 10, 2)


def test_scenes_of_a_story_are_those_of_the_page():
    events = [(25, "birth"), (35, "crash"), (65, "crash"), (161, "extinct"), (179, "extinct")]
    entries = [{"tick": tick, "kind": kind, "text": kind, "cause": "Why"} for tick, kind in events]
    scenes = film.scenes_of(entries, 0, 699)
    assert [scene[:2] for scene in scenes] == [  # as in test_page_why.py
        *((0, 10), (10, 30), (30, 45)),
        *((45, 75), (131, 170), (170, 189), (689, 699)),
    ]
    assert [scene.caption for scene in scenes[:2]] == ["", "Tick 25. birth. Why"]
    many = [{"tick": 10 * k, "kind": "crash", "text": "", "cause": ""} for k in range(1, 20)]
    scenes = film.scenes_of([*many, {"tick": 200, "kind": "extinct", "text": "", "cause": ""}], 0, 300)
    assert len(scenes) == 12
    ticks = film.frames_of(scenes, 30)
    assert len(ticks) == 60 * 30
    assert ticks == sorted(ticks)
    assert (ticks[0], ticks[-1]) == (0, 300)


def test_a_film_of_the_story_has_captions(folder, tmp_path):
    scenes = [film.Scene(0, 5, ""), film.Scene(5, 9, "Tick 7. Moss died out.")]
    painter = Painter(Replay(folder), (640, 360), scenes)
    plain = Painter(Replay(folder), (640, 360))
    assert (painter.paint(4) == plain.paint(4)).all()
    assert (painter.paint(6) != plain.paint(6)).any()
    assert painter.caption.get_text() == "Tick 7. Moss died out."
    done = _film(folder, tmp_path / "run.gif", "--story", "--size", "640x360", "--fps", 1, "-q")
    assert (done.exit_code, "events, in" in done.output) == (0, True), done.output
    refused = _film(folder, tmp_path / "no.gif", "--story", "--step", 3)
    assert (refused.exit_code, "does not apply to --story" in refused.output) == (2, True)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--to", 99], "was not recorded; expected: 0 to 19"),
        (["--from", 9, "--to", 3], "is before --from 9"),
        (["--fps", 0], "expected: 1 to 240"),
        (["--size", "big"], "WIDTHxHEIGHT, each 320 to 7680"),
        (["--size", "99x999"], "each 320"),
    ],
)
def test_what_no_film_can_be_made_of_is_refused(folder, tmp_path, arguments, words):
    done = _film(folder, tmp_path / "run.gif", *arguments)
    assert (done.exit_code, "Traceback" in done.output) == (2, False)
    assert words in done.output


# --- pictures on the command line ---------------------------------------------------------------------------


def _picture(*arguments):
    return CliRunner().invoke(app, ["picture", *map(str, arguments)])


def test_a_picture_of_a_tick(folder, tmp_path):
    done = _picture(folder, tmp_path / "new" / "run.png", "--tick", 7, "--size", "800x451")
    assert done.exit_code == 0, done.output
    with Image.open(tmp_path / "new" / "run.png") as picture:
        assert picture.size == (800, 450)


def test_the_nerves_of_one_organism_at_a_tick(folder, tmp_path):
    uid = int(Replay(folder).recording.organisms(7, "ram").uid[0])
    done = _picture(folder, tmp_path / "ram.svg", "--tick", 7, "--organism", uid, "-q")
    assert done.exit_code == 0, done.output
    assert "Rerun from a checkpoint" in done.output
    drawn = (tmp_path / "ram.svg").read_text()
    assert drawn.startswith("<svg")
    assert "prefers-color-scheme:dark" in drawn


def test_who_has_no_nerves_then_is_refused(folder, tmp_path):
    recording = Replay(folder).recording
    moss = int(recording.organisms(3, "moss").uid[0])
    young = int(recording.births.between(5, 19, ("uid",))["uid"][-1])
    for arguments, words in (
        ((moss,), "is a moss, which has no nervous system"),
        ((10**9,), "no organism of this run has the uid"),
        ((young, "--tick", 0), ""),
    ):
        done = _picture(folder, tmp_path / "x.png", "--organism", *arguments)
        assert (done.exit_code, "Traceback" in done.output) == (2, False)
        assert words in done.output


@pytest.mark.parametrize(
    ("name", "words"), [("x.jpg", 'a file ending in .png; did you mean "x.png"'), ("", "cannot be written")]
)
def test_other_files_than_pictures_are_refused(folder, tmp_path, name, words):
    done = _picture(folder, tmp_path / name)
    assert done.exit_code == 2
    assert words in done.output


def test_a_folder_without_a_run_is_refused(tmp_path):
    for command in (_picture, _film):
        done = command(tmp_path)
        assert done.exit_code == 2
        assert "has no manifest.json" in done.output
