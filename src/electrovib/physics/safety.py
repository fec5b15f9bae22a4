"""Electrical limits of films, air, skin and sweat, and the diagnostics that compare a run with them."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic, against
from electrovib.core.parsing import read_toml
from electrovib.core.units import format_quantity
from electrovib.physics.material.library import UNVERIFIED, BreakdownStrength, find_substance, materials

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.physics.stack import Layer


PASCHEN_A = 112.50 * 1e-3 * 1e2
"""Ionisation constant of air [1/(Pa m)]: 112.50 /(kPa cm)."""
PASCHEN_B = 2737.50 * 1e-3 * 1e2
"""Excitation constant of air [V/(Pa m)]: 2737.50 V/(kPa cm)."""
SECONDARY_EMISSION = 0.01
"""Electrons released per ion that hits the electrode; cited from memory, unverified."""
ATMOSPHERE = 101325.0
"""Standard pressure of air [Pa]."""
SMALLEST_PASCHEN_GAP = 5e-6
"""Gap below which Paschen's law fails and field emission dominates [m]."""
FIELD_EMISSION = 75e6
"""Field of breakdown of micro-gaps in air [V/m]; cited from memory, unverified."""
AIR: Final = ("Paschen", "field emission")
"""Names of the diagnostics of the air between plate and finger."""
FILM: Final = "film strength"
"""Beginning of the names of the diagnostics of a layer's breakdown."""
GAP_CLOSED: Final = ", gap closed"
"""Follows the name of the diagnostic of a film where the gap in front of it is closed."""
BARE_ELECTRODE: Final = "bare electrode"
"""Name of the diagnostic of a plate without any film."""
LINEAR_SKIN = 10.0
"""Voltage up to which skin is ohmic [V]: the onset of electroporation is at 10 to 20 V."""
SURFACE_TENSION = 0.072
"""Surface tension of water [N/m]."""
POLYMER_PERMITTIVITY: Final = (2.0, 4.5)
"""Relative permittivities at 1 kHz between which an unnamed layer counts as a polymer film; a choice."""
OTHER_THICKNESS: Final = {
    "same": "",
    "thinner": "; this layer is thinner, and thinner films usually hold more",
    "thicker": "; this layer is thicker, and thicker films usually hold less, so this limit does not show that it holds",
    "unknown": "; so this limit does not show that this layer holds",
}
"""What follows from the thickness at which a strength was measured, by that of the layer."""


def paschen_voltage(*, gap: float) -> float:
    """Breakdown voltage of an air gap at atmospheric pressure.

    Parameters
    ----------
    gap : float
        m, above 0.

    Returns
    -------
    voltage : float
        V; infinite where the gap is too small for an avalanche by this law.

    Notes
    -----
    V = B p d/(ln(A p d) - ln(ln(1 + 1/gamma))); gamma is cited from memory, unverified. Not valid below about
    5 um.
    """
    product = ATMOSPHERE * gap
    denominator = math.log(PASCHEN_A * product) - math.log(math.log1p(1 / SECONDARY_EMISSION))
    return PASCHEN_B * product / denominator if denominator > 0 else math.inf


def electrowetting_voltage(*, thickness: float, permittivity: float) -> float:
    """Voltage [V] at which the Young-Lippmann equation changes cos(theta) by 1; above it menisci are saturated.

    `thickness` [m] and relative `permittivity` are those of the insulating film under the sweat.
    """
    return math.sqrt(2 * SURFACE_TENSION * thickness / (eps0 * permittivity))


def breakdown_share(fields: NDArray[np.float64], gaps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Voltage across a gap over its breakdown voltage by Paschen's law, 1 at breakdown.

    `fields` [V/m] and `gaps` [m] over time (n,); 0 for gaps to which the law does not apply.
    """
    if len(gaps) and np.all(gaps == gaps[0]):
        gaps = gaps[:1]
    held = np.array([paschen_voltage(gap=max(each, SMALLEST_PASCHEN_GAP)) for each in gaps.tolist()])
    return np.asarray(np.abs(fields) * np.where(gaps >= SMALLEST_PASCHEN_GAP, gaps / held, 0.0))


def film_diagnostic(name: str, layer: Layer, *, field: float, closed: str = "") -> Diagnostic:
    """Compare the largest absolute field of a layer [V/m] with its breakdown strength.

    `closed` is empty for the gap as declared, else says in words how it is closed. The declared breakdown field counts first,
    then the strength of its substance in the materials library, then that of the polymer films of the library. Unknown if no
    strength is known, and where the field is within a strength that is unverified, or was measured on a thinner layer, or at a
    thickness that is not known.
    """
    title, what = f"{FILM}, {name}", f"the field in '{name}'"
    if closed:
        title, what = f"{title}{GAP_CLOSED}", f"{what}, {closed},"
    if layer.breakdown_field is not None:
        why = "its declared breakdown field"
        return _compared(title, field, layer.breakdown_field, what, why)
    own = f"for its own, set stack.{name}.material.substance or stack.{name}.breakdown_field"
    substance = None if layer.material.substance is None else find_substance(layer.material.substance)
    if substance is not None:
        strength = substance.strength_of(layer.thickness)
        whose, more = f"the breakdown strength of {substance.name}", ""
    else:
        permittivity = float(layer.material.bound_permittivity(np.array(1e3)).real)
        is_polymer = POLYMER_PERMITTIVITY[0] <= permittivity <= POLYMER_PERMITTIVITY[1]
        strength = _polymer_strength(layer.thickness) if is_polymer else None
        whose, more = "the lowest breakdown strength of polymer films in the materials library", f"; {own}"
    if strength is None:
        shown = format_quantity(field, "V/m", digits=3)
        text = f"{what} reaches {shown}; no breakdown strength is known for such a film; {own}"
        return Diagnostic(title, "unknown", text)
    compared = strength.compared_with(layer.thickness)
    why = f"{whose}, {strength.measured_at} ({strength.status}: {strength.source}){OTHER_THICKNESS[compared]}{more}"
    found = _compared(title, field, strength.value, what, why)
    doubtful = compared in {"thicker", "unknown"} or strength.status == UNVERIFIED
    return replace(found, state="unknown") if doubtful and found.state == "ok" else found


def _compared(title: str, field: float, limit: float, what: str, why: str) -> Diagnostic:
    """Compare a field with a strength, which is stated also where the field is not known."""
    found = against(title, value=field, limit=limit, unit="V/m", what=what, why=why)
    return replace(found, limit=limit, unit="V/m")


@functools.lru_cache(maxsize=256)
def _polymer_strength(thickness: float) -> BreakdownStrength | None:
    """Return the lowest strength that polymer films of the library have at a thickness [m]."""
    films = (each.strength_of(thickness) for each in materials() if each.kind == "polymer film")
    known = [each for each in films if each is not None and each.compared_with(thickness) == "same"]
    return min(known, key=lambda each: each.value, default=None)


def skin_diagnostic(name: str, *, voltage: float) -> Diagnostic:
    """Judge whether a layer of the finger is ohmic.

    The largest voltage across it [V] is compared with the onset of electroporation.
    """
    what, why = f"the voltage across '{name}'", "the onset of electroporation, up to which skin is ohmic"
    return against(f"linear skin, {name}", value=voltage, limit=LINEAR_SKIN, unit="V", what=what, why=why)


def sweat_diagnostic(*, voltage: float, electrical_thickness: float) -> Diagnostic:
    """Compare the voltage across the stack [V] with that at which sweat between finger and film saturates.

    `electrical_thickness` is the sum of T/eps at 1 kHz over the layers of the plate [m].
    """
    limit = electrowetting_voltage(thickness=electrical_thickness, permittivity=1.0)
    why = "where menisci of sweat saturate and a force proportional to V^2 no longer holds"
    return against(
        "electrowetting", value=voltage, limit=limit, unit="V", what="the voltage across the stack", why=why
    )


def paschen_diagnostic(*, field: float, gap: float) -> Diagnostic:
    """Compare the voltage across a gap with its breakdown voltage by Paschen's law.

    `field` [V/m] and `gap` [m]; unknown below 5 um, where the law does not hold.
    """
    if gap < SMALLEST_PASCHEN_GAP:
        text = f"a gap of {format_quantity(gap, 'm')} is below 5 um, where Paschen's law does not hold"
        return Diagnostic("Paschen", "unknown", text)
    why = "where air breaks down by Paschen's law (its secondary emission is a value cited from memory, unverified)"
    what = f"the voltage across a gap of {format_quantity(gap, 'm', digits=3)}"
    return against("Paschen", value=field * gap, limit=paschen_voltage(gap=gap), unit="V", what=what, why=why)


def emission_diagnostic(*, field: float, vanishing: bool = False) -> Diagnostic:
    """Compare the field of a gap [V/m], or of a vanishing one where the stack has no gap, with that of field emission.

    A field of NaN is not known. The comparison is with the breakdown of micro-gaps.
    """
    why = "where micro-gaps break down by field emission (value cited from memory, unverified)"
    what = "the field of a vanishing gap" if vanishing else "the gap field"
    return against("field emission", value=field, limit=FIELD_EMISSION, unit="V/m", what=what, why=why)


NOT_A_CLAIM: Final = (
    "These are comparisons with published currents, not a claim of medical safety: they hold for healthy adults and for the"
    " stated conditions, and say nothing about persons with an implanted device or a heart condition, wet or broken skin,"
    " burns, a fault of the amplifier, or breakdown of the insulator. Only hardware that limits the current protects a person."
)


@dataclass(frozen=True, kw_only=True)
class CurrentThreshold:
    """A current through a body or a finger, as a source states it.

    Parameters
    ----------
    name : str
        What the source calls it.
    value : float
        Current [A].
    statistic : str
        ``"peak"`` or ``"rms"``: the statistic of the current that it is compared with.
    of : str
        Current that is compared: ``"current"``, of the amplifier into plate, stray capacitance and finger, or
        ``"body_current"``, through the finger.
    conditions : str
        Conditions under which the source states it.
    source : str
        Publication.
    status : str
        How the source was read: ``"full text"``, ``"second-hand"`` or ``"unverified"``.
    """

    name: str
    value: float
    statistic: str
    of: str
    conditions: str
    source: str
    status: str


_STATED: Final = Path(__file__).with_name("body_current.toml").read_text(encoding="utf-8")
THRESHOLDS: Final = tuple(CurrentThreshold(**each) for each in read_toml(_STATED)["threshold"])
"""In the order in which they are shown."""


def smallest_series_resistance(*, voltage: float, current: float) -> float:
    """Compute the smallest resistance [ohm] that holds the current after a breakdown of the insulator.

    It is V/I: `voltage` V is the largest of the supply [V], `current` I the largest through the finger [A],
    above 0. The insulator counts as a short circuit and the body as no resistance. The charge behind the resistor,
    on the plate and its stray capacitance, is not limited by it: see `stored_energy_behind`.
    """
    return voltage / current


def largest_supply_voltage(*, resistance: float, current: float) -> float:
    """Compute the largest voltage of a supply at which a series resistance holds the current after a breakdown: I R [V]."""
    return current * resistance


def resistor_power(*, voltage: float, resistance: float) -> float:
    """Compute the power in the series resistor while the insulator is a short circuit: V^2/R [W]."""
    return voltage**2 / resistance if resistance > 0 else 0.0


def charging_time(*, resistance: float, capacitance: float) -> float:
    """Compute the time constant [s] with which the plate charges through the resistor: R C.

    C is the capacitance of the plate under the finger and of the stray capacitance behind the resistor [F].
    """
    return resistance * capacitance


def corner_frequency(*, resistance: float, capacitance: float) -> float:
    """Compute the frequency at which the voltage of the plate has fallen by a factor of the square root of 2.

    It is 1/(2 pi R C) [Hz], and infinite without a resistor.
    """
    time_constant = charging_time(resistance=resistance, capacitance=capacitance)
    return 1 / (2 * math.pi * time_constant) if time_constant > 0 else math.inf


def stored_energy_behind(*, voltage: float, capacitance: float) -> float:
    """Compute the energy [J] that the resistor does not limit, which a breakdown releases at once: C V^2/2."""
    return capacitance * voltage**2 / 2
