"""Build sdist and wheel, install the wheel into an empty environment, and run it from an empty folder.

    python tools/check_wheel.py

The wheel's dependencies are installed in the versions given in constraints.txt, from pip's cache if possible.
The script exits with 1 if a file is missing.
"""

import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
IN_WHEEL = (
    "ecs_eco/py.typed",
    "ecs_eco/_site/index.html",
    "ecs_eco/_site/_static/replays/predator_prey.html",
    "ecs_eco/view/static/index.html",
    "ecs_eco/view/static/vendor.js",
    "ecs_eco/worlds/predator_prey/deer.safetensors",
    "ecs_eco/templates/package/pyproject.toml.template",
    "licenses/LICENSE",
    "licenses/THIRD_PARTY.md",
)
LEFT = shutil.ignore_patterns("*.egg-info", "node_modules", "__pycache__", ".*_cache")
LEFT_AT_TOP = {".git", ".venv", "build", "dist", "runs", "my-run"}
LARGEST = 30_000_000  # [bytes] of the wheel
IN_SDIST = ("LICENSE", "THIRD_PARTY.md", "README.md", "pyproject.toml")


def run(*command: object, cwd: Path) -> None:
    """Print and run a command; exit if it fails."""
    print("$", *command, flush=True)
    done = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        text=True,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=os.environ | {"XDG_CONFIG_HOME": str(cwd)},
    )  # the folder with the list of trusted code
    print(done.stdout[-1000 if done.returncode == 0 else -10_000 :])
    if done.returncode:
        sys.exit(f"exit code {done.returncode}")


def left(folder: str, names: list[str]) -> set[str]:
    """Return the files in the checkout that do not belong in an sdist."""
    return set(LEFT(folder, names)) | (LEFT_AT_TOP & set(names) if Path(folder) == ROOT else set())


def build(folder: Path) -> Path:
    """Build sdist and wheel, check their contents, and return the wheel."""
    sources = folder.parent / "sources"
    shutil.copytree(ROOT, sources, symlinks=True, ignore=left)
    made = (
        "import sys; from setuptools import build_meta as b; to = sys.argv[1]; "  # it changes sys.argv
        "b.build_sdist(to); b.build_wheel(to)"
    )
    run(sys.executable, "-c", made, folder, cwd=sources)
    (wheel,), (sdist,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    with zipfile.ZipFile(wheel) as file:
        missing = [name for name in IN_WHEEL if not any(n.endswith(name) for n in file.namelist())]
    with tarfile.open(sdist) as file:
        missing += [name for name in IN_SDIST if not any(n.endswith(f"/{name}") for n in file.getnames())]
    if missing:
        sys.exit(f"missing from the wheel or sdist: {', '.join(missing)}")
    if (size := wheel.stat().st_size) > LARGEST:
        sys.exit(f"the wheel has {size / 1e6:.1f} MB, expected at most {LARGEST / 1e6:g} MB")
    return wheel


def main() -> None:
    """Build, install, run."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wheel = build(folder / "dist")
        venv.create(folder / "empty", with_pip=True)
        python, empty = folder / "empty" / "bin" / "python", folder / "here"
        empty.mkdir()
        run(python, "-m", "pip", "install", "-q", "-c", ROOT / "constraints.txt", wheel, "pytest", cwd=empty)
        command = folder / "empty" / "bin" / "ecs-eco"
        run(command, "--version", cwd=empty)
        run(command, "new", "my-world", cwd=empty)
        world = "my-world/my-world.toml"
        run(command, "run", world, "--trust", "--ticks", 50, "--out", "my-run", "-q", cwd=empty)
        run(command, "new", "my-ecology", "--package", cwd=empty)
        run(python, "-m", "pytest", "-q", "my-ecology", cwd=empty)
        where = "import ecs_eco, pathlib; print(pathlib.Path(ecs_eco.__file__).parent)"
        run(python, "-I", "-c", where, cwd=empty)


if __name__ == "__main__":
    main()
