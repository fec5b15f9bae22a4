"""The stack of a scenario over frequency, and as relaxation modes under a voltage or a prescribed current.

With a given current, the field of a layer is E_k = z_k J/T_k: the poles are those of each layer and not the zeros of their
sum, and it is independent of the other layers. A layer that does not conduct is an integrator.

Materials are reduced to Debye terms over the band that follows from the duration of a run and from its shortest event.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.arrays import Complex, Real
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.drive.parts import Tones
from electrovib.physics.material.tabulated import FEWEST
from electrovib.physics.stack import Layer, interface_place, roles_of
from electrovib.scenario import Scenario
from electrovib.solve.stack.harmonics import spectrum
from electrovib.solve.stack.modes import StackModes, bound_residues, slab_impedance, slots, spread
from electrovib.solve.stack.prony import DENSE, Reduction, fit_debye, fit_debye_table
from electrovib.solve.stack.section import (
    ModalSection,
    PhasorSection,
    modal_section,
    phasor_section,
    section_of,
    section_of_voltages,
    slabs_of,
)
from electrovib.solve.stack.transfer import INTEGRATING, Column, Transfer, row_of, side_by_side

if TYPE_CHECKING:
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.physics.drive.parts import Part
    from electrovib.physics.material import Material


@dataclass(frozen=True)
class Surroundings:
    """Contact area, series element and second contact of a scenario, which the sections need besides the layers."""

    area: float
    element: SeriesElement
    second: float

    @classmethod
    def of(cls, scenario: Scenario, area: Any = None) -> Surroundings:
        """Return those of a scenario, with other contact areas [m2] if given."""
        area = scenario.contact_area if area is None else area
        second = scenario.circuit.return_path.second_contact(area)
        return cls(area, scenario.circuit.element(), second)


def phasors(scenario: Scenario, frequency: Real, *, leaks: bool = True) -> PhasorSection:
    """Return the scenario's stack over frequency, exact for the materials as declared.

    `frequency` (n,) [Hz].
    """
    section = per_volt_of(scenario, frequency, leaks=leaks)
    area = scenario.contact_area
    return per_ampere(section, area=area) if scenario.drive.quantity == "current" else section


def per_volt_of(
    scenario: Scenario, frequency: Real, *, leaks: bool = True, area: Real | None = None
) -> PhasorSection:
    """Return the scenario's stack over frequency per volt, also where the drive prescribes the current.

    With an `area` [m2] for each of some contacts, instead of that of the scenario, one frequency gives as many values.
    """
    around, layers = Surroundings.of(scenario, area), scenario.stack.layers
    return phasor_section(linearised(layers) if leaks else layers, frequency=frequency, **vars(around))


def linearised(layers: Mapping[str, Layer]) -> dict[str, Layer]:
    """Return layers with every leak replaced by its conductivity at vanishing amplitude."""
    found = {}
    for name, layer in layers.items():
        found[name] = layer
        if layer.leak is not None:
            conductivity = layer.material.conductivity + layer.leak.small_signal
            material = layer.material.conducting(conductivity)
            found[name] = layer.model_copy(update={"material": material, "leak": None})
    return found


def left_by_charge(scenario: Scenario, frequency: Real, charges: Real) -> PhasorSection:
    """Return the response to initial charge as Laplace transforms at j w, exact for the materials as declared.

    `frequency` (n,) [Hz], `charges` (layers + 1,) [C/m2].

    E_k T_k = z_k (Q_k + J), J = -(sum z_j Q_j)/Z over all parts of the circuit, the body's capacitor among them;
    J = 0 under a prescribed current.
    """
    around, layers = Surroundings.of(scenario), scenario.stack.layers
    drops = {name: layer.impedance(frequency) for name, layer in layers.items()}
    held = dict(zip(layers, charges, strict=False))
    current: Complex = np.zeros(len(frequency), complex)
    if scenario.drive.quantity == "voltage":
        element = around.element
        stack = np.sum(list(drops.values()), axis=0) * (1 + around.second)
        body = around.area * element.elastance / (2j * np.pi * frequency + element.rate)
        driving = np.sum([drops[name] * held[name] for name in layers], axis=0)
        driving = driving + body * (charges[-1] + element.charge / around.area)
        current = -driving / (stack + around.area * element.impedance(frequency))
    voltages = {name: drop * (held[name] + current) for name, drop in drops.items()}
    start = float(charges[interface_place(roles_of(layers).values())])
    return section_of_voltages(layers, frequency, voltages, current, start)


def behind_amplifier(scenario: Scenario, section: PhasorSection) -> PhasorSection:
    """Return a section per volt of the drive from one per volt of the plate."""
    amplifier = scenario.circuit.amplifier
    if amplifier is None:
        return section
    pole = 1.0 if amplifier.bandwidth is None else 1 + 1j * section.frequency / amplifier.bandwidth
    return section.times(amplifier.gain / pole)


def reductions(scenario: Scenario, times: Real | None = None) -> dict[str, Reduction]:
    """Return the bound permittivity of every layer as Debye terms, over the band that a run needs.

    `times` (n,) [s].
    """
    materials = {name: layer.material for name, layer in scenario.stack.layers.items()}
    low, high = LOWEST, HIGHEST
    if any(each.debye() is None for each in materials.values()):  # a Debye sum does not depend on the band
        low, high = run_band(scenario, scenario.time.times(scenario.drive) if times is None else times)
    return {name: reduce_material(each, low=low, high=high) for name, each in materials.items()}


def modes(scenario: Scenario, times: Real | None = None) -> tuple[ModalSection, float]:
    """Return the stack without leaks as modes per unit of the drive, and the largest error of a bound permittivity."""
    found = reductions(scenario, times)
    debye = {name: reduction.debye for name, reduction in found.items()}
    return modes_of(scenario, debye), max(reduction.largest_error for reduction in found.values())


def modes_of(scenario: Scenario, debye: dict[str, DebyeSum]) -> ModalSection:
    """Return the stack without leaks as modes per unit of the drive, for given relaxations of its layers.

    A number of the scenario, or of the relaxations, may be a column with one value for each case.
    """
    around, layers = Surroundings.of(scenario), scenario.stack.layers
    if scenario.drive.quantity == "current":
        return current_section(layers, debye, area=around.area)
    return modal_section(layers, debye, **vars(around))


def per_ampere(section: PhasorSection, *, area: Column) -> PhasorSection:
    """Return the stack at given frequencies per ampere of the drive."""
    return section.times(1 / (section.current_density * area))


def current_section(layers: dict[str, Layer], debye: dict[str, DebyeSum], *, area: Column) -> ModalSection:
    """Expand the stack in the modes of its layers, per ampere of the drive.

    E_k T_k = z_k (J + Q_k), with Q_k the free charge at time 0 on the interfaces on the plate's side of layer
    k. The plate itself carries only the charge delivered by the current.
    """
    slabs = slabs_of(layers, debye)
    expanded = [slab_impedance(slab) for slab in slabs]
    nodes, places = slots([rates for rates, _ in expanded])
    rates = side_by_side(np.where(nodes == 0, INTEGRATING, nodes), np.zeros(1))  # the last: trapped charge
    held = np.cumsum(side_by_side(np.zeros(1), *(row_of(slab.charge) for slab in slabs)), axis=-1)
    fields: list[Transfer] = []
    displacements: list[Transfer] = []
    for index, (slab, each, mine) in enumerate(zip(slabs, expanded, places, strict=True)):
        charge = held[..., index : index + 1]
        for found, residues in (
            (fields, each[1] / slab.thickness),
            (displacements, bound_residues(slab, *each)),
        ):
            spread_out = spread(residues, mine, nodes.shape[-1])
            found.append(_answer(rates, spread_out / area, spread_out * charge))
    current = Transfer(rates=rates, gains=np.zeros(rates.shape[-1]), direct=1 / area)
    modes = StackModes(rates, tuple(fields), tuple(displacements), current, nodes.shape[-1], held)
    return section_of(layers, debye, modes)


def _answer(rates: Real, residues: Real, free: Real) -> Transfer:
    """Return sum residue/(s + rate); the free part at a rate of 0 is constant."""
    integrates = rates[..., :-1] == INTEGRATING
    gains = side_by_side(residues / rates[..., :-1], np.zeros(1))
    constant = np.where(integrates, free, 0.0).sum(axis=-1, keepdims=True)
    fading = side_by_side(np.where(integrates, 0.0, free), constant)
    return Transfer(rates=rates, gains=gains, free=fading)


LOWEST, HIGHEST = 1.0, 1e6
"""Smallest band of a reduction [Hz]."""
TERMS_PER_DECADE = 3
"""Relaxations for each decade of the band: an error of some 1e-5 for laws that are not sums of Debye terms."""
FEWEST_TERMS = 14
STEPS_PER_DECADE = 2
"""Ends of a band lie at whole 1/STEPS_PER_DECADE decades, so that runs that differ little share their reductions."""
MARGIN = 10.0
"""Factor by which the band extends beyond 1/(2 pi time): a relaxation of a time t acts on all times around t."""
SAME = 1e-12
"""Relative difference of two times or frequencies that counts as rounding: such a time is at a corner, not after it."""
ABSENT = 1e-9
"""Share of the largest amplitude below which a frequency is not part of a drive."""


def reduction_band(*, low: float, high: float) -> tuple[float, float]:
    """Return a band widened to at least `LOWEST` to `HIGHEST`, and outwards to half decades."""
    lowest, highest = math.log10(min(low, LOWEST)), math.log10(max(high, HIGHEST))
    slack = 1e-9  # the logarithm of a whole decade may miss it by rounding
    first, last = (
        math.floor(STEPS_PER_DECADE * lowest + slack) / STEPS_PER_DECADE,
        math.ceil(STEPS_PER_DECADE * highest - slack) / STEPS_PER_DECADE,
    )
    return float(10.0**first), float(10.0**last)


def reduce_material(material: Material, *, low: float = LOWEST, high: float = HIGHEST) -> Reduction:
    """Return the Debye terms of a material."""
    exact = material.debye()
    if exact is not None:
        return Reduction(exact, 0.0)
    return _reduced(material, *reduction_band(low=low, high=high))


@functools.lru_cache(maxsize=256)
def _reduced(material: Material, low: float, high: float) -> Reduction:
    rows, slowest = material.table(), material.slowest_relaxation
    if rows is None:
        count = min(DENSE, math.ceil(TERMS_PER_DECADE * math.log10(high / low)) + 2)
        return fit_debye(material.bound_permittivity, low=low, high=high, terms=count, slowest=slowest)
    near = (rows[0] >= low) & (rows[0] <= high)
    wanted = near if np.count_nonzero(near) >= FEWEST else np.ones_like(near)
    return fit_debye_table(*(row[wanted] for row in rows), terms=FEWEST_TERMS, slowest=slowest)


def band_of_run(scenario: Scenario, times: Real) -> tuple[float, float]:
    """Return the band over which the materials of a run are reduced [Hz]; runs that differ little share it."""
    low, high = run_band(scenario, times)
    return reduction_band(low=low, high=high)


def run_band(scenario: Scenario, times: Real) -> tuple[float, float]:
    """Return the band of frequencies that the response of a run depends on.

    `times` (n,) [s].

    From rest the lowest is a tenth of 1/(2 pi t) of the last output time t; in the periodic state a tenth of the
    lowest frequency of the drive. The highest is ten times 1/(2 pi t) of the shortest straight piece and of the
    shortest time between a corner and the next output, and ten times the highest frequency of a sine.
    """
    parts, grid = scenario.drive.parts(), scenario.frequency
    fastest = [scenario.drive.highest_frequency]
    shortest = shortest_time(scenario, times)
    if math.isfinite(shortest):
        fastest.append(1 / (2 * np.pi * shortest))
    if scenario.time.settled:
        slowest = [found for part in parts for found in _slowest(part)]
    else:
        slowest = [1 / (2 * np.pi * float(times[-1]))] if times[-1] > 0 else []
    return (
        min([grid.low, *(frequency / MARGIN for frequency in slowest)]),
        max([grid.high, *(frequency * MARGIN for frequency in fastest)]),
    )


def shortest_time(scenario: Scenario, times: Real) -> float:
    """Return the duration of the shortest straight piece of the drive, or of a corner to the next output if shorter.

    `times` (n,) [s].
    """
    end, drive = float(times[-1]), scenario.drive
    if any(part.begins_with(times) for part in drive.parts()):
        return drive.shortest_piece(end)  # every output is at a corner
    begins = [] if scenario.time.settled else [0.0]
    corners = np.concatenate([[-math.inf], begins, drive.corners(end)[0]])
    if len(corners) == 1:
        return drive.shortest_piece(end)
    first = np.searchsorted(times, corners[1:] * (1 + SAME))
    near = times[np.unique([first, first + 1]).clip(0, len(times) - 1)]  # the first after each corner
    since = near - corners[np.searchsorted(corners, near * (1 + SAME), side="right") - 1]
    after = since[since > SAME * near]
    return min(drive.shortest_piece(end), float(np.min(after, initial=math.inf)))


def lowest_frequency(scenario: Scenario) -> float:
    """Return the lowest frequency of a periodic drive [Hz]; its mean, 0, counts only if a measured layer does not conduct."""
    materials = [layer.material for layer in scenario.stack.layers.values()]
    blocked = any(math.isfinite(each.band[1]) and each.conductivity == 0 for each in materials)
    frequencies, amplitudes = spectrum(scenario.drive, harmonics=1)
    sizes = np.abs(amplitudes)
    there = (sizes > ABSENT * np.max(sizes, initial=0.0)) & (blocked | (frequencies > 0))
    return float(np.min(frequencies[there], initial=math.inf))


def _slowest(part: Part) -> list[float]:
    if isinstance(part, Tones):
        moving = part.frequencies[(part.frequencies > 0) & (part.amplitudes != 0)]
        return [float(np.min(moving))] if len(moving) else []
    return [1 / part.period] if part.period else []
