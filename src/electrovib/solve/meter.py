"""The computing time of work whose amount is not known before it is done: measured, foreseen, ended beyond the budget."""

from __future__ import annotations

import math
import threading
import time as clocks
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

from electrovib.core.budget import (
    LISTENER,
    Budget,
    BudgetError,
    Work,
    allowed,
    duration,
    refuse_beyond,
    too_much,
)

SHORTER: Final = "choose a shorter time.duration, a slower drive or one with fewer corners"
"""Remedy for a run with too many steps."""
_LAP: Final = 1.0
"""Computing time after which the speed of repeated parts is measured again, at most [s]."""
_SOME: Final = 1e-3
"""Share of the work that counts as done where none is."""
_LAPS: Final = 50
"""Least number of such times in a budget."""
_HERE: Final = threading.local()
"""In each thread, its outermost computation as `scope`."""

clock: Callable[[], float] = clocks.thread_time
"""Computing time of this thread [s]."""


@contextmanager
def measured() -> Iterator[None]:
    """Limit the block as one computation: meters within it measure from its beginning, or from that of one around it."""
    if _scope() is not None:
        yield
        return
    around = getattr(_HERE, "scope", None)
    _HERE.scope = _Scope(allowed(), clock())
    try:
        yield
    finally:
        _HERE.scope = around


@dataclass
class _Scope:
    """A computation: its budget, the time at which it began [s], and the meter of its cases."""

    limit: Budget
    began: float
    cases: Meter | None = None


def _scope() -> _Scope | None:
    """Return the computation to which this point belongs; a budget that was set meanwhile is that of another one."""
    found: _Scope | None = getattr(_HERE, "scope", None)
    return found if found is not None and found.limit is allowed() else None


class Meter:
    """Computing time of work whose amount is not known beforehand; it ends the work beyond the budget.

    The work goes from 0 to `end`, in s, or in cases where `of` names them; `what` and `remedy` are as in `Work`. Where
    the work recurs after each part of length `repeats`, the quickest part measured so far tells what the whole takes at
    least, and the work ends as soon as that exceeds the budget. `held` are the numbers held at once, which may grow;
    `seconds` returns the computing time so far [s].
    """

    def __init__(
        self,
        what: str,
        *,
        end: float,
        remedy: str = SHORTER,
        of: str = "",
        repeats: float = math.inf,
        held: float = 0.0,
        seconds: Callable[[], float] | None = None,
    ) -> None:
        self.what, self.end, self.remedy, self.of = what, end, remedy, of
        self.repeats, self.held, self._seconds = repeats, held, clock if seconds is None else seconds
        self._limit, self._started, self._lap, self._now = allowed(), self._seconds(), (0.0, 0.0), 0.0
        self._speeds, self._scope = list[float](), _scope()
        self._listener = LISTENER.get() if seconds is None else None
        is_within = self._scope is not None and seconds is None
        self._before = self._started - self._scope.began if self._scope and is_within else 0.0

    @classmethod
    def of_cases(
        cls,
        what: str,
        of: str,
        count: int,
        *,
        numbers: float,
        remedy: str,
        held: float | None = None,
        seconds: Callable[[], float] | None = None,
    ) -> Meter:
        """Return the meter of so many cases, each with so many numbers; refuse at once what is too much."""
        held = count * numbers if held is None else held
        refuse_beyond([Work.counted(of, count * numbers, held=held, remedy=remedy)], what=what)
        found = cls(what, of=of, end=count, repeats=1.0, held=held, remedy=remedy, seconds=seconds)
        if found._scope is not None:
            found._scope.cases = found
        return found

    def reporting(self, progress: Callable[[int, int], None] | None) -> Callable[[int, int], None]:
        """Return a function of the number of cases done and of all cases, which counts them and reports them further."""
        self._listener = self._listener if progress is None else None

        def report(done: int, total: int) -> None:
            if progress is not None:
                progress(done, total)
            self.count(done)

        return report

    def count(self, now: float) -> None:
        """Note that the work has reached `now`, and refuse to go on beyond the budget."""
        if self._listener is not None:
            self._listener(now / self.end if self.end else 1.0)
        took, self._now = self._seconds() - self._started, now
        if self._before + took > self._limit.time:
            of_all = self._scope.cases if self._scope else None
            raise (of_all or self).refusal(self._before + took if of_all else took)
        if 8.0 * self.held > self._limit.memory:
            raise self.refusal(took)
        last, since = self._lap
        if now - last < self.repeats or took - since < min(_LAP, self._limit.time / _LAPS):
            return
        self._lap = now, took
        self._speeds.append((now - last) / (took - since))
        least = took + (self.end - now) / max(self._speeds)
        if len(self._speeds) > 1 and self._before + least > self._limit.time:
            raise self.refusal(took, least)

    def refusal(self, took: float, whole: float | None = None) -> BudgetError:
        """Return the error for a work that took so long and takes so long as a whole, by default in proportion [s]."""
        share = self._now / self.end if self.end else 1.0
        whole = took / (share or _SOME) if whole is None else whole
        what = f"{self.of or f'{self.end:.6g} s'}, of which {100 * share:.3g} % took {duration(took)}"
        work = Work(what=what, time=self._before + whole, memory=8.0 * self.held, remedy=self.remedy)
        return too_much([work], self.what)
