"""Largest sizes of what a visitor of the page may ask for."""

from __future__ import annotations

from typing import Final

MOST_CHANGES: Final = 60
"""Parameters that a link may change."""
LONGEST_VALUE: Final = 300
"""Letters of a value in a link."""
LONGEST_LINK: Final = 6000
"""Letters of the part of an address behind its question mark."""
MOST_PINNED: Final = 4
"""Curves that are kept for comparison."""
MOST_SAMPLES: Final = 20_000
"""Output times, and frequencies, of one simulation."""
SHOWN_SAMPLES: Final = 400
"""Points of a curve that are sent to the browser."""
LARGEST_UPLOAD: Final = 20_000_000
"""Bytes of a recording."""
LONGEST_RUN: Final = 20.0
"""Estimated seconds of one simulation, above which it is refused."""
FINGERS: Final = 200
"""Draws from the population for a band."""
