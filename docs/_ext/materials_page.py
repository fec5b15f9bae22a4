"""The library of materials as a page of the documentation."""

from __future__ import annotations

import numpy as np
from rst import markdown

from electrovib.core.citation import STATUSES
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.units import format_quantity
from electrovib.physics.material import Material
from electrovib.physics.material.library import SourcedValue, Substance, materials

INTRODUCTION = f"""# Materials

The materials that electrovibration displays are built of. A layer takes one by its name, `material = "silica"` in a file or
`--set stack.insulator.material=silica`; capitals, blanks and hyphens do not count, and the other names below are read too.
The page is made from the declarations of the library, and a test keeps it as they are.

*Status* says how far the source was read: {", ".join(STATUSES[:-1])} or {STATUSES[-1]}, that is cited from memory. A
derived value was computed here from values that were read. Unverified values are marked wherever they are used: in the
sources of a scenario, in the diagnostics of a run and in `electrovib compare SCENARIO --materials all`.

A layer of the library is compared with its breakdown strength. Of several strengths the one is taken that was measured on
the thinnest layer which is at least as thick as that of the scenario, because strength usually falls with thickness. A
strength that is unverified, or was measured on a layer less than half as thick or at a thickness that is not stated, gives
the state `unknown` where the field is within it. A material of one's own keeps that comparison by
`substance = "silica"` in its table; `breakdown_field` of the layer comes first.

A conductivity that no source gives is taken as 0. The relaxation time is the permittivity over the conductivity: a voltage
held for much longer reaches the finger through the layer.

## At a glance

"""
_GLANCE = (
    "material",
    "what it is",
    "permittivity at 1 kHz",
    "conductivity",
    "relaxation",
    "strengths from",
    "to",
)
_VALUES = ("value", "conditions", "status", "source")
_FREQUENCY = 1e3
"""At which the first table gives permittivities [Hz]."""


def as_markdown() -> str:
    """Write the page: a table of all materials, then for each the values with their sources."""
    glance = markdown(_GLANCE, [_glance(each) for each in materials()])
    return INTRODUCTION + glance + "".join(_section(each) for each in materials())


def _glance(substance: Substance) -> tuple[str, ...]:
    material = Material.from_offer(substance)
    permittivity = float(material.bound_permittivity(np.array(_FREQUENCY)).real)
    sigma = material.conductivity
    bound = substance.conductivity_bound
    shown = "not found" if bound is None else f"below {format_quantity(bound.value, 'S/m', digits=3)}"
    time = "none"
    if sigma:
        shown = format_quantity(sigma, "S/m", digits=3)
        time = format_quantity(VACUUM_PERMITTIVITY * permittivity / sigma, "s", digits=3)
    values = [each.value for each in substance.strengths]
    edges = [format_quantity(edge, "V/m", digits=3) for edge in (min(values), max(values))]
    return (f"`{substance.name}`", substance.meaning, f"{permittivity:.4g}", shown, time, *edges)


def _section(substance: Substance) -> str:
    names = ", ".join(substance.aliases)
    rows = [_row("relative permittivity", each) for each in substance.permittivity]
    if substance.dispersion is not None:
        model = substance.dispersion
        numbers = ", ".join(f"{key} = {_number(value)}" for key, value in model.parameters.items())
        rows.append((f"over frequency: {model.model}, {numbers}", "", model.status, model.source))
    rows += [_row("conductivity", each) for each in (substance.conductivity,) if each is not None]
    rows += [_row("conductivity, upper bound", each) for each in (substance.conductivity_bound,) if each]
    if substance.conductivity is None and substance.conductivity_bound is None:
        rows.append(("conductivity: not found, taken as 0", "", "", ""))
    for each in substance.strengths:
        value, conditions, status, source = _row("breakdown strength", each)
        rows.append((value, "; ".join(filter(None, (each.measured_at, conditions))), status, source))
    return (
        f"\n## {substance.name}\n\n{substance.meaning[0].upper()}{substance.meaning[1:]}. Also: {names}.\n\n"
        + markdown(_VALUES, rows)
    )


def _row(what: str, value: SourcedValue) -> tuple[str, ...]:
    shown = format_quantity(value.value, value.unit, digits=4)
    return f"{what} {shown}", value.conditions, value.status, value.source


def _number(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.5g}"
    if isinstance(value, list):
        return "; ".join(", ".join(f"{key} {_number(item)}" for key, item in each.items()) for each in value)
    return str(value)


if __name__ == "__main__":
    print(as_markdown(), end="")
