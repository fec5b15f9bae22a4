"""How much memory a file or a text from outside may take while it is read."""

from __future__ import annotations

from typing import Final

_TIMES: Final = 10
_BASE: Final = 64 * 1024**2


def memory_allowed(size: int) -> int:
    """Bytes of memory that may be taken to read so many bytes: ten times as many, and 64 MB."""
    return _TIMES * size + _BASE


def content_allowed(size: int) -> int:
    """Bytes of numbers that so many bytes may unfold to: half the memory, because a conversion needs them twice."""
    return memory_allowed(size) // 2


def megabytes(size: float) -> str:
    """Write a number of bytes for a person.

    Parameters
    ----------
    size : float
        Bytes.

    Returns
    -------
    str
        In MB, GB from a thousand of them on, TB from a million.
    """
    if size >= 1e12:
        return f"{size / 1e12:.3g} TB"
    return f"{size / 1e9:.3g} GB" if size >= 1e9 else f"{size / 1e6:.3g} MB"
