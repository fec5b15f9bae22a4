"""The attraction as a behavioural source: the pressure of the force law times the area."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from electrovib.core.errors import InputError
from electrovib.export.spice.equation import written
from electrovib.export.spice.formula import Formula
from electrovib.export.spice.reading import MeterReading
from electrovib.export.spice.text import Names, continued, number, remark

if TYPE_CHECKING:
    from electrovib.export.spice.section import ReadSection
    from electrovib.physics.force import ForceLaw


def force_sources(law: ForceLaw, section: ReadSection, *, second: float) -> tuple[list[str], dict[str, str]]:
    """Return the sources of a force law, and the nodes of its linear quantities; node ``force`` has the attraction.

    `second` is the area of the first contact over that of a second one; 0 without one.
    """
    amplitudes = _readings(law, section)
    names, nodes = Names(), {}
    lines = [
        remark(
            f"force: {type(law).__name__}, Maxwell stress evaluated in: {law.evaluation_surface}; V(force) is the attraction"
            " in N"
        )
    ]
    sources = []
    for name, reading in amplitudes.items():
        nodes[name] = "effective" if name == "effective_voltage" else names.new(f"amplitude_{name}")
        sources.append(continued(f"B_{nodes[name]} {nodes[name]} 0 V = {reading.text}"))
    given = {name: Formula(f"V({node})") for name, node in nodes.items() if name != "effective_voltage"}
    pressure = written(law, "pressure", given, path="force")
    text = f"{number(section.area)}*{pressure.text}"
    if second:
        denser = {name: second * value for name, value in given.items()}
        area = number(section.area / second)
        text += f" + {area}*{written(law, 'pressure', denser, path='force').text}"
    return [*lines, *section.elements, *sources, continued(f"B_force force 0 V = {text}")], nodes


def _readings(law: ForceLaw, section: ReadSection) -> dict[str, MeterReading]:
    try:
        found: dict[str, Any] = dict(law.amplitudes(section))
        effective = law.effective_voltage(section)
    except (TypeError, AttributeError, ValueError, AssertionError) as error:
        found, effective, why = {"": None}, None, f" ({error})" if str(error) else ""
    else:
        why = ""
    if effective is not None:
        found["effective_voltage"] = effective
    if not all(isinstance(reading, MeterReading) for reading in found.values()):
        raise InputError(
            f"force = {type(law).__name__}: its amplitudes are not sums of voltages and currents of a circuit{why}; use"
            " 'electrovib run', or another force.model such as MaxwellStressInGap"
        )
    return found
