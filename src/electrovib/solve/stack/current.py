"""Modes of a stack under a prescribed current.

With a given current, the field of a layer is E_k = z_k J/T_k: the poles are those of each layer and not the
zeros of their sum, and it is independent of the other layers. A layer that does not conduct is an integrator.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.stack.modes import StackModes
from electrovib.solve.stack.section import ModalSection, PhasorLayer, PhasorSection, section_of, slabs_of
from electrovib.solve.stack.slab import bound_residues, slab_impedance
from electrovib.solve.stack.transfer import INTEGRATING, Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.physics.stack import Layer


def per_ampere(section: PhasorSection, *, area: float) -> PhasorSection:
    """Return the stack at given frequencies per ampere of the drive."""
    volts = 1 / (section.current_density * area)
    states = {
        name: PhasorLayer(state.thickness, state.material, state.field * volts, state.displacement * volts)
        for name, state in section.layers.items()
    }
    density = np.full(np.shape(section.frequency), 1 / area, complex)
    return PhasorSection(section.frequency, states, section.roles, section.voltage * volts, density)


def current_section(layers: dict[str, Layer], debye: dict[str, DebyeSum], *, area: float) -> ModalSection:
    """Expand the stack in the modes of its layers, per ampere of the drive.

    E_k T_k = z_k (J + Q_k), with Q_k the free charge at time 0 on the interfaces on the plate's side of layer
    k. The plate itself carries only the charge delivered by the current.
    """
    slabs = slabs_of(layers, debye)
    expanded = [slab_impedance(slab) for slab in slabs]
    nodes = np.unique(np.concatenate([rates for rates, _ in expanded]))
    rates = np.append(np.where(nodes == 0, INTEGRATING, nodes), 0.0)  # the last: trapped charge
    held = np.concatenate([[0.0], np.cumsum([slab.charge for slab in slabs])[:-1]])
    fields, displacements = [], []
    for slab, (own, residues), charge in zip(slabs, expanded, held.tolist(), strict=True):
        places = np.searchsorted(nodes, own)
        field = _spread(places, residues / slab.thickness, len(nodes))
        displacement = _spread(places, bound_residues(slab, own, residues), len(nodes))
        fields.append(_answer(rates, field / area, field * charge))
        displacements.append(_answer(rates, displacement / area, displacement * charge))
    current = Transfer(rates=rates, gains=np.zeros(len(rates)), direct=1 / area)
    before = np.append(held, held[-1])  # the last layer carries no charge towards the finger
    modes = StackModes(rates, tuple(fields), tuple(displacements), current, len(nodes), before)
    return section_of(layers, debye, modes)


def _spread(places: Indices, values: Real, count: int) -> Real:
    found = np.zeros(count)
    found[places] = values
    return found


def _answer(rates: Real, residues: Real, free: Real) -> Transfer:
    """Return sum residue/(s + rate); the free part at a rate of 0 is constant."""
    integrates = rates[:-1] == INTEGRATING
    gains = np.append(residues / rates[:-1], 0.0)
    fading = np.append(np.where(integrates, 0.0, free), float(np.sum(free[integrates])))
    return Transfer(rates=rates, gains=gains, direct=0.0, slope=0.0, free=fading)
