"""The page's server, which notes how long each update takes: ``python -m benchmarks.explorer_server FILE``."""

import asyncio
import atexit
import json
import sys
from pathlib import Path
from time import perf_counter

from electrovib.apps.explorer.server import explore
from electrovib.apps.explorer.session import Session
from electrovib.apps.explorer.state import PageState

times: dict[str, list[float]] = {"whole": [], "own": []}
"""Times of updates [s]: from a state that is asked for to its plots, and the part of it in which it has its turn."""
update = Session._update  # noqa: SLF001 - measured from outside: the page has no code for it


async def timed(self: Session, state: PageState) -> None:
    """Work on a state as the page does, from its simulation to the plots for the browser."""
    begin = perf_counter()
    _time_turns(self.workers.turn)
    await update(self, state)
    times["whole"].append(perf_counter() - begin)


def _time_turns(turn: asyncio.Lock) -> None:
    """Note from now on how long each update has its turn."""
    if "release" in vars(turn):
        return
    acquire, release, begun = turn.acquire, turn.release, [0.0]

    async def timed_acquire() -> bool:
        await acquire()
        begun[0] = perf_counter()
        return True

    def timed_release() -> None:
        times["own"].append(perf_counter() - begun[0])
        release()

    vars(turn).update(acquire=timed_acquire, release=timed_release)


if __name__ == "__main__":
    Session._update = timed  # noqa: SLF001 - as above
    atexit.register(lambda: Path(sys.argv[1]).write_text(json.dumps(times), encoding="utf-8"))
    explore(browser=False, say=lambda line: print(line, flush=True))
