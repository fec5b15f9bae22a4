"""Random numbers that depend on seed, stream, index and attempt alone: the counter of a Philox generator is the index."""

from __future__ import annotations

import functools
import hashlib
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.core.arrays import Real

_WORDS: Final = 4
"""Numbers of 64 bits for each value of the counter of Philox 4x64."""
_DROPPED: Final = 12
"""Bits of a word that a share does not use: 52 bits and a half step keep it inside 0 and 1 without rounding."""
_LARGEST: Final = 2**64


def uniform_shares(stream: str, *, seed: int, start: int, stop: int, attempt: int = 0) -> Real:
    """Return independent uniform numbers, from 2**-53 to 1 - 2**-53, of the draws from `start` to before `stop`.

    Another `stream` or `attempt`, the number of a repetition from 0, gives independent numbers; `seed` is
    below 2**64.
    """
    key = np.array([seed, _key_of(stream)], dtype=np.uint64)
    counter = np.array([start // _WORDS, 0, 0, attempt], dtype=np.uint64)
    skipped = start % _WORDS
    words = np.random.Philox(key=key, counter=counter).random_raw(skipped + stop - start)[skipped:]
    words >>= np.uint64(_DROPPED)
    shares = words.astype(np.float64)
    shares += 0.5
    shares *= 2.0 ** (_DROPPED - 64)
    return shares


def checked_seed(seed: object) -> int:
    """Return a seed, or refuse what is no whole number from 0 to 2**64 - 1."""
    if isinstance(seed, (int, np.integer)) and not isinstance(seed, bool) and 0 <= seed < _LARGEST:
        return int(seed)
    raise InputError(f"seed = {seed!r}: expected a whole number from 0 to 2**64 - 1, for instance 1")


@functools.cache
def _key_of(stream: str) -> int:
    return int.from_bytes(hashlib.blake2b(stream.encode(), digest_size=8).digest(), "little")
