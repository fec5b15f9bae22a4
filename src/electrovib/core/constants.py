"""Constants of nature."""

from __future__ import annotations

from typing import Final

VACUUM_PERMITTIVITY: Final = 8.8541878128e-12
"""Electric constant [F/m], CODATA 2018."""
eps0: Final = VACUUM_PERMITTIVITY
"""The same, as formulas write it."""
