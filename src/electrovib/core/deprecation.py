"""Former names of what is public, which are read with a warning until the version in which they go."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Mapping
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
        "study": {"signal": "quantity", "draws": "records"},
        "sweep": {"quantities": "quantity"},
    }.items()
}
"""Former names of parameters, by the name of their function."""


def present_names(function: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of a public function under the present names of its parameters."""
    former = FORMER_PARAMETERS.get(function, {})
    replaced = {name for name in given if name in former and former[name].now not in given}
    return {
        former[name].warn(f"{function}({name}=)") if name in replaced else name: value
        for name, value in given.items()
    }
