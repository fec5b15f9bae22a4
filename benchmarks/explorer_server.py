"""The page's server, which notes how long each update takes: ``python -m benchmarks.explorer_server FILE``."""

import atexit
import json
import sys
from pathlib import Path
from time import perf_counter

from electrovib.apps.explorer.server import explore
from electrovib.apps.explorer.session import Session
from electrovib.apps.explorer.state import PageState

times: list[float] = []
update = Session._update  # noqa: SLF001 - measured from outside: the page has no code for it


async def timed(self: Session, state: PageState) -> None:
    """Work on a state as the page does, from its simulation to the plots for the browser."""
    begin = perf_counter()
    await update(self, state)
    times.append(perf_counter() - begin)


if __name__ == "__main__":
    Session._update = timed  # noqa: SLF001 - as above
    atexit.register(lambda: Path(sys.argv[1]).write_text(json.dumps(times), encoding="utf-8"))
    explore(browser=False, say=lambda line: print(line, flush=True))
