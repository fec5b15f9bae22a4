"""Limits a person or a device must not pass, and the lamps that say how far a model can be believed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.lamps import Lamp
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.core.units import format_quantity

if TYPE_CHECKING:
    from numpy.typing import NDArray

PASCHEN_A = 112.50 * 1e-3 * 1e2
"""Ionisation constant of air [1/(Pa m)]: 112.50 /(kPa cm)."""
PASCHEN_B = 2737.50 * 1e-3 * 1e2
"""Excitation constant of air [V/(Pa m)]: 2737.50 V/(kPa cm)."""
SECONDARY_EMISSION = 0.01
"""Electrons freed per ion that hits the electrode; recalled, not read."""
ATMOSPHERE = 101325.0
"""Pa."""
SMALLEST_PASCHEN_GAP = 5e-6
"""Below, Paschen's law fails and field emission takes over [m]."""
FIELD_EMISSION = 75e6
"""Micro-gap breakdown in air [V/m]; recalled, not read."""
LINEAR_SKIN = 10.0
"""Voltage up to which skin conducts in proportion: onset of electroporation at 10 to 20 V."""
SURFACE_TENSION = 0.072
"""Water [N/m]."""


class Limits(Model):
    """What the set-up promises not to exceed."""

    current: Annotated[
        Number,
        Quantity(
            "A",
            1e-9,
            10,
            "largest current into the contact, by the amplifier's own limiter",
            "Vezzoli 2014, section 4",
        ),
    ] = 250e-6
    example: ClassVar[dict[str, Any]] = {}


def paschen_voltage(gap: float) -> float:
    """Breakdown voltage of an air gap at atmospheric pressure.

    Parameters
    ----------
    gap : float
        m, above 0.

    Returns
    -------
    float
        V; infinite where the gap is too small for an avalanche by this law.

    Notes
    -----
    V = B p d/(ln(A p d) - ln(ln(1 + 1/gamma))); gamma is recalled. Not valid below about 5 um.
    """
    product = ATMOSPHERE * gap
    denominator = math.log(PASCHEN_A * product) - math.log(math.log1p(1 / SECONDARY_EMISSION))
    return PASCHEN_B * product / denominator if denominator > 0 else math.inf


def electrowetting_voltage(*, thickness: float, permittivity: float) -> float:
    """Voltage at which Young-Lippmann would change cos(theta) by 1: menisci are saturated above.

    Parameters
    ----------
    thickness : float
        Of the insulating film under the sweat [m], above 0.
    permittivity : float
        Its relative permittivity, 1 or more.

    Returns
    -------
    float
        V.
    """
    return math.sqrt(2 * SURFACE_TENSION * thickness / (eps0 * permittivity))


def _against(name: str, value: float, limit: float, unit: str, *, what: str, why: str) -> Lamp:
    state = "warning" if value > limit else "ok"
    word = "above" if state == "warning" else "within"
    shown, bound = format_quantity(value, unit, digits=3), format_quantity(limit, unit, digits=3)
    return Lamp(name, state, f"{what} reaches {shown}, {word} {bound}: {why}", value, limit, unit)


def lamps(
    *,
    peak_fields: dict[str, float],
    thicknesses: dict[str, float],
    breakdown_fields: dict[str, float | None],
    peak_current: float,
    current_of: str = "the contact",
    jumps: bool,
    peak_voltage: float,
    insulator_permittivity: float | None,
    limits: Limits,
    return_path: str,
) -> list[Lamp]:
    """Judge a result against what is known of air, skin, film, water and the amplifier.

    Parameters
    ----------
    peak_fields, thicknesses, breakdown_fields : dict of str to float
        Largest absolute field [V/m], thickness [m] and known breakdown field [V/m] of each layer.
    peak_current : float
        Largest absolute current between jumps [A].
    current_of : str
        What it goes into.
    jumps : bool
        Whether the drive jumps, which no amplifier can follow.
    peak_voltage : float
        Largest absolute voltage across the stack [V].
    insulator_permittivity : float or None
        Real relative permittivity of the insulator at 1 kHz.
    limits : Limits
        Declared.
    return_path : str
        Name of the model of the way back.

    Returns
    -------
    list of Lamp
        In the order plate to finger, then the circuit.
    """
    found = []
    for name, limit in breakdown_fields.items():
        if name != "gap" and limit is not None:
            what = f"the field in '{name}'"
            why = "its declared breakdown field"
            found.append(_against("film strength", peak_fields[name], limit, "V/m", what=what, why=why))
    if "insulator" in thicknesses and breakdown_fields.get("insulator") is None:
        shown = format_quantity(peak_fields["insulator"], "V/m", digits=3)
        text = f"the insulator's field reaches {shown}; no breakdown_field is declared for it"
        found.append(Lamp("film strength", "unknown", text))
    if "gap" in thicknesses:
        found += air_lamps(peak_fields["gap"], thicknesses["gap"])
    if "stratum_corneum" in thicknesses:
        voltage = peak_fields["stratum_corneum"] * thicknesses["stratum_corneum"]
        why = "up to there skin conducts in proportion"
        what = "the voltage across the stratum corneum"
        found.append(_against("linear skin", voltage, LINEAR_SKIN, "V", what=what, why=why))
    if insulator_permittivity is not None:
        limit = electrowetting_voltage(
            thickness=thicknesses["insulator"], permittivity=insulator_permittivity
        )
        why = "where sweat menisci saturate and a V^2 law fails"
        what = "the voltage across the stack"
        found.append(_against("electrowetting", peak_voltage, limit, "V", what=what, why=why))
    found.append(_current(peak_current, limits, jumps=jumps, what=f"the current into {current_of}"))
    if return_path == "Floating":
        text = "the body is not grounded: part of the voltage drops between body and ground"
        found.append(Lamp("return path", "warning", text))
    return found


def air_lamps(field: float, gap: float) -> list[Lamp]:
    """Judge the air between plate and finger.

    Parameters
    ----------
    field : float
        Largest absolute field in the gap [V/m].
    gap : float
        m; 0 for a vanishing gap, about which Paschen's law says nothing.

    Returns
    -------
    list of Lamp
        Paschen's law where there is a gap, then field emission.
    """
    why = "where micro-gaps break down by field emission (recalled value)"
    emission = _against("field emission", field, FIELD_EMISSION, "V/m", what="the gap field", why=why)
    if gap <= 0:
        return [emission]
    if gap >= SMALLEST_PASCHEN_GAP:
        why = "where air breaks down by Paschen's law (its secondary emission is a recalled value)"
        what = "the voltage across the gap"
        paschen = _against("Paschen", field * gap, paschen_voltage(gap), "V", what=what, why=why)
    else:
        paschen = Lamp(
            "Paschen", "unknown", f"a gap of {format_quantity(gap, 'm')} is below the law's reach, 5 um"
        )
    return [paschen, emission]


def _current(peak: float, limits: Limits, *, jumps: bool, what: str) -> Lamp:
    if jumps:
        text = (
            "the drive jumps, so the current has no bound but the series resistance: give it an edge time;"
            f" the amplifier limits it to {format_quantity(limits.current, 'A')}"
        )
        return Lamp("current", "warning", text)
    why = "the declared limit (limits.current)"
    return _against("current", peak, limits.current, "A", what=what, why=why)


def peak(values: NDArray[np.float64]) -> float:
    """Largest absolute value, in the unit of the values [any]; NaN ignored, 0 for none."""
    finite = values[np.isfinite(values)]
    return float(np.max(np.abs(finite))) if finite.size else 0.0
