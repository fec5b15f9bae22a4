"""What a command ends with."""

from __future__ import annotations

from typing import Final

MISTAKE: Final = 2
"""After a mistake that the user can mend."""
INTERRUPTED: Final = 130
"""After Ctrl-C: 128 and the number of the signal."""
