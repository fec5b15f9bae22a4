"""The capacitance of a contact from its impedance, when the layers in series with its gap are known."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Complex, Real
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.scenario import Source, read_scenario
from electrovib.solve.stack.blocking import uniform_stack

MISSED: Final = 0.1
"""Relative root mean square of the impedance that layers and gap miss, beyond which they are not what was measured."""


def contact_capacitance(scenario: Source, *, frequency: ArrayLike, impedance: Complex) -> Real:
    """Find the capacitance of film and gap from impedances over frequency, such as one spectrum at each of some loads.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `rough_contact`: the layers in series with the gap, such as film and skin, the area, and the resistances of
        amplifier and return path. The thickness of the gap has no effect.
    frequency : array_like, shape (n,)
        Frequencies [Hz], above 0.
    impedance : ndarray, shape (loads, n) or (n,), complex
        Impedance of the whole series at each [ohm], that of the leads subtracted: real part R, imaginary part below 0 for a
        capacitor.

    Returns
    -------
    capacitance : ndarray, shape (loads,) or ()
        Capacitance of gap and blocking layers [F], which `fit_contact` takes.

    Raises
    ------
    InputError
        If the impedance leaves nothing for a gap, misses layers and gap by more than 10 %, or the scenario is one that
        `rough_contact` refuses.

    Notes
    -----
    Z = R + sum of T/(j w eps0 eps* A) over the layers + G/(j w eps0 eps_gap A). The gap G of plates is fitted to all frequencies
    by least squares of the deviation over the modulus; the capacitance is eps0 eps_gap A/(G + K) with the electrical thickness
    K of the layers that block. So a film may have a loss and a skin its dispersion. Skin is in series with the whole contact,
    which holds while its impedance is small beside that of the gap.

    Examples
    --------
    >>> pad = ev.run("bau_2010/sine", set={"stack.gap.thickness": "2 um"})
    >>> f"{ev.contact_capacitance(pad, frequency=pad.frequency, impedance=pad.impedance):.4g}"
    '3.924e-10'
    """
    known = read_scenario(scenario)
    stack, gap = uniform_stack(known), known.stack.gap_name
    grid, measured = _spectra(frequency, impedance)
    series = known.circuit.element().impedance(grid)
    for name, layer in known.stack.layers.items():
        series = series + (0.0 if name == gap else layer.impedance(grid) / stack.area)
    of_gap = 1 / (2j * math.pi * grid * eps0 * stack.filling * stack.area)
    weight = 1 / np.abs(measured)
    left = measured - series
    width = np.sum((left * of_gap.conj()).real * weight**2, -1) / np.sum(np.abs(of_gap * weight) ** 2, -1)
    missed = np.sqrt(np.mean(np.abs((left - width[..., None] * of_gap) * weight) ** 2, -1))
    for at, (each, error) in enumerate(zip(np.atleast_1d(width), np.atleast_1d(missed), strict=True)):
        if error > MISSED:
            raise InputError(
                f"impedance[{at}]: layers and a gap miss it by {100 * error:.2g} % of its modulus, more than {100 * MISSED:g} %;"
                " check stack, circuit and contact.area, or omit frequencies at which leads or skin count more than the gap"
            )
        if not each > 0:
            raise InputError(
                f"impedance[{at}]: its gap would be {format_quantity(float(each), 'm')}: the layers alone have a larger"
                " impedance; check stack and contact.area, and subtract the leads"
            )
    return np.asarray(eps0 * stack.filling * stack.area / (width + stack.electrical_thickness))


def _spectra(frequency: ArrayLike, impedance: Complex) -> tuple[Real, Complex]:
    """Return frequencies and impedances that have a size each, or refuse them."""
    grid, measured = np.asarray(frequency, dtype=float), np.asarray(impedance, dtype=complex)
    if grid.ndim != 1 or measured.ndim not in (1, 2) or measured.shape[-1:] != grid.shape or not grid.size:
        raise InputError(
            f"frequency, impedance: expected a row of frequencies, and an impedance at each in a row for each load, not of the"
            f" shapes {grid.shape} and {measured.shape}"
        )
    if not (np.isfinite(grid).all() and (grid > 0).all()):
        raise InputError("frequency: expected finite numbers above 0 Hz")
    if not (np.isfinite(measured).all() and (measured != 0).all()):
        raise InputError("impedance: expected finite numbers other than 0 ohm; omit frequencies without one")
    return grid, measured
