"""Exit codes of the commands."""

from __future__ import annotations

from typing import Final

FAILED: Final = 1
"""After a check that found a limit exceeded."""
MISTAKE: Final = 2
"""After a mistake that the user can correct."""
MISFIT: Final = 3
"""After a fit of a model that does not describe its data."""
NOT_SHOWN: Final = 5
"""After a check that found no limit exceeded, but did not show that the set-up is safe."""
INTERRUPTED: Final = 130
"""After Ctrl-C: 128 plus the number of the signal."""
UNPRINTED: Final = 4
"""After a command that did everything, but whose output could not be printed completely."""


class Told(SystemExit):
    """An end of which the command has said everything."""
