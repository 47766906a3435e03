"""Files in which other programs would find something to run: pickles of all kinds, types of one's own,
and pages with markup."""

import copy
import pickle  # noqa: TID251  # to show that the payload would do something
import shutil
from collections.abc import Iterator

import pytest

from ecs_eco.analysis.report import write_report
from ecs_eco.analysis.why.page import write_why
from ecs_eco.engine.errors import CheckpointError, ConfigError, RecordingError
from ecs_eco.lab.searching import journal
from ecs_eco.learning import weights
from ecs_eco.record import checkpoint, seal
from ecs_eco.record.parquet import read_part
from studies.common.malicious.files import _pickled_type
from studies.common.malicious.ground import Ground, cli, ground

SCRIPT = "<script>document.title = 'mark'</script><img src=x onerror=alert(1)>"

BLOBS = [
    "a pickle",
    "an npy file of objects",
    "an npz file of objects",
    "a file of torch",
    "a Python file",
    "a script",
]


@pytest.fixture(scope="module")
def place() -> Iterator[Ground]:
    """A ground with payloads that leave marks."""
    with ground() as prepared:
        yield prepared


def test_the_payload_would_leave_a_mark(place: Ground) -> None:
    pickle.loads(place.blobs["a pickle"])  # noqa: S301
    assert place.marked() == ["shell"]


@pytest.mark.parametrize("what", BLOBS)
@pytest.mark.parametrize(
    ("read", "error"),
    [
        (weights.load, ValueError),
        (checkpoint.read, CheckpointError),
        (checkpoint.describe, CheckpointError),
        (read_part, RecordingError),
        (journal.read, ConfigError),
    ],
)
def test_nothing_is_unpickled(read, error, what: str, place: Ground) -> None:
    path = place.new()
    path.write_bytes(place.blobs[what] + b"\n")
    with pytest.raises(error):
        read(path)
    assert not place.marked()


def test_a_part_with_a_type_of_its_own_is_plain_numbers(place: Ground) -> None:
    path = place.copy_of_run() / "series" / "part-00000.parquet"
    numbers = read_part(path).column(0).to_pylist()
    path.write_bytes(_pickled_type(path, place.blobs["a pickle"]))
    assert read_part(path).column(0).to_pylist() == numbers
    assert not place.marked()


@pytest.mark.slow
def test_pages_of_runs_show_markup_as_text(place: Ground) -> None:
    run = place.copy_of_run()
    manifest = seal.read_manifest(run)
    manifest |= {
        "world": SCRIPT,
        "command": SCRIPT,
        "causes": [SCRIPT] * len(manifest["causes"]),
        "colors": {"snail": f"red'>{SCRIPT}"},
    }
    manifest |= {"versions": {"python": SCRIPT, SCRIPT: SCRIPT}, "policies": SCRIPT}
    manifest["config"] = copy.deepcopy(manifest["config"]) | {"title": SCRIPT, "name": SCRIPT}
    seal.write_manifest(run, manifest)
    write_report(run)
    write_why(run)
    for name in ("report.html", "why.html"):
        page = (run / name).read_text(encoding="utf-8")
        assert "<script" not in page
        assert "<img src=x" not in page
        assert "Content-Security-Policy" in page
    assert "&lt;script&gt;" in (run / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_pages_of_comparisons_and_searches_show_markup_as_text(place: Ground) -> None:
    from ecs_eco.config.edit import as_toml

    folder = place.new()
    folder.mkdir()
    (folder / "world.toml").write_text(as_toml(place.garden | {"title": SCRIPT}), encoding="utf-8")
    few = ("--ticks", "2", "--workers", "1", "-q")
    control = ("--treatment", "species.snail.body.radius=0.2", "--seeds", "2")
    assert cli("compare", folder / "world.toml", *control, "--out", folder / "compared", *few)() == ""
    words = (
        "--trials",
        "2",
        "--world-seeds",
        "1",
        "--range",
        "species.snail.body.radius=0.05:0.2",
        "--confirm-world-seeds",
        "1",
    )
    assert cli("search", folder / "world.toml", "--out", folder / "searched", *words, *few)() == ""
    for page in (folder / "compared" / "compare.html", folder / "searched" / "search.html"):
        text = page.read_text(encoding="utf-8")
        assert "<script" not in text
        assert "Content-Security-Policy" in text
    assert "&lt;script&gt;" in text  # the title of what was searched
    shutil.rmtree(folder)
