"""What the models of a user return, checked where it is returned: each method that a family asks of its members."""

from __future__ import annotations

import functools
import inspect
import math
import re
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError, shortened

_OURS: Final = __name__.partition(".")[0]
_ARRAYS: Final = {
    "Real": "iuf", "NDArray[np.float64]": "iuf", "Complex": "iufc", "NDArray[np.complex128]": "iufc", "NDArray[np.bool_]": "b"
}  # fmt: skip
"""Results that are arrays of the shape of the arguments: the annotation, and the kinds of number it allows."""
_CONTAINERS: Final[dict[str, Any]] = {"tuple": (tuple, list), "dict": Mapping}
_PLAIN: Final = (type(None), str, bool, int, float, complex, list, tuple, dict, np.ndarray)
_LONGEST: Final = 160


def check_results(kind: type[Any]) -> None:
    """Let every method of a class of a user that its families annotate check what it returns."""
    if kind.__module__.partition(".")[0] == _OURS:
        return
    for name, found in list(vars(kind).items()):
        method = found.fget if isinstance(found, property) else found
        asked = inspect.isfunction(method) and name[0] != "_" and name not in kind.checked_elsewhere
        declared = _declared(kind, name) if asked else ""
        if declared and method is not None:
            checked = _checked(method, declared, kind)
            setattr(kind, name, property(checked) if isinstance(found, property) else checked)


def _declared(kind: type[Any], name: str) -> str:
    """Return what the nearest family of electrovib says that a method returns; empty where it says nothing."""
    for parent in kind.__mro__[1:]:
        found = vars(parent).get(name)
        declared = getattr(getattr(found, "fget", found), "__annotations__", {})
        if parent.__module__.partition(".")[0] == _OURS and "return" in declared:
            return str(declared["return"])
    return ""


def _checked(method: Callable[..., Any], declared: str, kind: type[Any]) -> Callable[..., Any]:
    """Return a method that states class, file and line if it fails or returns what its family does not allow."""

    @functools.wraps(method)
    def call(model: Any, *given: Any, **named: Any) -> Any:
        try:
            with np.errstate(all="ignore"):
                result = method(model, *given, **named)
        except (ElectrovibError, MemoryError):
            raise
        except Exception as error:
            raise failed(kind, method, error) from error
        arguments = [*given, *named.values()]
        try:
            return _allowed(result, declared, arguments, model, method.__name__)
        except ValueError as error:
            raise at_line(kind, method, f"returns {error}") from None

    return call


def failed(kind: type[Any], method: Callable[..., Any], error: Exception) -> InputError:
    """Return the error of a method of a user that raised one."""
    tracked = traceback.walk_tb(error.__traceback__)
    lines = [line for frame, line in tracked if frame.f_code is method.__code__]
    words = f": {error}" if str(error) else ""
    return at_line(kind, method, f"{type(error).__name__}{words}", *lines[:1])


def at_line(kind: type[Any], method: Callable[..., Any], why: str, line: int = 0) -> InputError:
    """Return an error with class, method, file and line, the first of the method unless another is given."""
    file = getattr(sys.modules.get(kind.__module__), "__file__", None)
    where = f" ({Path(file).name}, line {line or method.__code__.co_firstlineno})" if file else ""
    return InputError(f"{kind.__name__}.{method.__name__}{where}: {shortened(why, _LONGEST)}")


def _allowed(result: Any, declared: str, arguments: list[Any], model: Any, name: str) -> Any:
    """Return a result, as an array where it has to be one; what is wrong with it is a ValueError."""
    if result is None and declared.endswith("| None"):
        return None
    signed = name not in model.never_negative
    if declared not in _ARRAYS and not declared.startswith("float"):
        _refuse_kind(result, declared)
        for each in _numbers(result):
            if np.any(np.isnan(each)):
                raise ValueError(f"{declared} with nan in it")
        return result
    kinds, array = _ARRAYS.get(declared, "iuf"), np.asarray(result)
    if array.dtype.kind not in kinds:
        what = {"b": "yes or no", "iuf": "real numbers"}.get(kinds, "numbers")
        raise ValueError(f"{shortened(repr(result), 40)}, and {what} are expected")
    given = [np.asarray(each) for each in arguments if isinstance(each, (int, float, np.number, np.ndarray))]
    shape = max((each.shape for each in given), key=math.prod, default=())
    given = [each for each in given if each.shape in ((), shape)]
    if declared in _ARRAYS and array.shape != shape:
        if array.shape == ():
            array = np.full(shape, array)
        elif not _is_column(model):
            raise ValueError(
                f"an array of shape {array.shape}, and {shape} is expected, the shape of its arguments"
            )
    _refuse(array, given, signed=signed)
    return array if array.shape else result


def _refuse_kind(result: Any, declared: str) -> None:
    """Refuse another container than the one declared, and a plain value in the place of an object."""
    container: Any = next((each for word, each in _CONTAINERS.items() if declared.startswith(word)), object)
    objects = re.match(r"(tuple\[)?(?!Real|Linear|Any)[A-Z]", declared)
    items = result if objects and objects[1] and isinstance(result, container) else [result]
    if not isinstance(result, container) or (objects and any(type(each) in _PLAIN for each in items)):
        raise ValueError(f"{shortened(repr(result), 40)}, and {declared} is expected")


def _numbers(result: Any) -> Iterator[Any]:
    """Walk over the numbers in containers and in the attributes of objects that describe a part of a model."""
    if isinstance(result, Mapping):
        result = list(result.values())
    if isinstance(result, (tuple, list)):
        for each in result:
            yield from _numbers(each)
    elif isinstance(result, (np.ndarray, float, complex)):
        yield np.asarray(result)
    elif is_dataclass(result) and not isinstance(result, type):
        yield from _numbers([each for each in vars(result).values() if isinstance(each, (float, np.ndarray))])


def _refuse(array: Any, given: list[Any], *, signed: bool) -> None:
    """Refuse NaN and infinity that no argument explains, and a negative number where none may be.

    NaN of an argument explains those of a result that has NaN wherever the argument has; 0 explains infinity.
    """
    wrong = ~np.isfinite(array)
    if not signed:
        wrong |= (array.imag > 0) if array.dtype.kind == "c" else array < 0
    for each in given if np.any(wrong) else ():
        unknown = np.broadcast_to(np.isnan(each), array.shape)
        if np.all(np.isnan(array[unknown])):
            wrong &= ~unknown
        wrong &= ~(np.isinf(array) & ((each == 0) | np.isinf(each)))
    if np.any(wrong):
        least = "" if signed else ", 0 or more" if array.dtype.kind != "c" else ", with losses of 0 or more"
        places = f" at {np.sum(wrong)} of {array.size} places" if array.size > 1 else ""
        raise ValueError(f"{array[wrong][0]:.4g}{places}, and a finite number{least} is expected")


def _is_column(model: Any) -> bool:
    """Return whether a parameter of a model is a column of many fingers."""
    return any(
        isinstance(each, np.ndarray) or (hasattr(each, "never_negative") and _is_column(each))
        for _, each in model
    )
