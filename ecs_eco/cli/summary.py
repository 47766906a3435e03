"""The command check, and the summary of a world that it prints."""

import json
from typing import Annotated, Any

import typer

from ecs_eco.cli.options import Set, Trust
from ecs_eco.cli.terminal import exits, refuse, say
from ecs_eco.cli.trust import allow
from ecs_eco.config import WorldConfig, load
from ecs_eco.config.checks.genome import components_of
from ecs_eco.config.json_schema import json_schema
from ecs_eco.config.memory import require_memory
from ecs_eco.config.notes import notes
from ecs_eco.config.notes_on_ticks import notes_on_ticks
from ecs_eco.config.shapes import shapes_of_networks
from ecs_eco.config.traits import traits_of
from ecs_eco.genomes import layout_of


@exits
def check(
    world: Annotated[
        str | None,
        typer.Argument(
            metavar="WORLD", show_default=False, help="Name of a shipped world (see `list`) or a TOML file."
        ),
    ] = None,
    set_: Set = None,
    schema: Annotated[
        bool,
        typer.Option(
            "--schema",
            help="Instead, print the JSON schema of world files for editors; with WORLD, it includes the world's "
            "custom features.",
        ),
    ] = False,
    trust: Trust = False,
) -> None:
    """Check a world file and print a summary."""
    allow(trust, world, set_)
    if schema:
        model = () if world is None else (type(load(world, set_ or [])),)
        return say(json.dumps(json_schema(*model), indent=1, ensure_ascii=False))
    if world is None:
        refuse("WORLD", "is missing", "", "a world, or --schema")

    config = load(world, set_ or [])
    require_memory(config)
    say(summary(config))


def _layout(config: WorldConfig, name: str) -> Any:
    species = config.species[name]
    assert species.genome is not None
    own = components_of(config, species)
    if own is None:
        return "genome: its genes may refer to fields in code that is not loaded"
    traits = traits_of(species, config.dims, own)
    shapes = shapes_of_networks(config, name)
    if any(
        gene.trait in traits and traits[gene.trait].kind == "weights" and gene.trait not in shapes
        for gene in species.genome.genes
    ):
        return "genome: a gene codes for the weights of a network whose code is not loaded"
    return layout_of(species.genome, traits, shapes)


def summary(config: WorldConfig) -> str:
    """Return the name, the space, each species' channels, actions and genes, and the configuration's hash."""
    space = " × ".join(f"{s:g}" for s in config.space.size)
    lines = [
        f"{config.name}: {config.title}".rstrip(": "),
        f"  {space} m, {config.space.edges}, {config.dt:g} s per tick",
    ]
    for name, species in config.species.items():
        lines.append(f"  {name}: {species.count}" + ("" if species.reproduction else ", does not reproduce"))
        if (way := species.reproduction) is not None and way.kind == "spread":
            sites = " × ".join(str(max(1, round(length / way.spacing))) for length in config.space.size[:2])
            shared = (
                sum(
                    s.reproduction is not None and s.reproduction.kind == "spread"
                    for s in config.species.values()
                )
                > 1
            )
            lines.append(
                f"    spreads over {sites} sites"
                + ("; other plants can occupy the same ground" if shared else "")
            )
        channels = species.channels(config.dims)
        if channels:
            lines.append(f"    senses {', '.join(channels)}")
        if species.actions:
            lines.append(f"    does {', '.join('.'.join(pair) for pair in species.action_list())}")
        if species.genome is not None:
            lines += [f"    {line}" for line in str(_layout(config, name)).splitlines()]
    lines += [
        f"  {name}: {kind.count or len(kind.at) + len(kind.between)}" for name, kind in config.objects.items()
    ]
    if config.reporters:
        lines.append(f"  measures {', '.join(config.reporters)}")
    if config.record:
        lines.append(f"  records {', '.join(config.record)} of organisms")
    for name, span in config.search.ranges.items():
        lines.append(f"  search varies {name}: {span.search[0]:g} to {span.search[1]:g}")
    lines += [f"  note: {note}" for note in (*notes(config), *notes_on_ticks(config))]
    return "\n".join([*lines, f"  configuration {config.config_hash[:16]}, no problems", *_code(config)])


def _code(config: WorldConfig) -> list[str]:
    """Return lines that list the world's code, and whether it was loaded."""
    if not config.code:
        return []
    word = "allowed to run" if config._code.allowed else "NOT loaded; use --trust to check its names"
    return [f"  code, {word}:", *(f"    {source}" for source in config._code.sources)]
