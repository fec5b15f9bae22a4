"""Whether the pressure of a force law is a factor times the square of its amplitudes."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from electrovib.physics.force import ForceLaw

_DECADES: Final = (-12, 13)
"""Powers of ten of the amplitudes that are compared, several in each decade and of both signs."""
_IN_DECADE: Final = 7
_SAME: Final = 1e-14
"""Relative difference of two pressures by rounding."""


def is_quadratic(law: ForceLaw) -> bool:
    """Return whether multiplying all amplitudes of a law by a number multiplies its pressure by the square of it."""
    names = [
        name
        for name, each in inspect.signature(law.pressure).parameters.items()
        if each.kind in {each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY}
    ]
    if not names:
        return False
    sizes = np.logspace(*_DECADES, _IN_DECADE * (_DECADES[1] - _DECADES[0]))
    factors = np.concatenate([[0.0], sizes, -sizes])
    alone = {name: 1.0 + 0.37 * place for place, name in enumerate(names)}
    try:
        one = float(law.pressure(**{name: np.array(value) for name, value in alone.items()}))
        found = np.asarray(law.pressure(**{name: value * factors for name, value in alone.items()}))
    except (TypeError, ValueError):
        return False
    expected = one * factors**2
    return bool(found.shape == factors.shape and np.all(np.abs(found - expected) <= _SAME * np.abs(expected)))
