"""What every result of a design offers, whatever was asked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

if TYPE_CHECKING:
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.study.check import LimitsSource


@runtime_checkable
class Designed(Protocol):
    """Result of a design."""

    @property
    def scenario(self) -> Scenario | None:
        """Scenario with the result in it, which can be simulated; None if there is none."""
        ...

    @property
    def is_achieved(self) -> bool:
        """Whether the result gives what is wanted, within the limits."""
        ...

    @property
    def verdict(self) -> tuple[str, ...]:
        """The sentences among `lines` that are needed first, warnings included."""
        ...

    @property
    def lines(self) -> tuple[str, ...]:
        """Sentences and numbers for people, the answer first."""
        ...

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of that scenario beyond those that the comparison with the limits states; `lines` ends with them."""
        ...

    @property
    def limits(self) -> tuple[LimitsSource, ...]:
        """Further limits that were given, which hold for everything that is written of the result too."""
        ...

    def to_dict(self) -> dict[str, Any]:
        """Return everything as nested tables with numbers in SI."""
        ...
