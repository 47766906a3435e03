"""`ecs-eco run | watch | resume | repeat | train | report | why | lineage | compare | search | sweep | draw
| picture | video | list | …`."""

from typing import Annotated

import typer

from ecs_eco.cli import (
    beginning,
    cache,
    comparing,
    docs,
    doctor,
    living,
    picture,
    summary,
    sweeping,
    telling,
    watch,
)
from ecs_eco.cli.terminal import REFUSED, complain, say
from ecs_eco.compiled.garbage import of_a_command

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # rich is loaded by the commands that draw with it
    help="Ecosystems whose animals sense, learn and evolve.",
)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import PackageNotFoundError, version

        try:
            say(f"ecs-eco {version('ecs-eco')}")
        except PackageNotFoundError:
            say("ecs-eco, not installed: the version is unknown")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_version, help="Print the version and exit.")
    ] = False,
    portable: Annotated[
        bool,
        typer.Option(
            "--portable",
            help="Give the same bytes on every x86-64 machine, more slowly; as ECS_ECO_PORTABLE=1 does.",
        ),
    ] = False,
) -> None:
    from ecs_eco.compiled.portable import PortableError, check, enable

    try:
        enable() if portable else check()
    except PortableError as error:
        complain(str(error))
        raise typer.Exit(REFUSED) from None


for _command in (
    living.run,
    watch.watch,
    living.repeat,
    living.resume,
    living.train,
    telling.report,
    telling.why,
    telling.lineage,
    telling.tracks,
    comparing.compare,
    comparing.search,
    picture.draw,
    picture.picture,
    picture.video,
):
    app.command()(_command)
app.add_typer(sweeping.sweep, name="sweep")
app.add_typer(cache.cache, name="cache")
app.command()(beginning.new)
app.add_typer(beginning.world, name="world")
app.command("list")(docs.list_)
app.command()(summary.check)
app.command()(doctor.doctor)
app.command()(docs.docs)


def main() -> None:
    """Entry point of the command `ecs-eco`."""
    with of_a_command():
        app(prog_name="ecs-eco")
