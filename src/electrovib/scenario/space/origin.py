"""Source of a distribution: where its numbers are from, and how sure they are."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError, nearest
from electrovib.core.status import STATUSES, UNVERIFIED, status_text

if TYPE_CHECKING:
    from collections.abc import Mapping

CONFIDENCES: Final = ("high", "medium", "low")
"""How far the numbers of a distribution are those of the fingers meant, as the author of the space judges."""


@dataclass(frozen=True, kw_only=True)
class Origin:
    """Source of a distribution, or of the share of a group.

    `status` is one of `electrovib.core.status.STATUSES` and `confidence` one of `CONFIDENCES`; empty where
    none is stated. `choice` is what no source gives and the author of the space has chosen. With `optional`
    the entry is omitted for a scenario without the parameter.
    """

    source: str = ""
    status: str = ""
    confidence: str = ""
    choice: str = ""
    optional: bool = False

    @property
    def is_unverified(self) -> bool:
        """Whether the numbers are cited from memory."""
        return self.status == UNVERIFIED

    @property
    def in_words(self) -> str:
        """Status, confidence, source and choice as one text."""
        parts = [status_text(self.status)] if self.status else []
        parts += [f"{self.confidence} confidence"] if self.confidence else []
        parts += [self.source] if self.source else []
        parts += [f"a choice: {self.choice}"] if self.choice else []
        return "; ".join(parts)

    def as_table(self) -> dict[str, Any]:
        """Return what is stated, as keys of the table of a distribution."""
        return {each.name: value for each in fields(self) if (value := getattr(self, each.name))}


KEYS: Final = tuple(each.name for each in fields(Origin))
"""Keys of the table of a distribution that are not numbers of the distribution."""


def read_origin(where: str, content: Mapping[str, Any]) -> Origin:
    """Read the source of a distribution from its table."""
    allowed = {"status": STATUSES, "confidence": CONFIDENCES}
    given = {name: content[name] for name in KEYS if name in content}
    for name, value in given.items():
        kind = bool if name == "optional" else str
        if not isinstance(value, kind):
            wanted = "true or false" if kind is bool else "a text"
            raise InputError(f"{where}.{name} = {value!r}: expected {wanted}")
        if value and value not in allowed.get(name, (value,)):
            raise InputError(
                f"{where}.{name} = {value}: expected one of {', '.join(allowed[name])}."
                f"{nearest(str(value), allowed[name])}"
            )
    return Origin(**given)
