"""Parts of a computation on several threads, and the name of what computes them."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


def kernel_name() -> str:
    """Return what computes populations, with the version on which the last bits of results depend."""
    return f"numba {version('numba')}"


def thread_count(threads: int | None) -> int:
    """Return the number of threads of a kernel."""
    if threads is not None:
        return max(1, int(threads))
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_threads(work: Callable[[Any], object], parts: Sequence[Any], threads: int | None) -> None:
    """Do some work for each part, on several threads."""
    count = min(thread_count(threads), len(parts))
    if count <= 1:
        for part in parts:
            work(part)
        return
    with ThreadPoolExecutor(count) as pool:
        list(pool.map(work, parts))


def ranges(count: int, size: int) -> list[tuple[int, int]]:
    """Return consecutive ranges of at most a size."""
    return [(begin, min(begin + size, count)) for begin in range(0, count, size)]
