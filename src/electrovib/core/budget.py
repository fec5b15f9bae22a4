"""The computing time and memory that a computation may use: estimated before it begins, refused beyond the budget."""

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
    """A computation that would exceed the allowed computing time or memory."""


@dataclass(frozen=True)
class Budget:
    """The computing time [s], on one core of a common computer, and the memory [bytes] that one computation may use."""

    time: float = 600.0
    memory: float = 4e9


@dataclass(frozen=True, kw_only=True)
class Work:
    """One part of a computation, estimated before it begins.

    `what` says what is computed, with its count (``"1e+08 output times"``), and `remedy` what reduces it, as
    an instruction to the user (``"ask for fewer time.samples"``). `time` [s]; `memory` [bytes] is what is
    held at once.
    """

    what: str
    time: float
    memory: float
    remedy: str


_DEFAULT: Final = Budget()
_ALLOWED: ContextVar[Budget] = ContextVar("allowed", default=_DEFAULT)
_LISTENER: ContextVar[Callable[[float], None] | None] = ContextVar("listener", default=None)


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
    The estimate counts output times, corners and cycles of the drive, and time steps, each with its computing time on a
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
    if time <= limit.time and memory <= limit.memory:
        return
    late, large = time > limit.time, memory > limit.memory
    over = max(works, key=lambda work: max(late * work.time / limit.time, large * work.memory / limit.memory))
    raise BudgetError(
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
    """Counter of time steps whose number is not known beforehand; it ends the time stepping beyond the budget.

    The time stepping ends at `end` [s]; one step takes a computing time of about `each` [s]. `what` and
    `remedy` are as in `Work`.
    """

    def __init__(self, what: str, *, end: float, each: float, remedy: str) -> None:
        self.what, self.end, self.each, self.remedy = what, end, each, remedy
        self.steps = 0
        self._most = allowed().time / each
        self._listener = _LISTENER.get()

    def count(self, now: float, *, steps: int = 1) -> None:
        """Count further steps, of which the last has reached the time `now` [s]; refuse to go on beyond the budget."""
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
        """Count the steps of a whole time stepping before they are made."""
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
    """Report the progress of time stepping in the block to a listener, as the fraction that is done, 0 to 1."""
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)
