"""World files that strangers wrote: read within bounds, or refused in words that name the place."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from ecs_eco.config import load
from ecs_eco.config.reading import DEEPEST, MOST_BYTES
from ecs_eco.engine.errors import MOST, ConfigError, nearest
from ecs_eco.engine.files import read_bytes

HEAD = 'format = 1\nname = "w"\nspace = { size = [9.0, 9.0] }\n'
SPECIES = "[species.a]\ncount = 1\nbody = { radius = 0.1 }\n"


def refusal(tmp_path: Path, text: str | bytes) -> str:
    """What is said of a world file that is refused."""
    file = tmp_path / "meadow.toml"
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    with pytest.raises(ConfigError) as error:
        load(file)
    assert len(str(error.value)) < 10_000
    return str(error.value)


@pytest.mark.parametrize(
    ("line", "what", "column"),
    [
        ("ticks = " + "9" * 4400, "a whole number has too many digits", 9),
        ("ticks = " + "[" * 50_000 + "]" * 50_000, "tables or lists are nested too deeply", 9),
        ("ticks = " + "{a=" * 400 + "1" + "}" * 400, "tables or lists are nested too deeply", 9),
        (".".join("a" * 5000) + " = 1", f"a dotted key has more than {DEEPEST} parts", 1),
        ("[" + ".".join("a" * 5000) + "]", f"a dotted key has more than {DEEPEST} parts", 1),
    ],
    ids=["digits", "lists", "tables", "key", "header"],
)
def test_toml_that_python_cannot_read_is_refused_with_its_line(
    line: str, what: str, column: int, tmp_path: Path
) -> None:
    message = refusal(tmp_path, HEAD + line + "\n" + SPECIES)
    assert f"meadow.toml, line 4, column {column}\n  not TOML: {what}" in message


@pytest.mark.parametrize("text", ["[" * 60 + "]" * 60, "[" * 300 + "]" * 300], ids=["60", "300"])
def test_deep_nesting_is_refused_before_models_look_at_it(text: str, tmp_path: Path) -> None:
    message = refusal(tmp_path, f"{HEAD}ticks = {text}\n{SPECIES}")
    assert "meadow.toml, line 4: ticks" in message
    assert f"at most {DEEPEST}" in message


def test_a_dict_that_holds_itself_is_refused() -> None:
    endless: dict[str, object] = {"format": 1}
    endless["species"] = endless
    with pytest.raises(ConfigError, match="nested too deeply"):
        load(endless)


def test_numbers_of_many_digits_are_told_in_words() -> None:
    world = {"format": 1, "name": "w", "space": {"size": [9.0, 9.0]}, "ticks": 10**5000, "species": {}}
    with pytest.raises(ConfigError, match="a whole number of about 5001 digits"):
        load(world)


def test_very_many_unknown_keys_are_answered_soon(tmp_path: Path) -> None:
    begin = time.process_time()
    message = refusal(tmp_path, HEAD + SPECIES + "".join(f"k{i}=1\n" for i in range(40_000)))
    assert time.process_time() - begin < 20  # minutes, where each of them is likened to all keys
    assert f"meadow.toml: more than {MOST} problems" in message
    assert "… and more than 185 more" in message


@pytest.mark.slow
def test_very_many_unknown_names_are_answered_soon(tmp_path: Path) -> None:
    foods = "".join('{eats="b"},' for _ in range(30_000))
    assert f"more than {MOST} problems" in refusal(tmp_path, HEAD + SPECIES + f"diet = [{foods}]\n")


def test_very_long_names_are_not_likened_to_others() -> None:
    assert nearest("deer" * 100_000, ["deer"]) == ""
    assert nearest("dear", ["deer"]) == "deer"


def test_a_file_that_is_too_long_is_refused(tmp_path: Path) -> None:
    assert f"is longer than {MOST_BYTES:,} bytes" in refusal(tmp_path, HEAD + "#" * MOST_BYTES)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-8"])
def test_marks_and_line_ends_of_other_editors_are_read(encoding: str, tmp_path: Path) -> None:
    file = tmp_path / "meadow.toml"
    file.write_bytes((HEAD + SPECIES).replace("\n", "\r\n").encode(encoding))
    assert load(file).name == "w"


def test_utf_16_is_refused(tmp_path: Path) -> None:
    assert "a TOML file in UTF-8" in refusal(tmp_path, (HEAD + SPECIES).encode("utf-16"))


def test_pipes_devices_and_folders_are_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/zero"), tmp_path):
        with pytest.raises(OSError, match=r"is not a regular file|is a folder"):
            read_bytes(path, 1000)


def test_what_says_that_it_is_empty_and_is_not_is_cut(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="is longer than 10 bytes"):
        read_bytes(Path("/proc/self/status"), 10)


@pytest.mark.parametrize("place", ["9" * 5000, "²", "٣" * 5000])
def test_places_in_lists_are_numbers_of_few_digits(place: str) -> None:
    world = {
        "format": 1,
        "name": "w",
        "space": {"size": [9.0, 9.0]},
        "species": {"a": {"count": 1, "body": {"radius": 0.1}, "diet": []}},
    }
    with pytest.raises(ConfigError, match="no entry"):
        load(world, {f"species.a.diet.{place}": 1})
    with pytest.raises(ConfigError, match=r"training\.ramp"):
        load(world | {"training": {"ramp": [{"key": f"species.{place}", "values": [0.0, 1.0]}]}})
