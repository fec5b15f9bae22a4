"""Former names of what is public, which are read with a warning until the version in which they go."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
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
