"""Run a random scenario in a process of its own, which may not take for ever."""

import json
import os
import resource
import signal
import time
import traceback
import warnings
from typing import Any, NamedTuple

from declared import scenario_table

import electrovib as ev
from electrovib.core.budget import BudgetError, budget
from electrovib.core.errors import ElectrovibError
from electrovib.core.model import read_model
from electrovib.scenario import Scenario

ALLOWED = {"time": 5.0, "memory": 1e9}
"""Budget of each scenario: seconds of computing and bytes."""
ENDLESS = 100.0
"""Seconds of computing time after which a scenario counts as endless, whatever else the machine does."""
WAITING = 900
"""Seconds by the clock after which a scenario that does not compute counts as endless too."""
HELD = 2e9
"""Bytes that a scenario may take in all, libraries included."""


class Outcome(NamedTuple):
    """What became of a scenario: ``ran``, ``unread``, ``refused``, ``budget``, ``stopped``, ``crashed`` or ``endless``.

    `unread` tables are refused when the scenario is read, `refused` ones when it is run, `budget` ones because they
    would take too much, before anything is computed; `stopped` ones ran into their budget.
    """

    seed: int
    what: str
    said: str
    seconds: float
    memory: float


def outcome_of(seed: int) -> Outcome:
    """Run the scenario of a seed."""
    begin = time.perf_counter()
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        signal.setitimer(signal.ITIMER_PROF, ENDLESS)
        signal.alarm(WAITING)
        with os.fdopen(writing, "w") as stream:
            json.dump(_attempt(seed), stream)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as stream:
        told = stream.read()
    status = os.waitpid(child, 0)[1]
    seconds = time.perf_counter() - begin
    if told:
        return Outcome(seed, *json.loads(told))
    what = "endless" if status in (signal.SIGALRM, signal.SIGPROF) else "crashed"
    return Outcome(seed, what, f"status {status}", seconds, 0.0)


def _attempt(seed: int) -> tuple[str, str, float, float]:
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
    warnings.simplefilter("error")
    begin = time.perf_counter()
    try:
        what, said = _run(scenario_table(seed))
    except BaseException:  # noqa: BLE001  # whatever comes is what this looks for
        what, said = "crashed", traceback.format_exc()[-2000:]
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0
    return what, said, time.perf_counter() - begin, memory


def _run(table: dict[str, Any]) -> tuple[str, str]:
    try:
        scenario = read_model(Scenario, table)
    except ElectrovibError as error:
        return "unread", str(error)
    try:
        with budget(**ALLOWED):
            ev.simulate(scenario)
    except BudgetError as error:
        return ("stopped" if ", of which " in str(error) else "budget"), str(error)
    except ElectrovibError as error:
        return "refused", str(error)
    return "ran", ""
