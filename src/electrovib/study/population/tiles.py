"""Division of the fingers into tiles, whose size follows from the measured computing time."""

from __future__ import annotations

from typing import Final

from electrovib.study.population.declared import BLOCK

_FIRST: Final = 16
_LARGEST: Final = 64 * BLOCK
_BYTES: Final = 64e6
"""Memory of the signals that are computed together, about [bytes]."""


def largest_tile(numbers: int) -> int:
    """Return the largest number of fingers whose signals are computed together, a power of 2."""
    return _power_below(min(_LARGEST, max(1.0, _BYTES / (8 * numbers))))


class TileSizes:
    """Tiles of fingers that take about a given time.

    Parameters
    ----------
    fingers : int
        Number of fingers of the study.
    most : int
        Largest number of fingers in a tile, a power of 2.
    seconds : float
        Computing time of a tile, about [s].
    in_arrays : bool
        Whether fingers are computed in arrays, so fast that every tile is a block at least.

    Notes
    -----
    A tile has 2^k fingers and begins at a multiple of its size, so that it is a part of a block of 1024 fingers or
    consists of whole blocks. Results do not depend on the tiles.
    """

    def __init__(self, fingers: int, most: int, *, seconds: float, in_arrays: bool = False) -> None:
        self.fingers, self.most, self.seconds = fingers, most, seconds
        self.least = min(BLOCK, most) if in_arrays else 1
        self.wanted = max(self.least, min(_FIRST, most))

    def stop(self, start: int) -> int:
        """Return the index after the last finger of the tile that begins at a finger."""
        aligned = start & -start or self.most
        return min(self.fingers, start + min(self.wanted, aligned))

    def measured(self, fingers: int, seconds: float) -> None:
        """Adapt the size to the measured computing time of a tile."""
        each = max(seconds, 1e-6) / fingers
        self.wanted = _power_below(min(float(self.most), max(float(self.least), self.seconds / each)))


def _power_below(number: float) -> int:
    """Return the largest power of 2 that is not above a number of at least 1."""
    return 1 << (int(number).bit_length() - 1)
