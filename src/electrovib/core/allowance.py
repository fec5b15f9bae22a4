"""The memory that reading a file or a text from outside may use, and the threads of linear algebra."""

from __future__ import annotations

from typing import Final

ONE_THREAD: Final = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Environment for linear algebra on one thread, which numpy reads when it is imported. Threads gain nothing for our matrices of
some hundred columns, and wait for each other where another process uses a core: up to twenty times as long as one computes."""


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
