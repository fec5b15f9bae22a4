"""Current drive: every layer answers on its own, and one that does not conduct integrates.

With the current given, the field of a layer is E_k = z_k J/T_k: the poles are those of the layers and not the
zeros of their sum, and no other layer has a say in it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.lamps import Lamp
from electrovib.core.units import format_quantity
from electrovib.physics.drive.parts import Linear, Tones
from electrovib.solve.modes import StackModes, bound_residues, slab_impedance
from electrovib.solve.section import ModalSection, PhasorLayer, PhasorSection, section_of, slabs_of
from electrovib.solve.transfer import Transfer
from electrovib.solve.transient import transient

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.drive.parts import Indices, Part
    from electrovib.physics.stack import Layer
    from electrovib.solve.transfer import Real

INTEGRATING = 1e-30
"""Rate that stands for an integrator [1/s]: what it forgets in 1e5 s is nothing that 53 bits could hold."""
REASON = "linear layers, fixed gap and a current drive: every layer's own modes, blocking layers integrate"
_NO_MEAN = 1e-12
"""Mean current over the largest, below which it is rounding."""


def per_ampere(section: PhasorSection, *, area: float) -> PhasorSection:
    """Give the stack at given frequencies per ampere of the drive.

    Parameters
    ----------
    section : PhasorSection
        Per volt of the drive.
    area : float
        Contact area [m2].

    Returns
    -------
    PhasorSection
        Fields V/m, displacements C/m2 and stack voltage V, each per ampere.
    """
    volts = 1 / (section.current_density * area)
    states = {
        name: PhasorLayer(state.thickness, state.material, state.field * volts, state.displacement * volts)
        for name, state in section.layers.items()
    }
    density = np.full(np.shape(section.frequency), 1 / area, complex)
    return PhasorSection(section.frequency, states, section.voltage * volts, density)


def current_section(layers: dict[str, Layer], debye: dict[str, DebyeSum], *, area: float) -> ModalSection:
    """Expand the stack in the modes of its layers, per ampere of the drive.

    Parameters
    ----------
    layers : dict of str to Layer
        From the plate to the finger.
    debye : dict of str to DebyeSum
        Their polarisations.
    area : float
        Contact area [m2].

    Returns
    -------
    ModalSection
        An integrator appears as a mode of the rate `INTEGRATING`.

    Notes
    -----
    E_k T_k = z_k (J + Q_k), Q_k the free charge put at time 0 on the interfaces on the plate's side of layer
    k. The plate itself carries only what the current has brought.
    """
    slabs = slabs_of(layers, debye)
    expanded = [slab_impedance(slab) for slab in slabs]
    nodes = np.unique(np.concatenate([rates for rates, _ in expanded]))
    rates = np.append(np.where(nodes == 0, INTEGRATING, nodes), 0.0)  # the last: charge that stays
    held = np.concatenate([[0.0], np.cumsum([slab.charge for slab in slabs])[:-1]])
    fields, displacements = [], []
    for slab, (own, residues), charge in zip(slabs, expanded, held.tolist(), strict=True):
        places = np.searchsorted(nodes, own)
        field = _spread(places, residues / slab.thickness, len(nodes))
        displacement = _spread(places, bound_residues(slab, own, residues), len(nodes))
        fields.append(_answer(rates, field / area, field * charge))
        displacements.append(_answer(rates, displacement / area, displacement * charge))
    current = Transfer(rates, np.zeros(len(rates)), 1 / area)
    modes = StackModes(rates, tuple(fields), tuple(displacements), current, len(nodes))
    return section_of(layers, debye, modes)


def _spread(places: Indices, values: Real, count: int) -> Real:
    found = np.zeros(count)
    found[places] = values
    return found


def _answer(rates: Real, residues: Real, free: Real) -> Transfer:
    """Give sum residue/(s + rate); what charge leaves at a rate of 0 stays for ever."""
    integrates = rates[:-1] == INTEGRATING
    gains = np.append(residues / rates[:-1], 0.0)
    fading = np.append(np.where(integrates, 0.0, free), float(np.sum(free[integrates])))
    return Transfer(rates, gains, 0.0, 0.0, fading)


def drive_voltage(
    stack_voltage: Real, drive: Drive, time: Real, *, element: SeriesElement, second: float, settled: bool
) -> Real:
    """Voltage that the amplifier has to give for its current.

    Parameters
    ----------
    stack_voltage : ndarray, shape (n,)
        Across the layers [V].
    drive : Drive
        A current [A].
    time : ndarray, shape (n,)
        s.
    element : SeriesElement
        Source and return path.
    second : float
        First contact area over that of a second, equal stack; 0 for none.
    settled : bool
        As for `current_response`.

    Returns
    -------
    ndarray, shape (n,)
        V.
    """
    rates, gains = np.zeros(0), np.zeros(0)
    if element.elastance > 0:
        rates = np.array([element.rate or INTEGRATING])
        gains = element.elastance / rates
    around = {"voltage": Transfer(rates, gains, element.resistance)}
    return stack_voltage * (1 + second) + current_response(around, drive, time, settled=settled)["voltage"]


def current_response(
    transfers: Mapping[str, Transfer], drive: Drive, time: Real, *, settled: bool = False
) -> dict[str, Real]:
    """Response of linear quantities to a current.

    Parameters
    ----------
    transfers : mapping of str to Transfer
        Per ampere; integrators as modes of the rate `INTEGRATING`.
    drive : Drive
        A current [A].
    time : ndarray, shape (n,)
        Increasing, >= 0 [s].
    settled : bool
        Start from the periodic state instead of rest.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        At a jump of the drive the value after it.

    Raises
    ------
    InputError
        If a settled current has a mean, which would have charged a blocking layer without end.

    Notes
    -----
    From rest an integrator is exact as one more slow mode. In the periodic state its charge is counted from
    its own mean over the period: a constant charge is not known from the drive.
    """
    if not settled:
        return transient(transfers, drive, time)
    found = transient(
        {name: _fading(transfer) for name, transfer in transfers.items()}, drive, time, settled=True
    )
    weights = {name: _integral(transfer) for name, transfer in transfers.items()}
    if any(weights.values()):
        charge = settled_charge(drive, time)
        found = {name: row + weights[name] * charge for name, row in found.items()}
    return found


def _fading(transfer: Transfer) -> Transfer:
    gains = np.where(transfer.rates == INTEGRATING, 0.0, transfer.gains)
    return Transfer(transfer.rates, gains, transfer.direct, transfer.slope, transfer.free)


def _integral(transfer: Transfer) -> float:
    return float(np.sum((transfer.gains * transfer.rates)[transfer.rates == INTEGRATING]))


def settled_charge(drive: Drive, time: Real) -> Real:
    """Charge that a repeating current has brought, counted from its mean over a period.

    Parameters
    ----------
    drive : Drive
        A current [A] made of sines and repeating straight pieces, with a mean of 0.
    time : ndarray, shape (n,)
        s.

    Returns
    -------
    ndarray, shape (n,)
        C.

    Raises
    ------
    InputError
        If the current has a mean.
    """
    parts = drive.parts()
    mean, largest = sum(_mean(part) for part in parts), sum(part.bound() for part in parts)
    if abs(mean) > _NO_MEAN * largest:
        raise InputError(
            f"time.initial_state = PeriodicState: the current has a mean of {format_quantity(mean, 'A')}, which has"
            " charged what does not conduct without end. Give it no mean, or start from rest: AtRest"
        )
    total: Real = np.sum([_charge(part, time) for part in parts], axis=0)
    return total


def _mean(part: Part) -> float:
    if isinstance(part, Tones):
        return float(np.sum(part.amplitudes[part.frequencies == 0].real))
    assert isinstance(part, Linear)
    if part.period is None:
        return float(part.after[0])
    return float(np.sum((part.after[:-1] + part.before[1:]) / 2 * np.diff(part.times))) / part.period


def _charge(part: Part, time: Real) -> Real:
    """Integral of a part without its mean, itself without mean."""
    if isinstance(part, Tones):
        moving = part.frequencies > 0
        angular = 2 * np.pi * part.frequencies[moving]
        waves = np.exp(1j * np.outer(angular, time)) / (1j * angular[:, None])
        charge: Real = (part.amplitudes[moving] @ waves).real
        return charge
    assert isinstance(part, Linear)
    if part.period is None:
        return np.zeros(len(time))
    return _straight_charge(part, part.period, time)


def _straight_charge(part: Linear, period: float, time: Real) -> Real:
    """Parabolas from break to break."""
    first, last = part.after[:-1] - _mean(part), part.before[1:] - _mean(part)
    steps = np.diff(part.times)
    slopes = (last - first) / steps
    begun = np.concatenate([[0.0], np.cumsum((first + last) / 2 * steps)[:-1]])
    mean = float(np.sum(begun * steps + first * steps**2 / 2 + slopes * steps**3 / 6)) / period
    index, elapsed = part.locate(time)
    index = np.minimum(index, len(steps) - 1)
    charge: Real = begun[index] + (first[index] + slopes[index] * elapsed / 2) * elapsed - mean
    return charge


def caveat() -> Lamp:
    """Say what a prescribed current does not tell."""
    text = (
        "the whole current of the drive is taken to cross this contact area: the force goes as 1/area, and what"
        " passes through stray capacitance or leaks beside the gap does not pull; neither is known here"
    )
    return Lamp("current drive", "unknown", text)
