"""Exit codes of the commands."""

from __future__ import annotations

from typing import Final

FAILED: Final = 1
"""After a check that found a limit exceeded."""
MISTAKE: Final = 2
"""After a mistake that the user can correct."""
INTERRUPTED: Final = 130
"""After Ctrl-C: 128 plus the number of the signal."""
