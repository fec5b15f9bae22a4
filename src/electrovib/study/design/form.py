"""A form in which a design is asked for."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

_ALWAYS: Final = ("scenario", "progress")


@dataclass(frozen=True)
class DesignForm:
    """One form of the question; the first argument in `needs` decides that it is meant, and `load` returns its function."""

    name: str
    needs: tuple[str, ...]
    example: str
    load: Callable[[], Callable[..., Any]]

    @property
    def accepts(self) -> tuple[str, ...]:
        """Names of the arguments of the form, the scenario and the report of progress omitted."""
        return tuple(name for name in inspect.signature(self.load()).parameters if name not in _ALWAYS)
