"""Record the shipped worlds, and save each recorded run as a page in one file.

    python tools/gallery.py DIR

`build_site.py` does so for the site, where the pictures of the gallery and of the home page start these pages.
"""

import argparse
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from ecs_eco.runs.run import run_to_folder  # noqa: E402
from ecs_eco.view.export import page  # noqa: E402
from ecs_eco.view.replay import Replay  # noqa: E402

TICKS = {
    "predator-prey": 600,
    "island": 600,  # slow
    "reflexes": 1000,
    "innate": 1000,
    "happiness": 600,  # almost nothing changes later
    "lamb": 1000,
    "diel-migration": 1000,
    "learning-krill": 1000,
}
"""World → length of its run [ticks]."""
LARGEST = 2_000_000  # [bytes] of a page; the wheel contains them all


def file_of(world: str) -> str:
    """Return the file name of a world's page."""
    return f"{world.replace('-', '_')}.html"


def save(world: str, folder: Path, most: int = LARGEST) -> Path:
    """Record a world, save the run as a page of at most `most` bytes in a folder, and return its path."""
    path = folder / file_of(world)
    with tempfile.TemporaryDirectory() as run:
        run_to_folder(world, seed=1, ticks=TICKS[world], out=run, report=False)
        path.write_text(page(Replay(run), most), encoding="utf-8")
    return path


def main() -> None:
    """Save the pages of all worlds."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("folder", type=Path, metavar="DIR")
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for world in TICKS:
        path = save(world, folder)
        print(f"{path}: {path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
