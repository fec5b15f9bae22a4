"""The page's server, which notes how long each turn of a visitor takes: ``python -m benchmarks.explorer_server FILE``."""

import asyncio
import atexit
import json
import sys
from pathlib import Path
from time import perf_counter

from electrovib.apps.explorer.server import explore
from electrovib.apps.explorer.session import Session
from electrovib.apps.explorer.state import PageState

times: list[float] = []
"""Times for which a visitor has the turn [s]: for simulation and plots of an update, or for the key figures that follow."""
update = Session._update  # noqa: SLF001 - measured from outside: the page has no code for it


async def timed(self: Session, state: PageState) -> None:
    """Work on a state as the page does, from its simulation to the plots for the browser."""
    _time_turns(self.workers.turn)
    await update(self, state)


def _time_turns(turn: asyncio.Lock) -> None:
    """Note from now on how long each turn lasts."""
    if "release" in vars(turn):
        return
    acquire, release, begun = turn.acquire, turn.release, [0.0]

    async def timed_acquire() -> bool:
        await acquire()
        begun[0] = perf_counter()
        return True

    def timed_release() -> None:
        times.append(perf_counter() - begun[0])
        release()

    vars(turn).update(acquire=timed_acquire, release=timed_release)


if __name__ == "__main__":
    Session._update = timed  # noqa: SLF001 - as above
    atexit.register(lambda: Path(sys.argv[1]).write_text(json.dumps(times), encoding="utf-8"))
    explore(browser=False, say=lambda line: print(line, flush=True))
