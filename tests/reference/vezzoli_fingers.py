"""Closed forms of figures 6 and 7 of Vezzoli et al. 2014 for many fingers at once, apart from the solvers."""

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers.vezzoli_2014 import values

SKIN = "stack.stratum_corneum.thickness"
PERMITTIVITY = "stack.stratum_corneum.material.permittivity"
CONDUCTIVITY = "stack.stratum_corneum.material.conductivity"
EXPONENT = "stack.stratum_corneum.material.exponent"
GAP = "stack.gap.thickness"
LEAK = "stack.gap.material.conductivity"
FRICTION = "friction.coefficient"
ANCHOR = 100.0
"""Frequency of the permittivity of the constant-phase skin of figure 7 [Hz]."""
AMPLITUDE = 100.0
"""Voltage of figure 7 [V]."""


def lateral_by_law(at, *, ramp=values.RAMP):
    """Compute the lateral force at the end of the rising ramp of figure 6, under law (1) with the causal charge loss.

    `at` has by path, each of shape (n,), thickness, permittivity and conductivity of the stratum corneum, and
    friction, in SI; returns coefficient of friction times attraction (n,) [N].
    """
    skin, film = _skin(at), values.FILM_PERMITTIVITY * eps0 / values.FILM_THICKNESS
    tau = (film + skin) * at[SKIN] / at[CONDUCTIVITY]
    effective = values.VOLTAGE * tau / ramp * -np.expm1(-ramp / tau)
    electrical = values.FILM_THICKNESS / values.FILM_PERMITTIVITY + at[SKIN] / at[PERMITTIVITY]
    length = values.FILM_THICKNESS + at[SKIN]
    return np.asarray(
        at[FRICTION] * eps0 * values.AREA * effective**2 / (2 * electrical * length), dtype=float
    )


def lateral_in_gap(at, *, ramp=values.RAMP):
    """Compute the lateral force at the end of the rising ramp of figure 6, with the Maxwell stress in a leaky gap.

    As `lateral_by_law`, with thickness and conductivity of the gap. The step response of the gap voltage is a
    sum of two exponentials, whose rates are the zeros of C_g C_s + C_i (C_g + C_s) times s^2, and so on:
    film, gap and skin in series, without the resistance of the body.
    """
    film, gap, skin = values.FILM_PERMITTIVITY * eps0 / values.FILM_THICKNESS, eps0 / at[GAP], _skin(at)
    leak, loss = at[LEAK] / at[GAP], at[CONDUCTIVITY] / at[SKIN]
    square = gap * skin + film * (skin + gap)
    linear = leak * skin + loss * gap + film * (loss + leak)
    root = np.sqrt(linear**2 - 4 * square * leak * loss)
    fast = (linear + root) / (2 * square)
    slow = leak * loss / (square * fast)
    response = np.zeros_like(fast)
    for rate, other in ((fast, slow), (slow, fast)):
        weight = film * (skin * rate - loss) / (square * (rate - other))
        response += weight * -np.expm1(-rate * ramp) / (rate * ramp)
    field = values.VOLTAGE * response / at[GAP]
    return np.asarray(at[FRICTION] * values.AREA * eps0 * field**2 / 2, dtype=float)


def mean_by_law(at, frequency):
    """Compute the mean attraction of figure 7 over frequency, by the law as printed.

    `at` has by path, each of shape (n,), thickness, permittivity at 100 Hz, exponent and conductivity of a
    constant-phase skin, in SI; `frequency` (m,) [Hz]. Returns the mean attraction (n, m) [N] on 1 cm2 of the
    thin coating under 100 V.
    """
    bound, whole = _dispersive(at, frequency)
    skin = at[SKIN][:, None]
    film = values.COATING_PERMITTIVITY * eps0 / values.COATING_THICKNESS
    gain = np.abs(_printed(frequency, film, eps0 * whole / skin))
    electrical = values.COATING_THICKNESS / values.COATING_PERMITTIVITY + skin / bound.real
    length = values.COATING_THICKNESS + skin
    return np.asarray(eps0 * values.AREA * (AMPLITUDE * gain) ** 2 / (4 * electrical * length))


def mean_in_gap(at, frequency):
    """Compute the mean attraction of figure 7 over frequency, with the Maxwell stress in a gap of air that does not conduct.

    As `mean_by_law`, with the thickness of the gap.
    """
    _, whole = _dispersive(at, frequency)
    electrical = values.COATING_THICKNESS / values.COATING_PERMITTIVITY + at[SKIN][:, None] / whole
    field = np.abs(AMPLITUDE / (electrical + at[GAP][:, None]))
    return np.asarray(eps0 * values.AREA * field**2 / 4)


def _skin(at):
    return np.asarray(eps0 * at[PERMITTIVITY] / at[SKIN])


def _dispersive(at, frequency):
    """Return the bound and the whole relative permittivity of constant-phase skins, each of shape (n, m)."""
    power = at[EXPONENT][:, None] - 1
    bound = at[PERMITTIVITY][:, None] * (1j * frequency / ANCHOR) ** power / np.cos(power * np.pi / 2)
    whole = bound + at[CONDUCTIVITY][:, None] / (2j * np.pi * frequency * eps0)
    return np.asarray(bound, dtype=complex), np.asarray(whole, dtype=complex)


def _printed(frequency, film, skin):
    """Return v_e/v of equation (5) with the real capacitance and the conductance of the skin at each frequency."""
    angular = 2 * np.pi * frequency
    capacitance, conductance = skin.real, -angular * skin.imag
    return 1j * angular * (film + capacitance) / (conductance + 1j * angular * (film + capacitance))
