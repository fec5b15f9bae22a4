"""The border of the public functions: what is given is read by the annotation of its parameter, or refused in one sentence."""

from __future__ import annotations

import functools
import inspect
import numbers
import os
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from electrovib.core.deprecation import GONE_PARAMETERS, former_values, present_names
from electrovib.core.errors import Problem, refuse
from electrovib.core.signals import is_trace

_UNITS: Final = {
    "voltage": "V", "voltages": "V", "full_scale": "V", "rate": "Hz", "time": "s", "at": "s", "start": "s", "window": "s",
    "before": "s", "duration": "s", "ramp": "s", "pressure": "Pa", "electrical_thickness": "m", "force": "N",
}  # fmt: skip
"""Unit of a number, by the name of its parameter; any other is a plain number."""
_ALIAS: Final = re.compile(r"Any|\w*(Source|Limits|Amount)")
"""Names that stand for several types, which their functions read and refuse themselves."""
_MEANT: Final = {
    "Channels": "TribometerChannels | Mapping[str, Any] | str | Path",
    "Progress": "Callable[[int, int], bool | None]",
    "Recorded": "Recording | MeasuredTrace | xarray.Dataset | str | Path",
    "SensorSource": "Sensor | str | None",
}
"""Names that stand for several types, which their functions do not refuse."""
_WRONG: Final = (ValueError, TypeError, OverflowError)
_NO_LIST: Final = (str, bytes, Mapping, set, frozenset)
_PARTS: Final = re.compile(r"(\w[\w.]*)(?:\[(.*)\])?")


@dataclass(frozen=True)
class _Kind:
    """What an annotation allows: in words, whether a value is of it, and how another value becomes one or is refused."""

    words: str
    holds: Callable[[Any], bool]
    convert: Callable[[Any], Any]

    def read(self, value: Any) -> Any:
        """Return a value that is of this kind as it is, and any other converted."""
        return value if self.holds(value) else self.convert(value)


@functools.cache
def public(function: Callable[..., Any], public_name: str) -> Callable[..., Any]:
    """Return a function of the package as users call it by a name: texts become numbers, and a wrong type is an InputError."""
    signature = inspect.signature(function)
    kinds = {
        name: _kind(each.annotation, _UNITS.get(name, "1"))
        for name, each in signature.parameters.items()
        if each.kind is not each.VAR_KEYWORD and isinstance(each.annotation, str)
    }
    left = GONE_PARAMETERS.get(public_name, {})
    kinds |= {name: _kind(each.annotation, _UNITS.get(name, "1")) for name, each in left.items()}

    @functools.wraps(function)
    def call(*args: Any, **options: Any) -> Any:
        options, gone = present_names(public_name, options)
        try:
            given = signature.bind(*args, **options)
        except TypeError:  # of a name that is unknown, missing or given twice, as Python says it
            return function(*args, **options)
        problems = []
        for values in (given.arguments, gone):
            for name, value in values.items():
                try:
                    values[name] = kinds[name].read(value) if name in kinds else value
                except _WRONG:
                    from electrovib.core.mistakes import shown

                    why = f"{public_name} takes {kinds[name].words}"
                    problems.append(Problem(why, path=name, value=shown(value)))
        refuse(problems)
        with former_values(**gone):
            return function(*given.args, **given.kwargs)

    call.__module__ = __name__.partition(".")[0]  # where it is public, so that it can be pickled
    call.__name__ = call.__qualname__ = public_name
    return call


def _kind(annotation: str, unit: str) -> _Kind:
    """Read the text of an annotation; names that it separates by bars are tried in their order."""
    kinds = [_one_kind(text, unit) for text in _split(annotation, "|")]
    if _ANYTHING in kinds or len(kinds) == 1:
        return _ANYTHING if _ANYTHING in kinds else kinds[0]

    def convert(value: Any) -> Any:
        for kind in kinds:
            try:
                return kind.convert(value)
            except _WRONG:
                continue
        raise TypeError(value)

    words = " or ".join(dict.fromkeys(kind.words for kind in kinds if kind.words))
    return _Kind(words, lambda value: any(kind.holds(value) for kind in kinds), convert)


def _one_kind(annotation: str, unit: str) -> _Kind:
    found = _PARTS.fullmatch(annotation)
    assert found, annotation
    name, inner = found.groups()
    if name in _MEANT:
        return _kind(_MEANT[name], unit)
    if name in _SIMPLE or _ALIAS.fullmatch(name):
        return _SIMPLE.get(name, _ANYTHING)
    if name in _OF_UNIT:
        return _OF_UNIT[name](unit)
    if name in _HOLDING:
        within = "" if name == "Mapping" else unit
        return _HOLDING[name](*(_kind(each, within) for each in _split(inner, ",")))
    return _one_of(_split(inner, ",")) if name == "Literal" else _instance(name)


def _one_of(quoted: list[str]) -> _Kind:
    """Read one of some texts."""
    allowed = [each.strip("'\"") for each in quoted]
    return _Kind(
        " or ".join(map(repr, allowed)), lambda value: isinstance(value, str) and value in allowed, _refused
    )


def _instance(name: str) -> _Kind:
    """Read an instance of a class, which is known by its name, so that its module need not be imported."""
    return _Kind(f"a {name}", lambda value: name in {each.__name__ for each in type(value).__mro__}, _refused)


def _split(text: str, sign: str) -> list[str]:
    """Split an annotation at a sign outside its brackets."""
    parts, depth = [""], 0
    for each in text:
        depth += (each == "[") - (each == "]")
        if each == sign and not depth:
            parts.append("")
        else:
            parts[-1] += each
    return [part.strip() for part in parts]


def _refused(value: object) -> Any:
    """Convert nothing."""
    raise TypeError(value)


def _numeric(value: Any) -> Any:
    """Return numbers as an array; texts, bytes, tables, complex numbers and a truth alone are none."""
    import numpy as np

    found = np.asarray(value)
    if found.dtype.kind not in "fiu" and not (found.dtype.kind == "b" and found.ndim):
        raise TypeError(value)
    return found.astype(float)


def _number(unit: str) -> _Kind:
    """Read a number, or a text with the unit; without a unit a text is left to the function, which knows what it is of."""
    from electrovib.core.units import KINDS, parse_quantity

    def holds(value: Any) -> bool:
        is_number = isinstance(value, numbers.Real) and not isinstance(value, bool)
        return is_number or (not unit and isinstance(value, str))

    def convert(value: Any) -> float:
        return parse_quantity(value, unit or "1") if isinstance(value, str) else float(_numeric(value))

    kind, example = KINDS.get(unit, KINDS["1"])
    return _Kind(kind if unit in {"", "1"} else f"{kind}, for instance '{example}'", holds, convert)


def _whole_number(_: str) -> _Kind:
    from electrovib.core.units import parse_count

    def convert(value: Any) -> int:
        return parse_count(value if isinstance(value, str) else repr(float(_numeric(value))))

    def holds(value: Any) -> bool:
        return isinstance(value, numbers.Integral) and not isinstance(value, bool)

    return _Kind("a whole number", holds, convert)


def _array(unit: str) -> _Kind:
    number = _number(unit)

    def convert(value: Any) -> Any:
        import numpy as np

        texts = [value] if isinstance(value, str) else value
        if isinstance(texts, (list, tuple)) and any(isinstance(each, str) for each in texts):
            value = [number.convert(each) for each in texts]
        return np.atleast_1d(_numeric(value))

    def holds(value: Any) -> bool:
        return type(value).__name__ == "ndarray" and value.ndim > 0 and value.dtype.kind in "fiub"

    return _Kind("numbers" if unit in {"", "1"} else f"numbers [{unit}]", holds, convert)


def _complex_array(_: str) -> _Kind:
    def convert(value: Any) -> Any:
        import numpy as np

        found = np.asarray(value)
        return found.astype(complex) if found.dtype.kind == "c" else _numeric(value)

    return _Kind("complex numbers", lambda _: False, convert)


def _opened(value: Any) -> Any:
    """Open the file of a Trace."""
    from electrovib.data.traces import open_trace

    return open_trace(os.fspath(value))


def _list_of(each: _Kind) -> _Kind:
    """Read a list; a value alone is a list of one."""

    def holds(value: Any) -> bool:
        is_list = isinstance(value, (list, tuple, range)) or getattr(value, "ndim", 0) == 1
        return is_list and all(each.holds(one) for one in value)

    def convert(value: Any) -> Any:
        if each.holds(value):
            return (value,)
        if isinstance(value, _NO_LIST) or not isinstance(value, Iterable):
            raise TypeError(value)
        return tuple(map(each.read, value))

    return _Kind(f"a list of {each.words or 'values'}", holds, convert)


def _table_of(name: _Kind, each: _Kind) -> _Kind:
    """Read a table by names."""

    def holds(value: Any) -> bool:
        is_table = isinstance(value, Mapping) and all(map(name.holds, value))
        return is_table and all(map(each.holds, value.values()))

    def convert(value: Any) -> Any:
        if not isinstance(value, Mapping) or not all(map(name.holds, value)):
            raise TypeError(value)
        return {key: each.read(one) for key, one in value.items()}

    return _Kind(f"a table of {each.words or 'values'} by name", holds, convert)


def _row_of(*each: _Kind) -> _Kind:
    """Read as many values as an annotation lists."""

    def convert(value: Any) -> Any:
        if isinstance(value, _NO_LIST) or len(value) != len(each):
            raise TypeError(value)
        return tuple(kind.read(one) for kind, one in zip(each, value, strict=True))

    return _Kind(f"{len(each)} values, each {each[0].words}", lambda _: False, convert)


def _truth(value: Any) -> bool:
    """Return 0 and 1 as what they stand for."""
    if value not in {0, 1}:
        raise TypeError(value)
    return bool(value)


_ANYTHING: Final = _Kind("", lambda _: True, _refused)
_SIMPLE: Final = {
    "None": _Kind("", lambda value: value is None, _refused),
    "str": _Kind("a text", lambda value: isinstance(value, str), _refused),
    "bool": _Kind("True or False", lambda value: isinstance(value, bool), _truth),
    "Path": _Kind("the name of a file", lambda value: isinstance(value, os.PathLike), Path),
    "Callable": _Kind("a function", callable, _refused),
    "xarray.Dataset": _Kind("a Trace, or its file", is_trace, _opened),
}
_OF_UNIT: Final = {
    "float": _number,
    "int": _whole_number,
    "Real": _array,
    "ArrayLike": _array,
    "Complex": _complex_array,
}
_HOLDING: Final[dict[str, Callable[..., _Kind]]] = {
    "Sequence": _list_of,
    "Mapping": _table_of,
    "tuple": _row_of,
}
