"""The circuit of a scenario: amplifier, layers, finger and body."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from electrovib.core.units import format_quantity
from electrovib.export.spice.drive import drive_sources
from electrovib.export.spice.ladder import LayerElements
from electrovib.export.spice.start import Start
from electrovib.export.spice.text import Names, number, remark
from electrovib.solve.stack.expand import Surroundings, reductions
from electrovib.solve.stack.modes import merged_terms
from electrovib.solve.stack.prony import Reduction

if TYPE_CHECKING:
    from electrovib.export.spice.timing import Timing
    from electrovib.scenario import Scenario


@dataclass(kw_only=True)
class BuiltCircuit:
    """The circuit from the amplifier through finger and body to ground, with the elements of the netlist in blocks."""

    scenario: Scenario
    start: Start
    reductions: dict[str, Reduction]
    slabs: dict[str, LayerElements] = field(default_factory=dict)
    all_slabs: list[LayerElements] = field(default_factory=list)
    nodes: list[str] = field(default_factory=lambda: ["drive"])
    blocks: list[list[str]] = field(default_factory=list)
    names: Names = field(default_factory=lambda: Names({"amplitude", "body"}))

    @classmethod
    def of(cls, scenario: Scenario) -> BuiltCircuit:
        """Build the circuit of a scenario."""
        found = reductions(scenario)
        debye = {name: reduction.debye for name, reduction in found.items()}
        built = cls(scenario=scenario, start=Start.of(scenario, debye), reductions=found)
        built._amplifier()
        built._first_contact()
        built._return_path()
        return built

    def sources(self, timing: Timing) -> list[str]:
        """Return the sources of the drive."""
        return drive_sources(self.scenario.drive, timing)

    def _amplifier(self) -> None:
        resistance = self.scenario.circuit.source_resistance
        lines = [remark(f"amplifier: ammeter, resistance {format_quantity(resistance, 'ohm', digits=6)}")]
        if resistance > 0:
            lines += ["V_current drive output DC 0", f"R_source output plate {number(resistance)}"]
            self.nodes.append("output")
        else:
            lines.append("V_current drive plate DC 0")
        self.nodes.append("plate")
        self.blocks.append(lines)

    def _first_contact(self) -> None:
        layers, back = [*self.scenario.stack.layers], self.scenario.circuit.return_path.element()
        around = Surroundings.of(self.scenario)
        ends_here = not (around.second or back.resistance or back.elastance)
        for name in layers:
            field = self.start.level(self.start.field(name)) + self.start.fields[name]
            last = "0" if ends_here else "finger"
            after = last if name == layers[-1] else self.names.new(f"after_{name}")
            slab = self._slab(name, name, (self.nodes[-1], after), around.area, field, 1.0)
            self.slabs[name] = slab
            self.blocks.append(slab.elements())
            self._reach(*(branch.node for branch in slab.branches), after)

    def _return_path(self) -> None:
        around, path = Surroundings.of(self.scenario), self.scenario.circuit.return_path
        back = path.element()
        self.blocks.append([remark(f"return path: {type(path).__name__}")])
        if back.resistance > 0:
            after = "back" if around.second or back.elastance else "0"
            self.blocks[-1].append(f"R_return {self.nodes[-1]} {after} {number(back.resistance)}")
            self._reach(after)
        if around.second:
            self._second_contact(around, last="body" if back.elastance else "0")
        if back.elastance > 0:
            start, node = self.start.body_voltage(), self.nodes[-1]
            lines = [f"C_body {node} 0 {number(1 / back.elastance)}{f' IC={number(start)}' if start else ''}"]
            if back.rate > 0:
                lines.append(f"R_body_leak {node} 0 {number(back.elastance / back.rate)}")
            self.blocks[-1] += lines

    def _second_contact(self, around: Surroundings, *, last: str) -> None:
        """Add a second contact with the same layers in reverse order, whose fields point away from the finger."""
        layers = [*self.scenario.stack.layers]
        for name in reversed(layers):
            forced = around.second * self.start.level(self.start.field(name))
            field = -(forced + self.start.second_fields[name])
            after = last if name == layers[0] else self.names.new(f"second_before_{name}")
            area = around.area / around.second
            slab = self._slab(name, f"second_{name}", (after, self.nodes[-1]), area, field, -around.second)
            self.blocks.append(slab.elements())
            self._reach(*(branch.node for branch in slab.branches), after)

    def _slab(
        self, path: str, name: str, ends: tuple[str, str], area: float, field: float, share: float
    ) -> LayerElements:
        layer, reduction = self.scenario.stack.layers[path], self.reductions[path]
        rates, _ = merged_terms(reduction.debye)
        relaxed = tuple(share * value for value in self.start.lowpassed(self.start.field(path), rates))
        slab = LayerElements(
            path=path,
            name=self.names.new(name),
            plate_side=ends[0],
            finger_side=ends[1],
            layer=layer,
            reduction=reduction,
            area=area,
            field=field,
            relaxed=relaxed,
        )
        self.all_slabs.append(slab)
        return slab

    def _reach(self, *nodes: str) -> None:
        """Add nodes; the next element begins at the last one."""
        self.nodes += [node for node in nodes if node != "0"]
