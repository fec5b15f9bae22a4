"""``electrovib explore``."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.terminal import say


def command(
    scenario: options.Scenario = "vezzoli_2014/fig6",
    port: Annotated[
        int | None, typer.Option(help="Port of the page. Default: the first that is free from 8080 on.")
    ] = None,
    host: Annotated[
        str,
        typer.Option(
            help="Address at which the page is served; any other than 127.0.0.1 can be reached from other machines and needs"
            " the token of the printed address."
        ),
    ] = "127.0.0.1",
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open a browser.")] = False,
    changes: options.Changes = None,
    models: options.Models = None,
) -> None:
    """Open a page in the browser: sliders, curves and limits.

    Change parameters and see their effect at once.
    """
    from electrovib.apps.changes import read_changes
    from electrovib.apps.explorer.server import explore

    serving = False

    def announce(line: str) -> None:
        nonlocal serving
        serving = True
        say(line)
        sys.stdout.flush()  # a log or a pipe would hold the address back until the page is closed

    try:
        explore(
            scenario,
            set=read_changes(changes or []),
            port=port,
            host=host,
            browser=not no_browser,
            say=announce,
        )
    except KeyboardInterrupt:
        if not serving:
            raise
    say("The page is closed.")
