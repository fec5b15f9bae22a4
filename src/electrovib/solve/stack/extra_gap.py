"""Field in an additional gap in series with the layers, for laws whose gap is not uniform."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.stack.modes import stack_modes
from electrovib.solve.stack.section import ModalSection, PhasorSection
from electrovib.solve.stack.slab import Slab
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex
    from electrovib.physics.stack import Linear, Section

IDLE = 1e-12
"""Gain below which a mode of the stack's voltage is rounding [V per volt of the drive]."""


def field_in_gap(section: Section, *, thickness: float, conductivity: float = 0.0) -> Linear:
    """Return the field in a gap in series with all layers, under the voltage of the stack.

    E = V/(u + h eps_u), with the thickness u, h = sum T/eps* over the layers and eps_u = 1 + conductivity/(s
    eps0). V is the voltage across the layers without the gap, the same at every place: the area with this gap
    is assumed too small to change it.
    """
    if isinstance(section, ModalSection):
        return _modal(section, thickness, conductivity)
    assert isinstance(section, PhasorSection)
    return _phasor(section, thickness, conductivity)


def _phasor(section: PhasorSection, thickness: float, conductivity: float) -> Complex:
    layers = section.layers.values()
    parts = [layer.thickness / layer.material.complex_permittivity(section.frequency) for layer in layers]
    leaking = 1 + conductivity / (2j * np.pi * section.frequency * eps0)
    field: Complex = section.voltage / (thickness + np.sum(parts, axis=0) * leaking)
    return field


def _modal(section: ModalSection, thickness: float, conductivity: float) -> Transfer:
    if any(np.any(layer.field.free) for layer in section.layers.values()):
        raise InputError(
            "stack: initial_charge is not supported with gaps that differ from place to place. Declare one layer 'gap' and a"
            " law that reads it, for instance force.model = MaxwellStressInGap, or remove the charge"
        )
    slabs = [
        Slab(layer.thickness, section.debye[name], layer.material.conductivity)
        for name, layer in section.layers.items()
    ]
    slabs.append(Slab(thickness, DebyeSum(1.0, (), ()), conductivity))
    field = stack_modes(slabs, area=1.0, element=SeriesElement()).fields[-1]
    return _busy(section.voltage) * _busy(field)


def _busy(transfer: Transfer) -> Transfer:
    """Omit modes that the drive does not excite, because a product divides by the distance between rates."""
    scale = abs(transfer.direct) + float(np.sum(np.abs(transfer.gains)))
    kept = (np.abs(transfer.gains) > IDLE * scale) & (transfer.rates > 0)
    return Transfer(rates=transfer.rates[kept], gains=transfer.gains[kept], direct=transfer.direct)
