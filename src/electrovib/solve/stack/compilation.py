"""How loops are compiled by numba: without the lock of the interpreter, and kept on disk where there is a folder for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable

# contract: a product and a sum may be rounded once; the order of operations is kept
_OPTIONS: Final[dict[str, Any]] = {
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
    "fastmath": {"contract"},
}


def inner(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that compiled functions of the same file call."""
    from numba import njit

    options = _OPTIONS | {"no_cpython_wrapper": True}
    return njit(function, **options)  # type: ignore[no-any-return]


def outer(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that Python calls, and cache it on disk where numba finds a folder to write to."""
    from numba import njit

    try:
        return njit(function, nogil=True, cache=True, **_OPTIONS)  # type: ignore[no-any-return]
    except RuntimeError:
        return njit(function, nogil=True, **_OPTIONS)  # type: ignore[no-any-return]
