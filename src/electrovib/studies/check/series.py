"""Series resistor that holds the body current of a set-up if its insulator fails."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from electrovib.core.answer import Answer, Document, Table
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.physics import safety
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.quantities.answer import validity
from electrovib.studies.check.function import checked_values, declared_limits
from electrovib.studies.check.result import DeclaredLimit, LimitsSource, shown

_LARGEST, _THROUGH = "largest voltage", "largest current through the finger"
_PRESENT = "present series resistance"
_PERMITTIVITY_AT: Final = 1e3
"""Frequency of the permittivities from which the capacitance of the plate follows [Hz]."""


@dataclass(frozen=True, kw_only=True, repr=False)
class SeriesResistor(Answer):
    """Smallest series resistor, what it does to the drive, and what it does not limit.

    - `voltage`, `current`: largest of the supply [V] and through the finger [A], each with who declared it.
    - `resistance`: the smallest between amplifier and plate [ohm].
    - `power`: the largest in it, while the insulator is a short circuit and the body is not counted [W].
    - `capacitance`: of the plate under the finger and the stray capacitance, behind the resistor [F].
    - `time_constant`, `corner`: with which the plate then charges [s], and its corner frequency [Hz].
    - `stored_energy`: behind the resistor at the largest voltage, which it does not limit [J].
    - `present`: series resistance that the scenario has already, circuit.source_resistance [ohm].
    - `supply_voltage`: largest voltage that `present` would allow [V]; None where it is 0.
    - `diagnostics`: those of the scenario.
    """

    voltage: float
    voltage_source: str
    current: float
    current_source: str
    resistance: float
    power: float
    capacitance: float
    time_constant: float
    corner: float
    stored_energy: float
    present: float
    supply_voltage: float | None
    diagnostics: tuple[Diagnostic, ...]

    @property
    def document(self) -> Document:
        """The numbers in words."""
        whose = {_LARGEST: self.voltage_source, _THROUGH: self.current_source}
        rows = {name: (name, shown(value, unit), whose.get(name, "")) for name, value, unit in self.items()}
        if not self.present:
            rows[_PRESENT] = (_PRESENT, "none", "circuit.source_resistance of the scenario is 0")
        caption = (
            "The insulator counts as a short circuit and the body as no resistance. The charge behind the resistor flows through"
            " the finger without passing it; the resistor has to withstand the largest voltage and the power permanently."
        )
        title = "Series resistor between amplifier and plate"
        table = Table(title, ("quantity", "value", "source"), tuple(rows.values()), caption=caption)
        return Document(title=title, sentences=[], diagnostics=self.diagnostics, tables=[table])

    def items(self) -> list[tuple[str, float, str]]:
        """Return name, value and SI unit of every number that is known."""
        found = [
            (_LARGEST, self.voltage, "V"),
            (_THROUGH, self.current, "A"),
            ("smallest series resistance", self.resistance, "ohm"),
            ("power in it with the insulator shorted", self.power, "W"),
            ("capacitance behind it", self.capacitance, "F"),
            ("time constant of the plate", self.time_constant, "s"),
            ("corner frequency of the plate", self.corner, "Hz"),
            ("energy behind it, not limited", self.stored_energy, "J"),
            (_PRESENT, self.present, "ohm"),
        ]
        if self.supply_voltage is not None:
            found.append(("largest supply voltage with it", self.supply_voltage, "V"))
        return found


def series_resistor(
    scenario: Source,
    *,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
) -> SeriesResistor:
    """Compute the smallest series resistor that holds the body current if the insulator is a short circuit.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    limits : as for `electrovib.check`
        Further limits; ``voltage`` is the largest voltage of the supply, by default the largest of the drive, and
        ``body_current``, or else ``current``, the largest current through the finger.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.

    Returns
    -------
    SeriesResistor
        The resistor, its power, and the energy behind it.

    Raises
    ------
    InputError
        If neither limits.body_current nor limits.current is declared.

    Notes
    -----
    R = V/I: the body counts as no resistance. The capacitance is that of the layers of plate and gap under the contact at
    1 kHz, with the finger as a conductor, plus the declared stray capacitance; the energy C V^2/2 stored there is released
    past the resistor.

    Examples
    --------
    >>> round(ev.series_resistor("bau_2010/sine", limits={"current": "1 mA"}).resistance)
    100000
    """
    found = read_scenario(scenario, changes=set)
    declared = declared_limits(found, limits)
    holding = declared.get("body_current") or declared.get("current")
    if holding is None:
        raise InputError(
            "a series resistor needs the largest current through the finger: declare limits.body_current, for instance"
            ' limits = { body_current = "250 uA" }'
        )
    own = "the largest voltage of the drive; limits.voltage is not declared"
    supply = declared.get("voltage") or DeclaredLimit(
        "voltage", checked_values(found).largest["voltage"], own
    )
    voltage = supply.value
    if not math.isfinite(voltage):
        raise InputError("the largest voltage is not known; declare limits.voltage")
    resistance = safety.smallest_series_resistance(voltage=voltage, current=holding.value)
    capacitance = plate_capacitance(found)
    present = found.circuit.source_resistance
    return SeriesResistor(
        voltage=voltage,
        voltage_source=supply.source,
        current=holding.value,
        current_source=holding.source,
        resistance=resistance,
        power=safety.resistor_power(voltage=voltage, resistance=resistance),
        capacitance=capacitance,
        time_constant=safety.charging_time(resistance=resistance, capacitance=capacitance),
        corner=safety.corner_frequency(resistance=resistance, capacitance=capacitance),
        stored_energy=safety.stored_energy_behind(voltage=voltage, capacitance=capacitance),
        present=present,
        supply_voltage=safety.largest_supply_voltage(resistance=present, current=holding.value) or None,
        diagnostics=validity(found),
    )


def plate_capacitance(scenario: Scenario) -> float:
    """Compute the capacitance at 1 kHz of plate and gap under a conducting finger, plus the stray capacitance [F]."""
    roles, layers = scenario.stack.roles, scenario.stack.layers
    frequency = np.array(_PERMITTIVITY_AT)
    thickness = sum(
        layer.thickness / float(layer.material.bound_permittivity(frequency).real)
        for name, layer in layers.items()
        if roles[name] != "finger"
    )
    stray = scenario.circuit.supply.stray_capacitance
    if thickness == 0:
        return stray
    return eps0 * scenario.contact_area / thickness + stray
