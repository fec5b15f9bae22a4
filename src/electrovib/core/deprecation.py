"""Former names of what is public, which are read with a warning until the version in which they go."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, Final

_PASSED_ON: Final = ("electrovib", "importlib", "pydantic")
"""Packages whose lines the warning does not point to: they pass on what a user wrote."""


@dataclass(frozen=True)
class Former:
    """A former name: what stands in its place, since which version it warns, and in which version it goes."""

    now: str
    since: str
    goes: str

    def warn(self, name: str) -> str:
        """Warn of the former name, at the line of the user's that has it; return the present one."""
        frame = sys._getframe()  # noqa: SLF001  # `stacklevel` would need the number of calls in between
        while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] in _PASSED_ON:
            frame = frame.f_back
        warnings.warn_explicit(
            f"{name} is deprecated since electrovib {self.since} and goes in {self.goes}: use {self.now}",
            DeprecationWarning,
            frame.f_code.co_filename,
            frame.f_lineno,
            module=frame.f_globals.get("__name__"),
            registry=frame.f_globals.setdefault("__warningregistry__", {}),
        )
        return self.now


def former_attribute(name: str, now: str, read: Callable[[Any], Any]) -> property:
    """Make an attribute of results that `read` computes, and whose name warns that another is in its place."""
    known = Former(now, since="1.0.0", goes="2.0.0")
    return property(lambda result: read(result) if known.warn(f"{type(result).__name__}.{name}") else None)


FORMER: Final[dict[str, Former]] = {}
"""Former names of `electrovib`, such as ``"simulate_scenario": Former("simulate", since="1.1.0", goes="2.0.0")``."""
FORMER_PARAMETERS: Final[dict[str, dict[str, Former]]] = {
    name: {former: Former(now, since="1.0.0", goes="2.0.0") for former, now in names.items()}
    for name, names in {
        "measure_ring": {"signal": "quantity"},
        "measure_rings": {"signal": "quantity"},
        "measure_times": {"signal": "quantity"},
        "prepare": {"quantities": "quantity"},
        "run": {"quantities": "quantity"},
        "study": {"signal": "quantity", "draws": "records", "scheduler": "workers"},
        "sweep": {"quantities": "quantity"},
    }.items()
}
"""Former names of parameters, by the name of their function."""


@dataclass(frozen=True)
class Gone(Former):
    """A parameter that has left the signature of its function, with the annotation that it had."""

    annotation: str


_IN_RECIPE: Final = {
    **dict.fromkeys(("area", "thickness"), "str | float | None"),
    **dict.fromkeys(("series_resistance", "parallel_capacitance"), "str | float"),
    "columns": "Mapping[str, str] | None", "reader": "str", "delimiter": "str | None", "decimal_comma": "bool | None",
    "part": "str | None",
}  # fmt: skip
_AT_100_HZ: Final = {"frequency": ("float | str", "carrier=; without one the gain is that at 100 Hz")}
GONE_PARAMETERS: Final[dict[str, dict[str, Gone]]] = {
    function: {
        name: Gone(now, since="1.0.0", goes="2.0.0", annotation=annotation)
        for name, (annotation, now) in names.items()
    }
    for function, names in {
        "export_waveform": {
            "amplifier_present": (
                "bool",
                "circuit.amplifier.hardware, the maker and model that stands before the plate",
            ),
            "largest_error": ("float", "a higher rate=; 1 % of the largest voltage is allowed"),
            "full_scale": ("float | None", "scaling=electrovib.Scaling(full_scale=...)"),
            "gain": ("float", "scaling=electrovib.Scaling(gain=...)"),
            "remarks": ("Sequence[str]", "the title of the scenario, which the file states"),
        },
        "import_file": {"title": ("str", "trace.assign_attrs(title=...)")},
        "import_material": {
            each: (annotation, f"recipe=electrovib.SpectrumRecipe({each}=...)")
            for each, annotation in _IN_RECIPE.items()
        },
        "run_bench": {
            "report": ("Callable | None", "logging.getLogger('electrovib.bench'), which is told each step")
        },
        "study": {
            "budget_memory": (
                "float | str",
                "electrovib.budget(memory=...), of which percentiles take a quarter",
            ),
            "progress": (
                "Callable | None",
                "logging.getLogger('electrovib.study'), which is told the fingers done",
            ),
        },
        "texture_drive": _AT_100_HZ,
        "texture_stream": _AT_100_HZ,
    }.items()
}
"""Parameters that have left the signature of their function, which reads their values by `former_value`."""
_FORMER_VALUES: ContextVar[Mapping[str, Any] | None] = ContextVar("former values", default=None)


@contextmanager
def former_values(**given: Any) -> Iterator[None]:
    """Let a function that is called in the block find values of parameters that have left its signature."""
    token = _FORMER_VALUES.set(given)
    try:
        yield
    finally:
        _FORMER_VALUES.reset(token)


def former_value(name: str, otherwise: Any) -> Any:
    """Return the value of a parameter that has left the signature, or the one that holds without it."""
    return (_FORMER_VALUES.get() or {}).get(name, otherwise)


def present_names(function: str, given: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the arguments of a public function under the present names of its parameters, and values that it takes no more."""
    gone = [name for name in given if name in GONE_PARAMETERS.get(function, {})]
    for name in gone:
        GONE_PARAMETERS[function][name].warn(f"{function}({name}=)")
    former = FORMER_PARAMETERS.get(function, {})
    replaced = {name for name in given if name in former and former[name].now not in given}
    present = {
        former[name].warn(f"{function}({name}=)") if name in replaced else name: value
        for name, value in given.items()
        if name not in gone
    }
    return present, {name: given[name] for name in gone}
