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
from electrovib.physics.force import SUMS, StressOfField, equivalent_field, layer_of
from electrovib.physics.stack import Layer, Linear, Role, Section, beside_interface, roles_of

READINGS_AGREE = 0.1
"""Relative difference of the effective voltage up to which both readings count as equal, a choice."""
_ROUNDING = 1e-9
_LAYERS: tuple[Role, ...] = ("plate", "finger")
_PRESSURE: Mapping[str, str] = {"pressure": "eps0*E**2/2", "E": "v_e/sqrt(K*L)"}
_INSULATOR: Mapping[str, str] = {
    "C_i": "eps0/K_i",
    "K_i": "sum(layer.thickness/layer.material.permittivity for layer in insulator)",
}
_REFERENCE = "Vezzoli et al., Electrovibration modeling analysis, EuroHaptics 2014, hal-01253573"


def dielectric_permittivity(section: Section, name: str) -> float:
    """Relative permittivity of a layer of the plate, which the paper takes as a constant: none is dispersive."""
    material = section[name].material
    exact = material.debye()
    if exact is None or any(exact.strengths):
        raise InputError(
            f"stack.{name}.material = {type(material).__name__}: the law of Vezzoli 2014 has one permittivity for the"
            ' insulator; use { model = "Constant", permittivity = ... }, or force.model = MaxwellStressInGap'
        )
    return exact.high


def plate_thickness(section: Section) -> float:
    """Sum T/eps over the layers of the plate [m], eps0 over their capacitance per area."""
    names = [name for name, role in section.roles.items() if role == "plate"]
    return sum(section[name].thickness / dielectric_permittivity(section, name) for name in names)


class Vezzoli2014Causal(StressOfField):
    """The force of Vezzoli et al. 2014 with only direct conduction as lost charge: causal, for any drive.

    Notes
    -----
    The charge lost to the insulator's surface is Q_i = D_insulator - D_skin, the conducted one, so
    v_e = v - Q_i/C_i, that is H = 1 - (sigma/T_s)/(Y_s + j w C_i) with Y_s = j w eps0 eps_s*/T_s. Of several layers,
    C_i is the capacitance of all those of the plate in series, D is that of the layers on both sides of the interface,
    and the sums K and L are those of `EffectiveMedium`: `insulator` stands for the layers of the plate, `D_insulator`
    and `D_skin` for the bound displacements on both sides of the interface, and `voltage`, `frequency` and `solids` are
    explained there.

    All polarisation of the skin is bound charge. Without dispersion this is equation (5) of the paper. With
    dispersion it differs from the other reading, `Vezzoli2014PerFrequency`; every Trace states the largest
    difference over its frequencies. The law depends on the conductivity alone, which has to be declared. The
    paper's factor 1/K(w) acts before the square, as K^(-1/2) inside the filter.
    """

    reference: ClassVar[str] = _REFERENCE
    status: ClassVar[str] = "full text"
    equation: ClassVar[Mapping[str, str]] = {
        **_PRESSURE,
        "v_e": "voltage - Q_i/C_i",
        "Q_i": "D_insulator - D_skin",
        **_INSULATOR,
        **SUMS,
    }
    evaluation_surface: ClassVar[str] = "effective medium"
    needs: ClassVar[tuple[str, ...]] = _LAYERS

    def effective_voltage(self, section: Section) -> Linear:
        """Return the voltage minus that of the lost charge on the insulator [V]."""
        film, skin = (layer_of(section, role) for role in _LAYERS)
        lost = film.displacement - skin.displacement
        return section.voltage - lost * (plate_thickness(section) / eps0)

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Return the equivalent field v_e/sqrt(K L) [V/m]."""
        return {"E": equivalent_field(section, self.effective_voltage(section))}

    def diagnostics(self, layers: Mapping[str, Layer]) -> tuple[Diagnostic, ...]:
        """Warn where nothing conducts, and where a table does not determine how much does."""
        roles, found = roles_of(layers), list[Diagnostic]()
        skin = layers[beside_interface(roles, "finger") or ""]
        if skin.material.conductivity == 0 and skin.leak is None:
            text = "the stratum corneum has conductivity 0: no charge is ever lost, the force never fades"
            found.append(Diagnostic("lost charge", "warning", text))
        bounds = skin.material.conduction_bounds()
        if bounds is not None:
            found.append(Diagnostic("lost charge", "warning", _interval(layers, skin, bounds)))
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


def _interval(layers: Mapping[str, Layer], skin: Layer, bounds: tuple[float, float]) -> str:
    """State the range of |v_e/v| while the loss of the table may be conduction or slow polarisation."""
    lowest, roles = skin.material.band[0], roles_of(layers)
    drops = {name: complex(layer.impedance(lowest)) for name, layer in layers.items()}
    plate = sum(drop for name, drop in drops.items() if roles[name] == "plate")
    # v_e/v per conductivity that is lost: field in the skin times the impedance of the insulator, per current density
    share = skin.impedance(lowest) / skin.thickness * plate / sum(drops.values())
    least, most = (abs(1 - sigma * share) for sigma in reversed(bounds))
    declared = abs(1 - skin.material.conductivity * share)
    return (
        f"a table does not determine how much of its slow loss is conduction: at {lowest:.3g} Hz |v_e/v| lies between"
        f" {least:.2g} (all of it) and {most:.2g} (none); with the declared conductivity it is {declared:.2g}"
    )


class Vezzoli2014PerFrequency(StressOfField):
    """The force of Vezzoli et al. 2014 as printed, with the skin's values at the frequency: magnitudes of one sine only.

    Notes
    -----
    H = j w (C_i + C_s)/(G_s + j w (C_i + C_s)) with real C_s(w) = eps0 eps'/T_s and G_s(w) = w eps0 eps''/T_s.
    It is written with the complex capacitance C_s - j G_s/w. Real capacitances that depend on frequency times j w are
    not causal: with dispersive skins v_e reaches 8
    to 30 % of its peak 1 ms before a 20 ms ramp begins. The factor 1/K takes the real permittivity at w. Several layers
    of the plate, `insulator`, and of the finger, `skin`, are one layer in series with the same impedance; `voltage`,
    `frequency` and `solids` are explained for `EffectiveMedium`.
    """

    reference: ClassVar[str] = _REFERENCE
    status: ClassVar[str] = "full text"
    equation: ClassVar[Mapping[str, str]] = {
        **_PRESSURE,
        "v_e": "voltage*(C_i + re(C_s))/(C_i + C_s)",
        **_INSULATOR,
        "C_s": "eps0/K_s",
        "K_s": "sum(layer.thickness/layer.material.complex_permittivity(frequency) for layer in skin)",
        "K": "sum(layer.thickness/re(layer.material.bound_permittivity(frequency)) for layer in solids)",
        "L": SUMS["L"],
    }
    evaluation_surface: ClassVar[str] = "effective medium"
    causal: ClassVar[bool] = False
    needs: ClassVar[tuple[str, ...]] = _LAYERS
    instead: ClassVar[str] = "Vezzoli2014Causal"

    def effective_voltage(self, section: Section) -> Linear:
        """Return the effective voltage of equation (5) with the values at each frequency [V]."""
        fingers = [section[name] for name, role in section.roles.items() if role == "finger"]
        each = [skin.thickness / skin.material.complex_permittivity(section.frequency) for skin in fingers]
        return section.voltage * literal_response(
            section.frequency,
            insulator=eps0 / plate_thickness(section),
            skin=eps0 / sum(each[1:], start=each[0]),
        )

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Return the equivalent field [V/m], with the real permittivity at the frequency in 1/K."""
        fingers = [section[name] for name, role in section.roles.items() if role == "finger"]
        each = [skin.thickness / skin.material.bound_permittivity(section.frequency).real for skin in fingers]
        electrical = plate_thickness(section) + sum(each)
        length = sum(section[name].thickness for name, role in section.roles.items() if role in _LAYERS)
        return {"E": self.effective_voltage(section) * (electrical * length) ** -0.5}


def literal_response(
    frequency: NDArray[np.float64], *, insulator: float, skin: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Compute v_e/v by equation (5) with real capacitance and conductance that depend on frequency [Hz].

    `insulator` and `skin` are capacitances per area [F/m2], the latter complex and with conduction.
    """
    angular = 2 * np.pi * frequency
    charging = 1j * angular * (insulator + skin.real)
    response: NDArray[np.complex128] = charging / (-angular * skin.imag + charging)
    return response
