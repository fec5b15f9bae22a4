"""How the source of a model or a value was read, and how that is written for people."""

from __future__ import annotations

from typing import Final

_SHOWN: Final = {
    "full text": "full text",
    "abstract": "abstract only",
    "derived": "derived here",
    "unverified": "unverified, cited from memory",
}
STATUSES: Final = tuple(_SHOWN)
"""How a source was read, from best to not at all."""
UNVERIFIED: Final = STATUSES[-1]
"""A value or an equation cited from memory: shown as such wherever it is used, and never a check."""
STATUSES_EXPLAINED: Final = (
    "in full text; as an abstract only; derived here from values that were read; or not at all, then it is unverified, cited"
    " from memory, and its numbers are never a check"
)


def status_text(status: str) -> str:
    """Write one of `STATUSES` for people; the empty status is that of a definition, which has no source."""
    return _SHOWN[status] if status else "a definition"
