"""Readings of the circuit that are linear in the drive, from which a force law is computed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.exports.spice.text import number

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.solve.stack.transfer import Transfer


@dataclass(frozen=True, eq=False)
class MeterReading:
    """A weighted sum of voltages and currents of the circuit; `transfer` is the same quantity in modes, if needed."""

    weights: Mapping[str, float]
    transfer: Transfer | None = None

    __array_ufunc__ = None  # so that a numpy number on the left uses __rmul__

    @property
    def text(self) -> str:
        """The sum in the syntax of ngspice."""
        terms = [name if weight == 1 else f"{number(weight)}*{name}" for name, weight in self.weights.items()]
        return " + ".join(terms).replace("+ -", "- ") or "0"

    def __add__(self, other: MeterReading) -> MeterReading:
        weights = dict(self.weights)
        for name, weight in other.weights.items():
            weights[name] = weights.get(name, 0.0) + weight
        known = self.transfer is not None and other.transfer is not None
        return MeterReading(weights, self.transfer + other.transfer if known else None)  # type: ignore[operator]

    def __sub__(self, other: MeterReading) -> MeterReading:
        return self + other * -1.0

    def __mul__(self, other: float | FilterToBuild) -> MeterReading:
        """Scale or filter."""
        if isinstance(other, FilterToBuild):
            return other.through(self)
        factor = float(other)
        weights = {name: weight * factor for name, weight in self.weights.items()}
        return MeterReading(weights, None if self.transfer is None else self.transfer * factor)

    __rmul__ = __mul__

    def __truediv__(self, other: float) -> MeterReading:
        return self * (1 / float(other))


@dataclass(frozen=True, eq=False)
class FilterToBuild:
    """A filter with real poles and no free part, which `build` adds to the circuit after a reading."""

    transfer: Transfer
    build: Callable[[Transfer, MeterReading], MeterReading]

    __array_ufunc__ = None

    def through(self, signal: MeterReading) -> MeterReading:
        """Return the reading of the output for a reading of the input."""
        return self.build(self.transfer, signal)

    def __mul__(self, other: MeterReading | float) -> MeterReading | FilterToBuild:
        """Filter a reading, or scale the filter."""
        if isinstance(other, MeterReading):
            return self.through(other)
        return FilterToBuild(self.transfer * float(other), self.build)

    __rmul__ = __mul__
