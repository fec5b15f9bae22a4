"""The value of one parameter that gives a wanted quantity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.scenario import Scenario


def design_parameter(
    scenario: Scenario,
    *,
    want: str,
    free: str,
    between: str | None = None,
    limits: Any = None,
    space: Any = None,
    n: int = 200,
    seed: int = 1,
    linear: bool = False,
    progress: Any = None,
) -> Any:
    """Find the value of one parameter that gives a wanted quantity."""
    raise InputError("not yet")
