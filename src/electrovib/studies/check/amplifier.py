"""What a drive asks of the amplifier before the plate, compared with what this amplifier has.

Without its largest voltage and current an amplifier supplies whatever the drive asks for. A drive that asks for more than
there is can be played; the plate then sees another voltage. So these rows fail a check and bind a design, and refuse no file.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from electrovib.physics.limits import Limits
from electrovib.studies.check import result

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.scenario import Scenario
    from electrovib.studies.check.function import CheckedValues

PLACE: Final = "circuit.amplifier"
LARGEST: Final = ("saturation", "source_current", "sink_current")
"""Parameters of an amplifier that limit what a drive gets of it."""


def without_its_limits(scenario: Scenario, names: Sequence[str] = ("bandwidth", *LARGEST)) -> Scenario:
    """Return a scenario whose amplifier, if it has one, reduces neither voltage nor current; or not by the parameters named."""
    amplifier = scenario.circuit.amplifier
    if amplifier is None or all(getattr(amplifier, name) is None for name in names):
        return scenario
    return scenario.replace({f"{PLACE}.{name}": None for name in names})


def own_limits(scenario: Scenario) -> Limits:
    """Return the largest voltage of an amplifier, and the smaller of its largest currents, as limits."""
    amplifier = scenario.circuit.supply
    if scenario.drive.quantity == "current":
        return Limits()
    least = min(abs(each) for each in amplifier.current_limits)
    return Limits(voltage=amplifier.saturation, current=least if math.isfinite(least) else None)


def asked_rows(scenario: Scenario, asked: CheckedValues) -> list[result.CheckRow]:
    """Compare voltage and current that a drive asks for with the largest ones of the amplifier."""
    own, rows = own_limits(scenario), []
    if own.voltage is not None:
        rows.append(_row("voltage", asked.largest["voltage"], own.voltage, "saturation"))
    if own.current is not None:
        sink, source = scenario.circuit.supply.current_limits
        sides = zip(("source_current", "sink_current"), asked.currents, (source, -sink), strict=True)
        name, value, limit = max(sides, key=lambda side: side[1] / side[2])
        rows.append(_row("current", value, limit, name))
    return rows


def slew_rows(scenario: Scenario, asked: CheckedValues) -> list[result.CheckRow]:
    """Compare the slew rate that a drive asks for with that of the largest current into the stray capacitance alone.

    With a bandwidth the voltage at the output is smoother than the drive, and this says nothing.
    """
    amplifier, limit = scenario.circuit.supply, own_limits(scenario).current
    if limit is None or not amplifier.stray_capacitance or amplifier.bandwidth is not None:
        return []
    slew = limit / amplifier.stray_capacitance
    return [_row("slew_rate", asked.largest["slew_rate"], slew, "source_current over its stray_capacitance")]


def _row(name: str, value: float, limit: float, source: str) -> result.CheckRow:
    """Return the row of a limit of the amplifier itself."""
    own = result.DeclaredLimit(name, limit, f"{PLACE}.{source}")
    words = f"the {name.replace('_', ' ')} that the drive asks of the amplifier"
    return replace(
        result.limit_row(name, value, own, words=words),
        quantity=f"{result.ASKED}{result.limited_quantity(name)}",
    )


def asked_numbers(asked: CheckedValues) -> list[result.CheckNumber]:
    """Return what a drive asks of an amplifier: peaks, root mean square, slew rate and apparent power V_rms I_rms."""
    found = (
        ("voltage", asked.largest["voltage"], "V"),
        ("current", asked.largest["current"], "A"),
        ("rms_current", asked.rms["current"], "A"),
        ("slew_rate", asked.largest["slew_rate"], "V/s"),
        ("apparent_power", asked.rms["voltage"] * asked.rms["current"], "VA"),
    )
    return [
        result.CheckNumber.of(f"{result.ASKED}{result.limited_quantity(name)}", value, unit)
        for name, value, unit in found
    ]
