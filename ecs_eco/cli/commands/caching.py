"""Commands for compiled kernels: cache show | warm | clear."""

from typing import Annotated

import typer

from ecs_eco.cli.options import Quiet, Trust
from ecs_eco.cli.terminal import exits, whole
from ecs_eco.cli.trust import allow

cache = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    help="Compiled kernels, which are kept between runs: show, warm and clear.",
)


@cache.command()
@exits
def show() -> None:
    """Say where compiled kernels are kept, and how many."""
    from ecs_eco.cli.cache import show_cache

    show_cache()


@cache.command()
@exits
def warm(
    worlds: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="WORLD...",
            show_default=False,
            help="Names of shipped worlds, or TOML files. Default: all shipped worlds.",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(parser=whole(1, 1024), metavar="N", help="Processes. Default: as many as cores."),
    ] = None,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Compile the kernels of worlds beforehand, so that their first start is as quick as a later one."""
    for world in worlds or []:
        allow(trust, world, None)
    from ecs_eco.cli.cache import warm_cache

    warm_cache(worlds or [], workers, quiet)


@cache.command()
@exits
def clear(
    others: Annotated[bool, typer.Option("--others", help="Only those of other versions.")] = False,
) -> None:
    """Remove compiled kernels; they are compiled again when they are called."""
    from ecs_eco.cli.cache import clear_cache

    clear_cache(others)
