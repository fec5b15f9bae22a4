"""Binary blocks of IEEE 488.2, ``#<digits><length><data>``, as instruments send and save them."""

from __future__ import annotations

import re
from typing import Final

_BEGIN: Final = re.compile(rb"#([1-9])(\d+)")


def block_at(raw: bytes, begin: int = 0) -> tuple[int, int] | None:
    """Return where the data of a block of definite length begin, and the length that it states; None of anything else."""
    found = _BEGIN.match(raw, begin, begin + 11)
    count = int(found[1]) if found else 0
    if found is None or len(found[2]) < count:
        return None
    return begin + 2 + count, int(found[2][:count])
