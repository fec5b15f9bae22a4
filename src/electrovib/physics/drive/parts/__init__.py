"""The three forms of a voltage for which a solver knows what to do."""

from electrovib.physics.drive.parts.gated import LOOKS, MOST_LOOKS, Chirped, Part, Smooth, Tones
from electrovib.physics.drive.parts.straight import Linear

__all__ = [
    "LOOKS",
    "MOST_LOOKS",
    "Chirped",
    "Linear",
    "Part",
    "Smooth",
    "Tones",
]
