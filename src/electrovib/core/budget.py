"""How long a computation may take and how much memory: estimated before the work, and refused beyond what is allowed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import Final, NoReturn

from electrovib.core.allowance import megabytes
from electrovib.core.amounts import _MEMORY, _MORE, _bytes, _positive, _seconds, duration
from electrovib.core.errors import InputError

_NOBODY_WAITS: Final = 7 * 86400.0
_NOBODY_HAS: Final = 1e12


class BudgetError(InputError):
    """A computation that would take longer, or more memory, than is allowed."""


@dataclass(frozen=True)
class Budget:
    """What one computation may take.

    Parameters
    ----------
    time : float
        Estimated computing time on one core of a common computer [s].
    memory : float
        Bytes.
    """

    time: float = 600.0
    memory: float = 4e9


@dataclass(frozen=True, kw_only=True)
class Work:
    """A part of a computation, before it is done.

    Parameters
    ----------
    what : str
        What is computed, with its number: "1e+08 output times".
    time : float
        About how long it takes [s].
    memory : float
        About how much memory it holds at once [bytes].
    remedy : str
        What makes it less, as an order to the user: "ask for fewer time.samples".
    """

    what: str
    time: float
    memory: float
    remedy: str


_DEFAULT: Final = Budget()
_ALLOWED: ContextVar[Budget] = ContextVar("allowed", default=_DEFAULT)
_LISTENER: ContextVar[Callable[[float], None] | None] = ContextVar("listener", default=None)


def allowed() -> Budget:
    """Give what a computation may take here and now."""
    return _ALLOWED.get()


@contextmanager
def budget(*, time: float | str | None = None, memory: float | str | None = None) -> Iterator[Budget]:
    """Allow computations more time or memory, or less, than the 10 minutes and 4 GB of the default.

    Parameters
    ----------
    time : float or str, optional
        Computing time on one core [s], or a text such as ``"2 h"``; as before if absent.
    memory : float or str, optional
        Bytes, or a text such as ``"16 GB"``; as before if absent.

    Yields
    ------
    Budget
        What holds within the block, in this thread.

    Raises
    ------
    InputError
        If it is not above 0, or no such quantity.

    Notes
    -----
    The estimate counts output times, corners and cycles of the drive, and steps, each with the time that it takes on a
    common computer: the same scenario is refused or accepted on every machine.
    """
    chosen = _ALLOWED.get()
    if time is not None:
        chosen = replace(chosen, time=_positive("time", time, _seconds))
    if memory is not None:
        chosen = replace(chosen, memory=_positive("memory", memory, _bytes))
    token = _ALLOWED.set(chosen)
    try:
        yield chosen
    finally:
        _ALLOWED.reset(token)


def read_budget(text: str) -> dict[str, float]:
    """Read a budget as one text, a time, a memory or both.

    Parameters
    ----------
    text : str
        For instance ``"2 h, 16 GB"``.

    Returns
    -------
    dict of str to float
        ``time`` [s] and ``memory`` [bytes], for `budget`.

    Raises
    ------
    InputError
        If a part is neither.
    """
    found: dict[str, float] = {}
    for part in text.split(","):
        name, read = ("memory", _bytes) if _MEMORY.fullmatch(part) else ("time", _seconds)
        if name in found:
            raise InputError(f"--budget = '{text}': names {name} twice")
        found[name] = _positive("--budget", part.strip(), read)
    return found


def refuse_beyond(works: Sequence[Work], *, what: str = "this run") -> None:
    """Refuse a computation before it begins if it needs more than is allowed.

    Parameters
    ----------
    works : sequence of Work
        Its parts, one after the other: their times add up, and the largest memory counts.
    what : str
        What the user asked for.

    Raises
    ------
    BudgetError
        With the estimate, its largest part, what makes that less, and how to allow more.
    """
    limit = allowed()
    time, memory = sum(work.time for work in works), max((work.memory for work in works), default=0.0)
    if time <= limit.time and memory <= limit.memory:
        return
    late, large = time > limit.time, memory > limit.memory
    over = max(works, key=lambda work: max(late * work.time / limit.time, large * work.memory / limit.memory))
    raise BudgetError(
        f"{what} would take about {duration(time)} and {megabytes(memory)}, for {over.what}; allowed are"
        f" {duration(limit.time)} and {megabytes(limit.memory)}. {_advice(over.remedy, time, memory)}"
    )


def _advice(remedy: str, time: float, memory: float) -> str:
    """Say what makes a computation smaller, and how to allow it as it is, unless nobody would wait for it."""
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
    """Counts the steps of a march whose number is not known beforehand, and ends it when they are too many.

    Parameters
    ----------
    what : str
        What is marched, for the refusal.
    end : float
        Where the march ends [s].
    each : float
        About how long a step takes [s].
    remedy : str
        What makes them fewer, as for `Work`.
    """

    def __init__(self, what: str, *, end: float, each: float, remedy: str) -> None:
        self.what, self.end, self.each, self.remedy = what, end, each, remedy
        self.steps = 0
        self._most = allowed().time / each
        self._listener = _LISTENER.get()

    def count(self, now: float, *, steps: int = 1) -> None:
        """Count steps that have come to a time.

        Parameters
        ----------
        now : float
            How far the march is [s].
        steps : int
            How many more.

        Raises
        ------
        BudgetError
            If so many take longer than is allowed.
        """
        self.steps += steps
        share = now / self.end if self.end else 1.0
        if self._listener is not None:
            self._listener(share)
        if self.steps > self._most:
            whole = self.steps * self.each / max(share, 1e-12)
            self._refuse(
                f"took {self.steps} steps, about {duration(self.steps * self.each)} of computing time, up to {share:.1%} of"
                f" {self.end:.6g} s; the whole would take about {duration(whole)}",
                whole,
            )

    def expect(self, steps: int) -> None:
        """Count steps before they are made, those of a whole march.

        Parameters
        ----------
        steps : int
            How many more.

        Raises
        ------
        BudgetError
            If so many take longer than is allowed.
        """
        self.steps += steps
        if self.steps > self._most:
            whole = self.steps * self.each
            self._refuse(
                f"needs {self.steps} steps up to {self.end:.6g} s to be accurate, about {duration(whole)} of computing time",
                whole,
            )

    def _refuse(self, found: str, whole: float) -> NoReturn:
        limit = duration(allowed().time)
        raise BudgetError(f"{self.what} {found}; allowed are {limit}. {_advice(self.remedy, whole, 0.0)}")


@contextmanager
def listening(listener: Callable[[float], None] | None) -> Iterator[None]:
    """Tell someone how far a march is.

    Parameters
    ----------
    listener : callable or None
        Takes the share that is done, from 0 to 1; called often. None: nobody is told.

    Yields
    ------
    None
        Within the block, in this thread.
    """
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)
