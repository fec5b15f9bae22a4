"""The computing time and memory that a computation may use: counted before it begins, measured while it runs."""

from __future__ import annotations

import math
import threading
import time as clocks
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import Final

from electrovib.core.allowance import megabytes
from electrovib.core.amounts import _MEMORY, _MORE, _bytes, _positive, _seconds, duration
from electrovib.core.errors import InputError

_NOBODY_WAITS: Final = 7 * 86400.0
_NOBODY_HAS: Final = 1e12
_NUMBER: Final = 3e-8
"""Computing time of a number, about [s]: by it counts are refused before anything is measured."""
SHORTER: Final = "choose a shorter time.duration, a slower drive or one with fewer corners"
"""Remedy for a run with too many steps."""
_LAP: Final = 1.0
"""Computing time after which the speed of repeated parts is measured again, at most [s]."""
_SOME: Final = 1e-3
"""Share of the work that counts as done where none is."""
_LAPS: Final = 50
"""Least number of such times in a budget."""


class BudgetError(InputError):
    """A computation that would exceed the allowed computing time or memory."""


@dataclass(frozen=True)
class Budget:
    """The computing time [s], on one core of a common computer, and the memory [bytes] that one computation may use."""

    time: float = 600.0
    memory: float = 4e9


@dataclass(frozen=True, kw_only=True)
class Work:
    """One part of a computation.

    `what` says what is computed, with its count (``"1e+08 output times"``), and `remedy` what reduces it, as
    an instruction to the user (``"ask for fewer time.samples"``). `time` [s]; `memory` [bytes] is what is
    held at once.
    """

    what: str
    time: float
    memory: float
    remedy: str

    @classmethod
    def counted(cls, what: str, numbers: float, *, remedy: str, held: float | None = None) -> Work:
        """Return the work of so many numbers, of which so many are held at once, by default all."""
        memory = 8.0 * (numbers if held is None else held)
        return cls(what=what, time=_NUMBER * numbers, memory=memory, remedy=remedy)


_DEFAULT: Final = Budget()
_ALLOWED: ContextVar[Budget] = ContextVar("allowed", default=_DEFAULT)
_LISTENER: ContextVar[Callable[[float], None] | None] = ContextVar("listener", default=None)
_HERE: Final = threading.local()
"""In each thread, its outermost computation as `scope`."""


def allowed() -> Budget:
    """Return the budget that holds in this thread at this point."""
    return _ALLOWED.get()


@contextmanager
def budget(*, time: float | str | None = None, memory: float | str | None = None) -> Iterator[Budget]:
    """Set the computing time and memory that computations may use; the default is 10 minutes and 4 GB.

    Parameters
    ----------
    time : float or str, optional
        Computing time on one core [s], or a text such as ``"2 h"``; unchanged if absent.
    memory : float or str, optional
        Memory [bytes], or a text such as ``"16 GB"``; unchanged if absent.

    Yields
    ------
    Budget
        The budget that holds within the block, in this thread.

    Raises
    ------
    InputError
        If a value is not above 0, or is neither a number nor a text of that kind.

    Notes
    -----
    What is counted beforehand is refused before a computation begins: output times, corners of the drive, numbers to be
    held. The computing time of everything else is measured: time stepping ends at the budget, and sweeps, studies,
    sensitivities and designs once their first cases show that all would exceed it.
    """
    chosen = _ALLOWED.get()
    if time is not None:
        chosen = replace(chosen, time=_positive("time", time, _seconds))
    if memory is not None:
        chosen = replace(chosen, memory=_positive("memory", memory, _bytes))
    token, scope = _ALLOWED.set(chosen), _scope()
    _HERE.scope = None
    try:
        yield chosen
    finally:
        _ALLOWED.reset(token)
        _HERE.scope = scope


clock: Callable[[], float] = clocks.thread_time
"""Computing time of this thread [s]."""


@contextmanager
def measured() -> Iterator[None]:
    """Limit the block as one computation: meters within it measure from its beginning, or from that of one around it."""
    if _scope() is not None:
        yield
        return
    _HERE.scope = _Scope(clock())
    try:
        yield
    finally:
        _HERE.scope = None


@dataclass
class _Scope:
    """A computation: the time at which it began [s], and the meter of its cases."""

    began: float
    cases: Meter | None = None


def _scope() -> _Scope | None:
    return getattr(_HERE, "scope", None)


def read_budget(text: str) -> dict[str, float]:
    """Read ``time`` [s] and ``memory`` [bytes], or one of them, from a text such as ``"2 h, 16 GB"``."""
    found: dict[str, float] = {}
    for part in text.split(","):
        name, read = ("memory", _bytes) if _MEMORY.fullmatch(part) else ("time", _seconds)
        if not any(sign.isalpha() for sign in part.lower().replace("e", "")) and any(map(str.isdigit, part)):
            number = part.strip()
            raise InputError(
                f"--budget = '{text}': {number} of what? Give its unit: '{number} min' or '{number} GB'"
            )
        if name in found:
            raise InputError(f"--budget = '{text}': names {name} twice")
        found[name] = _positive("--budget", part.strip(), read)
    return found


def refuse_beyond(works: Sequence[Work], *, what: str = "this run") -> None:
    """Refuse a computation whose estimate exceeds the budget; times of `works` add up, and the largest memory counts."""
    limit = allowed()
    time, memory = sum(work.time for work in works), max((work.memory for work in works), default=0.0)
    if time > limit.time or memory > limit.memory:
        raise _too_much(works, what)


def _too_much(works: Sequence[Work], what: str) -> BudgetError:
    limit = allowed()
    time, memory = sum(work.time for work in works), max(work.memory for work in works)
    late, large = time > limit.time, memory > limit.memory
    over = max(works, key=lambda work: max(late * work.time / limit.time, large * work.memory / limit.memory))
    return BudgetError(
        f"{what} would take about {duration(time)} and {megabytes(memory)}, for {over.what}; allowed are"
        f" {duration(limit.time)} and {megabytes(limit.memory)}. {_advice(over.remedy, time, memory)}"
    )


def _advice(remedy: str, time: float, memory: float) -> str:
    """Write what reduces a computation and, below a week and 1 TB, how to allow it as it is."""
    advice = remedy[:1].upper() + remedy[1:]
    if time > _NOBODY_WAITS or memory > _NOBODY_HAS:
        return advice
    limit = allowed()
    asked = {}
    if _MORE * time > limit.time:
        asked["time"] = duration(_MORE * time)
    if _MORE * memory > limit.memory:
        asked["memory"] = megabytes(_MORE * memory)
    option, arguments = (
        ", ".join(asked.values()),
        ", ".join(f"{name}='{text}'" for name, text in asked.items()),
    )
    return f"{advice}, or allow more: electrovib --budget '{option}' ..., or electrovib.budget({arguments}) in Python"


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
        self._listener = _LISTENER.get() if seconds is None else None
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
        return _too_much([work], self.what)


@contextmanager
def listening(listener: Callable[[float], None] | None) -> Iterator[None]:
    """Report the progress of time stepping in the block to a listener, as the fraction that is done, 0 to 1."""
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)
