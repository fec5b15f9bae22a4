"""The section of a netlist, and the readings of it that are linear in the drive, from which a force law is computed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from electrovib.exports.spice.ladder import LayerElements, between
from electrovib.exports.spice.text import continued, number, remark
from electrovib.physics.stack import beside_interface
from electrovib.solve.stack.section import StackLayer, inverse_root_thickness

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from electrovib.exports.spice.circuit import Start
    from electrovib.physics.stack import Role
    from electrovib.solve.stack.transfer import Transfer


PRECISION = 1e-9
"""Relative error of the filter of the square root, far below that of the time steps."""
CAPACITANCE = 1e-9
"""Capacitance of the sections of the filter [F]; the resistance follows from the rate, so any value gives the same filter."""


ENDLESS = 1e18
"""Resistance in parallel with an integrating capacitor [ohm], because ngspice needs a path for direct current."""


@dataclass(kw_only=True)
class ReadSection:
    """The stack of the first contact, from plate to finger, as readings of the circuit, to which filters are added."""

    slabs: dict[str, LayerElements]
    roles: Mapping[str, Role]
    start: Start
    area: float
    elements: list[str] = field(default_factory=list)
    filters: int = 0
    _interface: MeterReading | None = None

    @property
    def frequency(self) -> np.ndarray:
        """Refuse: a circuit has no single frequency."""
        raise TypeError("a circuit has no single frequency")

    @property
    def names(self) -> Sequence[str]:
        """Layers from the plate to the finger."""
        return tuple(self.slabs)

    def __getitem__(self, name: str) -> StackLayer:
        """Return the state of a layer; its displacement is the charge on its capacitors over the area."""
        slab = self.slabs[name]
        thickness, area = slab.layer.thickness, slab.area
        charge = {slab.voltage: slab.high / area}
        charge |= {
            between(branch.node, slab.finger_side): branch.capacitance / area for branch in slab.branches
        }
        return StackLayer(
            thickness=thickness,
            material=slab.layer.material,
            field=MeterReading({slab.voltage: 1 / thickness}, self.start.field(name)),
            displacement=MeterReading(charge, self.start.displacement(name)),
        )

    @property
    def voltage(self) -> MeterReading:
        """Voltage across all layers."""
        ends = [*self.slabs.values()]
        transfer = None if self.start.section is None else self.start.section.voltage
        return MeterReading({between(ends[0].plate_side, ends[-1].finger_side): 1.0}, transfer)

    @property
    def current_density(self) -> MeterReading:
        """Total current density."""
        return MeterReading({"I(V_current)": 1 / self.area}, self.start.current_density())

    @property
    def interface_displacement(self) -> MeterReading:
        """Displacement at the interface of plate and finger, for a stack without a gap.

        It is the charge on the last layer of the plate if that does not conduct, else the integral of the
        current, on a separate capacitor.
        """
        last = beside_interface(self.roles, "plate")
        charged = any(slab.layer.initial_charge for slab in self.slabs.values())
        if last is not None and not charged and self._blocks(last):
            on_last: MeterReading = self[last].displacement
            return on_last
        if self._interface is None:
            charge = self.start.interface_charge()
            held = f" IC={number(charge * self.area / CAPACITANCE)}" if charge else ""
            self.elements += [
                remark("charge at the interface: V(interface) times 1 nF is the integral of the current"),
                "F_interface 0 interface V_current 1",
                f"C_interface interface 0 {number(CAPACITANCE)}{held}",
                f"R_interface interface 0 {number(ENDLESS)}",
            ]
            section = self.start.section
            transfer = None if section is None else section.interface_displacement
            self._interface = MeterReading({"V(interface)": CAPACITANCE / self.area}, transfer)
        return self._interface

    def _blocks(self, name: str) -> bool:
        layer = self.slabs[name].layer
        return layer.leak is None and layer.material.conductivity == 0

    def inverse_root_thickness(self, names: Sequence[str]) -> FilterToBuild:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2] as a filter."""
        slabs = [(self.slabs[name].layer.thickness, self.slabs[name].reduction.debye) for name in names]
        section = self.start.section
        avoid = None if section is None else section.modes.rates
        return FilterToBuild(inverse_root_thickness(slabs, avoid=avoid, tolerance=PRECISION), self._filtered)

    def _filtered(self, transfer: Transfer, signal: MeterReading) -> MeterReading:
        """Add a filter after a reading: first-order sections in parallel, and the signal itself."""
        if not len(transfer.rates):
            return signal * float(transfer.direct)
        self.filters += 1
        name = f"filter_{self.filters}"
        said = f"square root of the layers' capacitance: {len(transfer.rates)} first-order sections, to {PRECISION:g}"
        self.elements.append(remark(said))
        self.elements.append(continued(f"B{name} {name} 0 V = {signal.text}"))
        weights = {f"V({name})": transfer.direct}
        starts = self.start.lowpassed(signal.transfer, transfer.rates)
        for count, (rate, gain, start) in enumerate(
            zip(transfer.rates, transfer.gains, starts, strict=True), 1
        ):
            node = f"{name}_{count}"
            initial = f" IC={number(start)}" if start else ""
            self.elements += [
                f"R{node} {name} {node} {number(1 / (rate * CAPACITANCE))}",
                f"C{node} {node} 0 {number(CAPACITANCE)}{initial}",
            ]
            weights[f"V({node})"] = float(gain)
        modes = None if signal.transfer is None else transfer * signal.transfer
        return MeterReading(weights, modes)


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
