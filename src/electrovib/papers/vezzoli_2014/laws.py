"""The paper's lost charge, in the two readings that its frequency-dependent skin allows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.force import ForceLaw, equivalent_field, layer_of
from electrovib.physics.interface import Role, beside_interface, roles_of
from electrovib.physics.stack import Layer, LayerState, Linear, Section
from electrovib.physics.tabulated import Tabulated

READINGS_AGREE = 0.1
"""Relative difference of the effective voltage up to which both readings count as equal, a choice."""
_ROUNDING = 1e-9
_LAYERS: tuple[Role, ...] = ("plate", "finger")
_REFERENCE = "Vezzoli et al., Electrovibration modeling analysis, EuroHaptics 2014, hal-01253573"


def insulator_permittivity(film: LayerState) -> float:
    """Relative permittivity of the insulator, which the paper takes as a constant.

    Raises
    ------
    InputError
        If the insulator is dispersive.
    """
    exact = film.material.debye()
    if exact is None or any(exact.strengths):
        kind = type(film.material).__name__
        raise InputError(
            f"stack.insulator.material = {kind}: the law of Vezzoli 2014 has one permittivity for the"
            ' insulator; use { model = "Constant", permittivity = ... }, or force.model = MaxwellStressInGap'
        )
    return exact.high


class Vezzoli2014Causal(ForceLaw):
    """The force of Vezzoli et al. 2014 with only direct conduction as lost charge: causal, for any drive.

    Notes
    -----
    The charge lost to the insulator's surface is Q_i = D_insulator - D_skin, the conducted one, so
    v_e = v - Q_i/C_i, that is H = 1 - (sigma/T_s)/(Y_s + j w C_i) with Y_s = j w eps0 eps_s*/T_s. All
    polarisation of the skin is bound charge. Without dispersion this is equation (5) of the paper. With
    dispersion it differs from the other reading, `Vezzoli2014PerFrequency`; every Trace states the largest
    difference over its frequencies. The law depends on the conductivity alone, which has to be declared. The
    paper's factor 1/K(w) acts before the square, as K^(-1/2) inside the filter.
    """

    reference: ClassVar[str] = _REFERENCE
    status: ClassVar[str] = "full text"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "eps0*E**2/2"}
    evaluation_surface: ClassVar[str] = "effective medium"
    needs: ClassVar[tuple[str, ...]] = _LAYERS

    def effective_voltage(self, section: Section) -> Linear:
        """Return the voltage minus that of the lost charge on the insulator [V]."""
        film, skin = (layer_of(section, role) for role in _LAYERS)
        lost = film.displacement - skin.displacement
        return section.voltage - lost * (film.thickness / (eps0 * insulator_permittivity(film)))

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Return the equivalent field v_e/sqrt(K (T_i + T_s)) [V/m]."""
        return {"E": equivalent_field(section, self.effective_voltage(section))}

    def pressure(self, E: NDArray[np.float64]) -> NDArray[np.float64]:
        """Attraction per area from the equivalent field [V/m]."""
        return eps0 * E**2 / 2

    def diagnostics(self, layers: Mapping[str, Layer]) -> tuple[Diagnostic, ...]:
        """Warn where nothing conducts, and where a table does not determine how much does."""
        film, skin = (layers[name] for role in _LAYERS if (name := beside_interface(roles_of(layers), role)))
        found = [*super().diagnostics(layers)]
        if skin.material.conductivity == 0 and skin.leak is None:
            text = "the stratum corneum has conductivity 0: no charge is ever lost, the force never fades"
            found.append(Diagnostic("lost charge", "warning", text))
        if isinstance(skin.material, Tabulated):
            found.append(Diagnostic("lost charge", "warning", _interval(film, skin, skin.material)))
        return tuple(found)

    def diagnostics_over_frequency(self, section: Section) -> tuple[Diagnostic, ...]:
        """Return the largest difference from the paper's other reading; no diagnostic without dispersion."""
        frequency = np.asarray(section.frequency, dtype=float)
        own = np.abs(self.effective_voltage(section))
        other = np.abs(Vezzoli2014PerFrequency().effective_voltage(section))
        ratio = other / own
        worst = int(np.argmax(np.abs(ratio - 1)))
        difference = float(ratio[worst] - 1)
        if abs(difference) < _ROUNDING:
            return ()
        at, low, high = (format_quantity(float(f), "Hz", digits=3) for f in frequency[[worst, 0, -1]])
        text = (
            f"the paper's law as printed, Vezzoli2014PerFrequency, gives an effective voltage that differs from this one by"
            f" {100 * difference:+.3g} % at {at}, {ratio[worst] ** 2:.3g} times the force: the largest difference from {low}"
            f" to {high}."
            " The paper does not state which of the two it means; for other frequencies set frequency.low and frequency.high"
        )
        state = "ok" if abs(difference) <= READINGS_AGREE else "warning"
        return (
            Diagnostic(
                "readings of the law", state, text, value=abs(difference), limit=READINGS_AGREE, unit="1"
            ),
        )


def _interval(film: Layer, skin: Layer, table: Tabulated) -> str:
    """State the range of |v_e/v| while the loss of the table may be conduction or slow polarisation."""
    lowest = table.band[0]
    admittance = 1 / skin.impedance(lowest) + 1 / film.impedance(lowest)
    least, most = (abs(1 - s / skin.thickness / admittance) for s in reversed(table.conduction_bounds()))
    declared = abs(1 - table.conductivity / skin.thickness / admittance)
    return (
        f"a table does not determine how much of its slow loss is conduction: at {lowest:.3g} Hz |v_e/v| lies between"
        f" {least:.2g} (all of it) and {most:.2g} (none); with the declared conductivity it is {declared:.2g}"
    )


class Vezzoli2014PerFrequency(ForceLaw):
    """The force of Vezzoli et al. 2014 as printed, with the skin's values at the frequency: magnitudes of one sine only.

    Notes
    -----
    H = j w (C_i + C_s)/(G_s + j w (C_i + C_s)) with real C_s(w) = eps0 eps'/T_s and G_s(w) = w eps0 eps''/T_s.
    Real capacitances that depend on frequency times j w are not causal: with dispersive skins v_e reaches 8
    to 30 % of its peak 1 ms before a 20 ms ramp begins. The factor 1/K takes the real permittivity at w.
    """

    reference: ClassVar[str] = _REFERENCE
    status: ClassVar[str] = "full text"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "eps0*E**2/2"}
    evaluation_surface: ClassVar[str] = "effective medium"
    causal: ClassVar[bool] = False
    needs: ClassVar[tuple[str, ...]] = _LAYERS
    instead: ClassVar[str] = "Vezzoli2014Causal"

    def effective_voltage(self, section: Section) -> Linear:
        """Return the effective voltage of equation (5) with the values at each frequency [V]."""
        film, skin = (layer_of(section, role) for role in _LAYERS)
        return section.voltage * literal_response(
            section.frequency,
            insulator=eps0 * insulator_permittivity(film) / film.thickness,
            skin=eps0 * skin.material.complex_permittivity(section.frequency) / skin.thickness,
        )

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Return the equivalent field [V/m], with the real permittivity at the frequency in 1/K."""
        film, skin = (layer_of(section, role) for role in _LAYERS)
        permittivity = skin.material.bound_permittivity(section.frequency).real
        electrical = film.thickness / insulator_permittivity(film) + skin.thickness / permittivity
        length = film.thickness + skin.thickness
        return {"E": self.effective_voltage(section) * (electrical * length) ** -0.5}

    def pressure(self, E: NDArray[np.float64]) -> NDArray[np.float64]:
        """Attraction per area from the equivalent field [V/m]."""
        return eps0 * E**2 / 2


def literal_response(
    frequency: NDArray[np.float64], *, insulator: float, skin: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Compute equation (5) with real capacitance and conductance that depend on frequency.

    Parameters
    ----------
    frequency : ndarray
        Hz, above 0.
    insulator : float
        Capacitance per area [F/m2].
    skin : ndarray of complex
        Complex capacitance per area, conduction included [F/m2].

    Returns
    -------
    response : ndarray of complex, shape of `frequency`
        v_e/v [1].
    """
    angular = 2 * np.pi * frequency
    charging = 1j * angular * (insulator + skin.real)
    response: NDArray[np.complex128] = charging / (-angular * skin.imag + charging)
    return response
