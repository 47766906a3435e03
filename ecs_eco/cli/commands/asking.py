"""Commands about worlds, this machine and these pages: list, check, doctor, docs."""

from typing import Annotated

import typer

from ecs_eco.cli.options import Quiet, Set, Trust
from ecs_eco.cli.terminal import exits, say
from ecs_eco.cli.trust import allow


def list_() -> None:
    """List worlds, sensors, components and systems."""
    from ecs_eco.cli.listing import listing

    say(listing())


@exits
def check(
    world: Annotated[
        str | None,
        typer.Argument(
            metavar="WORLD", show_default=False, help="Name of a shipped world (see `list`), or a TOML file."
        ),
    ] = None,
    set_: Set = None,
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON schema of world files instead, for editors.")
    ] = False,
    trust: Trust = False,
) -> None:
    """Check a world file and print a summary."""
    allow(trust, world, set_)
    from ecs_eco.cli.summary import check_world, tell_schema

    tell_schema() if schema else check_world(world, set_ or [])


@exits
def doctor(
    test: Annotated[
        bool, typer.Option("--test/--no-test", help="Run the self-test, which takes up to a minute.")
    ] = True,
    quiet: Quiet = False,
) -> None:
    """Print what results depend on here, and whether they agree with the release: exit code 1 if not."""
    from ecs_eco.cli.doctor import examine_machine

    examine_machine(test, quiet)


@exits
def docs(
    page: Annotated[
        str, typer.Argument(metavar="PAGE", help="A page, such as running, or tutorials.")
    ] = "index",
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open a browser, or only print where the page is.")
    ] = True,
) -> None:
    """Open the documentation, from the copy on this machine."""
    from ecs_eco.cli.docs import open_docs

    open_docs(page, browser)
