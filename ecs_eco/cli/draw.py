"""Draws the nervous systems of a world's species."""

from __future__ import annotations

from pathlib import Path

from ecs_eco.cli.terminal import refuse, say
from ecs_eco.config import load

ENDINGS = (".png", ".svg", ".pdf")


def draw_world(world: str, overrides: list[str], species: str | None, out: Path | None) -> None:
    """Draw the nervous system of a species, or of all species that have one, into a file."""
    config = load(world, overrides)
    path = _checked(out or Path(f"{config.name}-{species or 'nerves'}.png"))
    from ecs_eco.analysis.nervous_figure import draw_nervous_systems, save  # matplotlib is slow to load

    figure = draw_nervous_systems(config, [species] if species else [])
    try:
        say(f"Drawn in {save(figure, path)}")
    except OSError as error:
        refuse("--out", f"cannot be written: {error.strerror or error}", str(path), "a file that can be made")


def _checked(path: Path) -> Path:
    if path.suffix.lower() not in ENDINGS:
        refuse(
            "--out",
            "no picture that can be written",
            str(path),
            f"a file ending in {', '.join(ENDINGS)}",
            f"{path.stem}.png",
        )
    if path.is_dir():
        refuse("--out", "is a folder", str(path), "a file")
    return path
