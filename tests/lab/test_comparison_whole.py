"""A comparison from Python, on an executor of one's own."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest

from ecs_eco.engine.errors import ForeignFile
from ecs_eco.lab.comparison import compare
from ecs_eco.record.seal import read_manifest

WORLD = """\
format = 1
name = "fell"
ticks = 20
[space]
size = [20.0, 20.0]
[species.mite]
count = 4
body = { radius = 0.1 }
metabolism = { energy = 0.5, energy_max = 1.0, basal = 0.02 }
lethal = [{ property = "energy", min = 0.0, low = "starved" }]
"""
COLD = "species.mite.metabolism.basal=0.05"


@pytest.fixture
def world(tmp_path: Path) -> str:
    path = tmp_path / "fell.toml"
    path.write_text(WORLD, encoding="utf-8")
    return str(path)


def digests(folder: Path) -> dict[str, str]:
    return {
        str(path.parent.relative_to(folder)): read_manifest(path.parent)["digest"]
        for path in folder.glob("*/*/manifest.json")
    }


@pytest.mark.slow
def test_an_executor_of_ones_own_gives_the_same_and_is_left_running(world: str, tmp_path: Path) -> None:
    compare(world, [COLD], out=tmp_path / "here", seeds=2, workers=1)
    with ProcessPoolExecutor(1, get_context("spawn")) as own:
        result = compare(world, [COLD], out=tmp_path / "there", seeds=2, executor=own)
        assert own.submit(int, "3").result() == 3
    assert list(result["arms"]) == ["world", "species.mite.metabolism.basal-0.05"]
    assert len(digests(tmp_path / "here")) == 4
    assert digests(tmp_path / "here") == digests(tmp_path / "there")


@pytest.mark.slow
def test_it_goes_on_where_it_was_and_another_one_is_refused(world: str, tmp_path: Path) -> None:
    progress: list[tuple[int, int]] = []
    compare(world, [COLD], out=tmp_path / "out", seeds=1, workers=1)
    compare(world, [COLD], out=tmp_path / "out", seeds=2, workers=1, progress=lambda *n: progress.append(n))
    assert progress[-1] == (2, 2)
    with pytest.raises(ForeignFile, match=r"another comparison: ticks differs \(ticks: 20 then, 30 now\)"):
        compare(world, [COLD], out=tmp_path / "out", seeds=2, ticks=30)
