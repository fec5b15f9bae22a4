"""A number that a source states, and how the same number is computed here."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field
from typing import TYPE_CHECKING, Any

from electrovib.core.status import STATUSES, UNVERIFIED

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["STATUSES", "Check"]


@dataclass(frozen=True)
class Check:
    """Comparison of a published or derived number with the number computed here.

    - `name`: the method of the model that is called with `given`, or the quantity that `compute` returns.
    - `expect`: the number that the source states [SI].
    - `rtol`: relative tolerance, from the digits that the source prints.
    - `compute`: for a check of a whole paper, takes nothing and returns the number computed here.
    - `status`: one of `STATUSES`; a number cited from memory is never a check.
    """

    name: str
    _: KW_ONLY
    expect: float
    rtol: float
    source: str
    given: Mapping[str, float] = field(default_factory=dict)
    compute: Callable[[], float] | None = None
    status: str = "full text"

    def __post_init__(self) -> None:
        """Refuse a check against a number whose source was not read."""
        if self.status not in STATUSES or self.status == UNVERIFIED:
            msg = f"check '{self.name}': status '{self.status}' cannot be checked against"
            raise TypeError(msg)
        if self.expect == 0 or not 0 < self.rtol < 1:
            msg = f"check '{self.name}': needs a number other than 0 and a relative tolerance below 1"
            raise TypeError(msg)

    def value(self, model: Any = None) -> float:
        """Compute the number."""
        if self.compute is not None:
            return float(self.compute())
        return float(getattr(model, self.name)(**self.given))

    def accepts(self, value: float) -> bool:
        """Return whether a number agrees within the tolerance, bounds included; NaN never agrees."""
        return abs(value - self.expect) <= self.rtol * abs(self.expect)
