"""Linear response of a stack without leaks to a leakage current in parallel with one of its layers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.stack.integrator import INTEGRATING
from electrovib.solve.stack.modes import StackModes
from electrovib.solve.stack.section import ModalSection, section_of, slabs_of
from electrovib.solve.stack.slab import bound_residues, slab_impedance
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.stack import Layer


def leak_section(
    section: ModalSection, layers: dict[str, Layer], name: str, *, area: float, element: SeriesElement
) -> ModalSection:
    """Expand the response of a stack under voltage drive to a leak in parallel with one of its layers in modes.

    E_j T_j = z_j z_k/Z - [j = k] z_k for a leak in parallel with layer k. The poles are the zeros of Z and
    the nodes that several parts share; a pole at 0 is an interface that the leak charges. The response of
    layer k itself has residues of one sign: it is minus the impedance of layer k in parallel with all the
    others.
    """
    modes, place = section.modes, list(layers).index(name)
    driven, shared = modes.rates[: modes.driven], modes.rates[modes.driven :]
    rates = np.where(modes.rates == 0, INTEGRATING, modes.rates)
    into = _residues(modes.fields[place], driven) * layers[name].thickness  # of z_k/Z
    drops = into / _residues(modes.current_density, driven)  # z_k where Z is 0
    slabs = slabs_of(layers, section.debye)
    expanded = [slab_impedance(slab) for slab in slabs]
    own = np.array([_at(shared, *each) for each in expanded])
    others = np.delete(own, place, axis=0).sum(axis=0) + area * element.elastance * (shared == element.rate)
    fields, displacements = [], []
    for j, (slab, (nodes, residues)) in enumerate(zip(slabs, expanded, strict=True)):
        share = (-others if j == place else own[place]) / (own[place] + others)
        field = np.append(_residues(modes.fields[j], driven) * drops, own[j] * share / slab.thickness)
        fields.append(Transfer(rates=rates, gains=field / rates))
        bound = _at(shared, nodes, bound_residues(slab, nodes, residues)) * share
        displacement = np.append(_residues(modes.displacements[j], driven) * drops, bound)
        displacements.append(Transfer(rates=rates, gains=displacement / rates))
    sums = [float(np.sum(residues)) for _, residues in expanded]
    at_once = sums[place] / (sum(sums) + area * element.elastance) if element.resistance == 0 else 0.0
    current = Transfer(rates=rates, gains=np.append(into, 0 * shared) / rates, direct=at_once)
    nothing = np.zeros(len(slabs) + 1)
    answer = StackModes(rates, tuple(fields), tuple(displacements), current, modes.driven, nothing)
    return section_of(layers, section.debye, answer)


def _residues(transfer: Transfer, driven: Real) -> Real:
    return transfer.gains[: len(driven)] * driven


def _at(nodes: Real, rates: Real, residues: Real) -> Real:
    """Return the residues of a layer at some nodes, 0 where it has none."""
    return np.array([float(np.sum(residues[rates == node])) for node in nodes.tolist()])


def leak_alone(section: ModalSection, layers: dict[str, Layer], name: str, *, area: float) -> ModalSection:
    """Expand the response of a stack under current drive to a leak in parallel with one of its layers in modes."""
    modes, rates = section.modes, section.modes.rates
    nothing = Transfer(rates=rates, gains=np.zeros(len(rates)))
    fields, displacements = [], []
    for other, field, displacement in zip(layers, modes.fields, modes.displacements, strict=True):
        fields.append(Transfer(rates=rates, gains=-area * field.gains) if other == name else nothing)
        displacements.append(
            Transfer(rates=rates, gains=-area * displacement.gains) if other == name else nothing
        )
    charges = np.zeros(len(layers) + 1)
    answer = StackModes(rates, tuple(fields), tuple(displacements), nothing, modes.driven, charges)
    return section_of(layers, section.debye, answer)
