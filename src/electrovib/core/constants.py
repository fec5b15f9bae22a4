"""Physical constants."""

from __future__ import annotations

from typing import Final

VACUUM_PERMITTIVITY: Final = 8.8541878128e-12
"""Electric constant [F/m], CODATA 2018."""
eps0: Final = VACUUM_PERMITTIVITY
"""The electric constant under the name that formulas use."""
