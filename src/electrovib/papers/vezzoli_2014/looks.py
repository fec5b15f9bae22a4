"""What the colours of the figures stand for: the same thing has one colour in all of them."""

from __future__ import annotations

from typing import Final

MEANINGS: Final = (
    "paper point",
    "palmar men 2 uS",
    "1963 impedance",
    "Gabriel dry",
    "leaky gap",
    "Gabriel wet",
    "no conduction",
    "your table",
    "trembling hand",
    "sliding",
    "polarity",
    "sensor",
)
"""In the order of the palette."""
NOT_DRAWN: Final = len(MEANINGS)


def look(meaning: str) -> int:
    """Return the place of a meaning in the palette; that after the last for curves that are never drawn."""
    return MEANINGS.index(meaning) if meaning in MEANINGS else NOT_DRAWN
