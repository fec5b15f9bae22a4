"""The computing time and memory that a computation may use: counted before it begins, and measured while it runs."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import Any, Final, TypeVar

from electrovib.core.errors import InputError
from electrovib.core.units import parse_quantity

_NOBODY_WAITS: Final = 7 * 86400.0
_NOBODY_HAS: Final = 1e12
_NUMBER: Final = 3e-8
"""Computing time of a number, about [s]: by it counts are refused before anything is measured."""


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


T = TypeVar("T")
_DEFAULT: Final = Budget()
_ALLOWED: ContextVar[Budget] = ContextVar("allowed", default=_DEFAULT)
LISTENER: ContextVar[Callable[[float], None] | None] = ContextVar("listener", default=None)


@contextmanager
def holding(variable: ContextVar[T], value: T) -> Iterator[T]:
    """Let a variable have a value within the block, in this thread."""
    token = variable.set(value)
    try:
        yield value
    finally:
        variable.reset(token)


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

    Examples
    --------
    >>> with ev.budget(time="1 h", memory="16 GB"):
    ...     trace = ev.simulate("vezzoli_2014/fig6")
    """
    chosen = _ALLOWED.get()
    if time is not None:
        chosen = replace(chosen, time=_positive("time", time, _seconds))
    if memory is not None:
        chosen = replace(chosen, memory=_positive("memory", memory, _bytes))
    with holding(_ALLOWED, chosen):
        yield chosen


def read_budget(text: str) -> dict[str, float]:
    """Read ``time`` [s] and ``memory`` [bytes], or one of them, from a text such as ``"2 h, 16 GB"``."""
    found: dict[str, float] = {}
    for part in map(str.strip, text.split(",")):
        name, read = ("memory", _bytes) if _MEMORY.fullmatch(part) else ("time", _seconds)
        if not any(sign.isalpha() for sign in part.lower().replace("e", "")) and any(map(str.isdigit, part)):
            raise InputError(
                f"--budget = '{text}': {part} of what? Give its unit: '{part} min' or '{part} GB'"
            )
        if name in found:
            raise InputError(f"--budget = '{text}': names {name} twice")
        found[name] = _positive("--budget", part, read)
    return found


def refuse_beyond(works: Sequence[Work], *, what: str = "this run") -> None:
    """Refuse a computation whose estimate exceeds the budget; times of `works` add up, and the largest memory counts."""
    limit = allowed()
    if sum(work.time for work in works) > limit.time or any(work.memory > limit.memory for work in works):
        raise too_much(works, what)


def too_much(works: Sequence[Work], what: str) -> BudgetError:
    """Return the error for a computation beyond the budget: time, memory, the part to which it is due, what helps."""
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
    limit, asked = allowed(), {}
    if _MORE * time > limit.time:
        asked["time"] = duration(_MORE * time)
    if _MORE * memory > limit.memory:
        asked["memory"] = megabytes(_MORE * memory)
    option = ", ".join(asked.values())
    arguments = ", ".join(f"{name}='{text}'" for name, text in asked.items())
    return f"{advice}, or allow more: electrovib --budget '{option}' ..., or electrovib.budget({arguments}) in Python"


@contextmanager
def listening(listener: Callable[[float], None] | None) -> Iterator[None]:
    """Report the progress of time stepping in the block to a listener, as the fraction that is done, 0 to 1."""
    with holding(LISTENER, listener):
        yield


_MEMORY: Final = re.compile(r"\s*(\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)\s*(B|kB|MB|GB|TB)\s*")
_BYTES: Final = {"B": 1.0, "kB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12}
_DURATIONS: Final = (("days", 86400.0, 3), ("h", 3600.0, 2), ("min", 60.0, 2), ("s", 1.0, 0))
_MORE: Final = 1.5
"""Factor on the estimate that a refusal recommends: an estimate is right within a factor of about two."""


def duration(seconds: float) -> str:
    """Write a computing time [s] in s, min, h or days, with two significant digits."""
    unit, length = next((unit, length) for unit, length, fewest in _DURATIONS if seconds >= fewest * length)
    return f"{float(f'{seconds / length:.2g}'):g} {unit}"


_EXPECTED: Final = "a time above 0 such as '30 min', or a memory such as '8 GB'"


def _positive(
    name: str, value: float | str, read: Callable[[str], float], expected: str = _EXPECTED
) -> float:
    number = read(value) if isinstance(value, str) else float(value)
    if not (math.isfinite(number) and number > 0):
        raise InputError(f"{name} = {value}: expected {expected}")
    return number


def _seconds(text: str) -> float:
    try:
        return parse_quantity(text, "s")
    except ValueError:
        return math.nan


def _bytes(text: str) -> float:
    found = _MEMORY.fullmatch(text)
    return float(found[1]) * _BYTES[found[2]] if found else math.nan


def amount_of_memory(name: str, value: float | str) -> float:
    """Read an amount of memory [bytes], given as a number above 0 or as a text such as ``"8 GB"``."""
    return _positive(name, value, _bytes, "an amount of memory above 0, for instance '1 GB'")


ONE_THREAD: Final = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Environment for linear algebra on one thread, which numpy reads when it is imported. Threads gain nothing for our matrices of
some hundred columns, and wait for each other where another process uses a core: up to a hundred times as long as one computes."""


@contextmanager
def one_thread(*, with_scipy: bool = False) -> Iterator[None]:
    """Compute linear algebra on one thread in the block, and with the library of scipy; as a decorator in a function."""
    if os.environ.items() >= ONE_THREAD.items():  # the libraries have read it
        yield
        return
    from threadpoolctl import threadpool_limits

    if with_scipy:
        import scipy.linalg  # noqa: F401  # only a library that is loaded is limited
    with threadpool_limits(limits=1, user_api="blas"):
        yield


def memory_allowed(size: int) -> int:
    """Return the memory in bytes that reading `size` bytes may use: ten times the size plus 64 MB."""
    return 10 * size + 64 * 1024**2


def content_allowed(size: int) -> int:
    """Return how many bytes of numbers `size` bytes may unpack to: half the memory, because a conversion holds them twice."""
    return memory_allowed(size) // 2


def megabytes(size: float) -> str:
    """Write a number of bytes in MB, GB or TB, with three digits."""
    if size >= 1e12:
        return f"{size / 1e12:.3g} TB"
    return f"{size / 1e9:.3g} GB" if size >= 1e9 else f"{size / 1e6:.3g} MB"


ItemListener = Callable[[str, int, int], None]
"""Takes what is computed, the number of the item from 1 on, and the number of all items."""
_OF_ITEMS: ContextVar[ItemListener | None] = ContextVar("item listener", default=None)


@contextmanager
def items_heard(listener: ItemListener) -> Iterator[None]:
    """Inform a listener of each item that is begun in the block, in this thread."""
    with holding(_OF_ITEMS, listener):
        yield


def each_item(names: Sequence[str]) -> Iterator[str]:
    """Yield the names of the items of a computation, and inform the listener before each."""
    for number, name in enumerate(names, 1):
        if (listener := _OF_ITEMS.get()) is not None:
            listener(name, number, len(names))
        yield name


def computed(items: Sequence[tuple[str, Callable[[], Iterable[Any]]]]) -> list[tuple[Any, ...]]:
    """Compute items in their order, and inform the listener before each."""
    functions = [function for _, function in items]
    names = each_item([name for name, _ in items])
    return [tuple(function()) for _, function in zip(names, functions, strict=True)]
