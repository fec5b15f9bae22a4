"""How kernels are compiled: without the interpreter's lock, kept on disk, products and sums in the order written."""
# mypy: disable-error-code="no-any-return, call-overload, attr-defined"

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Any

from electrovib.solve.recursion.vectors.width import WIDTH

if TYPE_CHECKING:
    from collections.abc import Callable

_OPTIONS: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True, "fastmath": {"contract", "nsz"}}


@functools.cache
def _stamp(folder: Path) -> tuple[Any, ...]:
    """Return the width of vectors, and name, time and size of every file from which the kernels of a folder are compiled."""
    files = {*Path(__file__).parent.glob("*.py"), *folder.glob("*.py"), *folder.parent.glob("*.py")}
    return WIDTH, *sorted((each.name, each.stat().st_mtime_ns, each.stat().st_size) for each in files)


def inner(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that only compiled functions call."""
    from numba import njit

    return njit(function, no_cpython_wrapper=True, **_OPTIONS)


def outer(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that Python calls, and cache it on disk where numba finds a folder to write to."""
    from numba import njit

    try:
        made = njit(function, nogil=True, cache=True, **_OPTIONS)
    except RuntimeError:
        return njit(function, nogil=True, **_OPTIONS)
    # numba compiles anew when the file of the function changes; the files of the functions that it calls count as well
    file = getattr(getattr(made, "_cache", None), "_cache_file", None)
    if file is None or not hasattr(
        file, "_source_stamp"
    ):  # another numba: code that may be out of date is never loaded
        return njit(function, nogil=True, **_OPTIONS)
    file._source_stamp = _stamp(Path(function.__code__.co_filename).parent)  # noqa: SLF001
    return made


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function of vectors into its callers."""
    from numba import njit

    return njit(function, no_cpython_wrapper=True, forceinline=True, **_OPTIONS)
