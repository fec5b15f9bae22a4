"""``electrovib explore``."""

from __future__ import annotations

import sys

from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import say


@takes("""
scenario  [default: vezzoli_2014/fig6]
--port N        Port of the page. Default: the first that is free from 8080 on.
--host ADDRESS  Address at which the page is served; any other than 127.0.0.1 can be reached from other machines and needs the
    token of the printed address. [default: 127.0.0.1]
--no-browser    Do not open a browser.
--set
--models
""")
def command(given: Arguments) -> None:
    """Open a page in the browser: sliders, curves and limits.

    Change parameters and see their effect at once.
    """
    from electrovib.apps.explorer.server import explore

    given.read_set()
    serving = False

    def announce(line: str) -> None:
        nonlocal serving
        serving = True
        say(line)
        sys.stdout.flush()  # a log or a pipe would hold the address back until the page is closed

    browser = not given.pop("no_browser", False)
    try:
        explore(**given, browser=browser, say=announce)
    except KeyboardInterrupt:
        if not serving:
            raise
    say("The page is closed.")
