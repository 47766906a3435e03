"""Attacks through a command's working folder; the modules that `check` imports; and controls: payloads that
must leave their mark."""

from __future__ import annotations

import os
import pickle  # noqa: TID251  # a control
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ecs_eco.config.edit import as_toml
from ecs_eco.engine.processes import python
from studies.common.malicious.ground import Attack, Ground, cli
from studies.common.malicious.templates import world_of

LISTING = """
import sys
from typer.testing import CliRunner
from ecs_eco.cli.app import app
done = CliRunner().invoke(app, ["check", sys.argv[1]])
assert done.exit_code == 0, done.output
print(" ".join(sorted(sys.modules)))
"""
SHADOWS = (
    "json.py",
    "numpy.py",
    "sitecustomize.py",
    "usercustomize.py",
    "typing_extensions.py",
    "ecs_eco.py",
    "conftest.py",
)
COMMAND = Path(sys.executable).with_name("ecs-eco")
NAMES = sorted(
    {
        *sys.stdlib_module_names,
        "numpy",
        "numba",
        "torch",
        "pyarrow",
        "pydantic",
        "scipy",
        "typer",
        "rich",
        "esper",
        "deap",
        "safetensors",
        "optuna",
        "matplotlib",
        "ray",
        "uvicorn",
        "starlette",
        "rasterio",
        "pyogrio",
        "sitecustomize",
        "components",
        "systems",
        "ecs_eco",
    }
)
"""Names of modules that would shadow Python's standard library, other libraries, or this package."""


def folders(ground: Ground) -> Iterator[Attack]:
    """Return folders with matplotlib and numba settings and shadowing modules, for commands to run in."""
    place = ground.beside()
    for name in SHADOWS:
        (place / name).write_text(ground.text, encoding="utf-8")
    (place / "matplotlibrc").write_text(
        "text.usetex: True\nbackend: module://evil\nsavefig.format: pgf\nmathtext.fontset: stix\n",
        encoding="utf-8",
    )
    (place / ".numba_config.yaml").write_text(f"cache_dir: {place}\ndisable_jit: 1\n", encoding="utf-8")
    (place / "world.toml").write_text(as_toml(world_of("systems.*", code=["evil.py"])), encoding="utf-8")
    tools = _tools(ground)
    for words in (
        ["check", "world.toml"],
        ["report", str(ground.run), "--out", "out"],
        ["picture", str(ground.run), "tick.png"],
        ["draw", "predator-prey", "--out", "drawn.png"],
        ["why", str(ground.run), "--out", "why"],
    ):
        environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"}

        def attempt(words: list[str] = words, environment: dict[str, str] = environment) -> str:
            done = subprocess.run(
                [str(COMMAND), *words], cwd=place, env=environment, capture_output=True, text=True
            )
            if done.returncode not in (0, 2) or "Traceback" in done.stderr:
                raise RuntimeError(done.stderr[-600:])
            return done.stderr if done.returncode else ""

        yield Attack(f"a folder in which `ecs-eco {words[0]}` runs", ["world.toml"], [(words[0], attempt)])


def modules(ground: Ground) -> Iterator[Attack]:
    """Return folders with shadowing modules, for commands that start processes."""
    place = ground.new()
    place.mkdir()
    for name in NAMES:
        (place / f"{name}.py").write_text(f"open({str(ground.marks / name)!r}, 'w')\n", encoding="utf-8")
    islands = {
        "archipelago": {"migration_interval": 1, "islands": 2, "migration_probability": {"snail": 0.5}}
    }
    for name, text in (
        ("world", as_toml(ground.garden)),
        ("islands", as_toml(ground.garden | islands)),
        ("plan", 'world = "world.toml"\nticks = 2\nworld_seeds = 2\n'),
    ):
        (place / f"{name}.toml").write_text(text, encoding="utf-8")
    two, script = ["--workers", "2", "-q"], [str(COMMAND)]
    search = [
        "--trials",
        "2",
        "--ticks",
        "2",
        "--range",
        "species.snail.body.radius=0.05:0.2",
        "--world-seeds",
        "2",
        "--confirm-world-seeds",
        "1",
        "--confirm-training-seeds",
        "1",
    ]
    compare = ["compare", "world.toml", "--treatment", "no-mutation", "--seeds", "2", "--ticks", "2"]
    commands = [
        [*script, *compare, *two],
        [*script, "sweep", "plan.toml", *two],
        [*script, "search", "world.toml", *search, *two],
        [*script, "run", "islands.toml", "--ticks", "3", *two],
        python("from ecs_eco.cli import main; main()", "check", "world.toml"),
        python("from ecs_eco.view.islands import serve; serve(sys.argv[1])", str(ground.run)),
        [sys.executable, "-m", "ecs_eco", *compare, *two],
    ]
    if find_spec("ray") is not None:
        commands.insert(4, [*script, "sweep", "plan.toml", "--on", "ray", *two])
    for i, command in enumerate(commands):
        if command[1:3] == [
            "-m",
            "ecs_eco",
        ]:  # Python looks for this name before it runs any of the package's code
            (place / "ecs_eco.py").unlink()
        words = [*command, "--out", f"out-{i}"] if "-q" in command else command

        def attempt(words: list[str] = words) -> str:
            done = subprocess.run(
                words,
                cwd=place,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                env={**os.environ, "RAY_ADDRESS": "local"},
            )  # no module from another project
            if done.returncode:
                raise RuntimeError(done.stderr[-600:])
            return ""

        label = " ".join(word for word in words[1:] if len(word) < 20)[:60]
        yield Attack(f"{len(NAMES)} modules in the folder of: {label}", [], [(label, attempt)])


def _tools(ground: Ground) -> Path:
    """Return a folder of programs that leave a mark when called to typeset a figure."""
    tools = ground.new()
    tools.mkdir()
    for name in ("latex", "pdflatex", "xelatex", "dvipng", "kpsewhich", "gs"):
        (tools / name).write_text(f"#!/bin/sh\n{ground.shell}\nexit 1\n", encoding="utf-8")
        (tools / name).chmod(0o755)
    return tools


def controls(ground: Ground) -> list[dict[str, Any]]:
    """Return whether payloads leave their mark where they should run; without this control, the absence of
    marks proves nothing."""
    path = ground.beside() / "world.toml"
    path.write_text(as_toml(world_of("systems.*", code=["evil.py"])), encoding="utf-8")
    out = []

    def tried(label: str, work: Any) -> None:
        output = work()
        out.append({"label": label, "marked": bool(ground.marked()), "said": str(output)[:200]})

    tried(
        "a world whose code was trusted",
        cli("run", path, "--ticks", "2", "-q", "--no-report", "--out", path.parent / "out", "--trust"),
    )
    tried("a pickle that is unpickled", lambda: pickle.loads(ground.blobs["a pickle"]))  # noqa: S301
    tried("a shell command that is run", lambda: os.system(ground.shell))
    tried("the module that is imported", lambda: __import__("evil").__name__)
    tried(
        "a program for typesetting that is started",
        lambda: subprocess.run([_tools(ground) / "latex"], check=False).returncode,
    )
    for module in [m for m in sys.modules if m == "evil" or m.startswith("_ecs_eco_code_")]:
        del sys.modules[module]
    return out


def imported(ground: Ground) -> dict[str, Any]:
    """Return modules loaded by a process that checked a world with code: modules not loaded for a harmless
    world, and modules of unknown origin."""
    from importlib.metadata import packages_distributions

    modules = {}
    for name, data in (
        ("harmless", ground.garden),
        ("with code", world_of("systems.*", code=["evil.py"])),
        (
            "with a module",
            world_of("systems.*", code=["evilpackage.inside"]) | {"systems": ["evilpackage.inside:Wait"]},
        ),
    ):
        path = ground.beside() / "world.toml"
        path.write_text(as_toml(data), encoding="utf-8")
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ground.home / "path"), *_own_path()])}
        done = subprocess.run(
            [sys.executable, "-c", LISTING, str(path)],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
            cwd=path.parent,
        )
        modules[name] = set(done.stdout.split())
    known = {*sys.stdlib_module_names, *packages_distributions(), "ecs_eco", "__main__"}
    tops = {m.partition(".")[0] for m in modules["with code"]}
    return {
        "modules": len(modules["with code"]),
        "beyond a harmless world": sorted(
            (modules["with code"] | modules["with a module"]) - modules["harmless"]
        ),
        "packages": sorted(tops - set(sys.stdlib_module_names)),
        "in no installed package": sorted(
            t for t in tops - known if not t.startswith(("__editable__", "_sysconfigdata"))
        ),
    }


def _own_path() -> list[str]:
    return [p for p in os.environ.get("PYTHONPATH", "").split(os.pathsep) if p]
