"""Loops that numba compiles where it is installed, the extra ``compiled``; without it they run as they are, or as arrays."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable

# contract: a product and a sum may be rounded once; the order of operations is kept
_OPTIONS: Final[dict[str, Any]] = {
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
    "fastmath": {"contract"},
}


def is_compiled() -> bool:
    """Return whether numba is installed; it is not imported."""
    return find_spec("numba") is not None


def inner(function: Callable[..., Any], **options: Any) -> Callable[..., Any]:
    """Compile a function that compiled functions of the same file call; without wrappers, which take most of the time."""
    if not is_compiled():
        return function
    from numba import njit

    return njit(function, **_OPTIONS | {"no_cpython_wrapper": True} | options)  # type: ignore[no-any-return]


def outer(function: Callable[..., Any], **options: Any) -> Callable[..., Any]:
    """Compile a function that Python calls, and cache it on disk where numba finds a folder to write to."""
    if not is_compiled():
        return function
    from numba import njit

    options = _OPTIONS | {"nogil": True} | options
    try:
        return njit(function, cache=True, **options)  # type: ignore[no-any-return]
    except RuntimeError:
        return njit(function, **options)  # type: ignore[no-any-return]
