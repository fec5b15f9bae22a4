"""Comparison of one candidate with every limit."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Final

from electrovib.core.quantity import quantity_of
from electrovib.core.status import UNVERIFIED
from electrovib.physics.limits import SWITCH_ON, WORDS, Limits
from electrovib.physics.safety import AIR
from electrovib.study.check import CheckRow, checked
from electrovib.study.check.result import FAIL, PASS, UNKNOWN
from electrovib.study.check.rows import ONLY_DECLARED, limit_row, limited_quantity
from electrovib.study.percept import verdict
from electrovib.study.plate.objectives import LARGEST, LIMITED

if TYPE_CHECKING:
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.physics.perception import Perception
    from electrovib.scenario import Scenario
    from electrovib.study.check import DeclaredLimit
    from electrovib.study.plate.objectives import Objective

FILM: Final = "film strength"
"""Beginning of the name of the diagnostic of a layer's breakdown."""
FELT: Final = "detection level"
PERCEIVED: Final = "threshold over felt amplitude"
"""Quantity of the row of perception: 1 at the threshold."""
_FELT_STATES: Final = {"detectable": PASS, "not detectable": FAIL}


def judged_limits(declared: Mapping[str, DeclaredLimit], objectives: Sequence[Objective]) -> Limits:
    """Return limits with which a run judges every quantity that a row shows, the largest possible where none is declared.

    Root mean squares and the rate of change, which take a run of their own, need a limit or an objective.
    """
    asked = {LIMITED[each.name] for each in objectives if each.kind == LARGEST}
    values = {}
    for name in WORDS:
        quantity = quantity_of(Limits, name)
        assert quantity is not None
        if name in declared:
            values[name] = declared[name].value
        elif name in asked or name not in ONLY_DECLARED:
            values[name] = quantity.high
    return Limits(**values)


def rows_of(
    scenario: Callable[[], Scenario],
    person: Perception | None,
    diagnostics: Sequence[Diagnostic],
    declared: Mapping[str, DeclaredLimit],
    *,
    level: float | None = None,
) -> tuple[CheckRow, ...]:
    """Compare a candidate with declared limits, breakdown and perception; a row in the state ``"fail"`` forbids it.

    `scenario` is called for limits that a run does not judge; `level` is above the detection threshold [dB].
    """
    largest = _largest(diagnostics)
    names = [name for name in WORDS if name in largest or name in declared or name not in ONLY_DECLARED]
    rest = {name for name in declared if name not in largest}
    elsewhere = {}
    if rest:  # limits that a run does not judge
        wanted = {limited_quantity(name) for name in rest}
        result = checked(scenario(), limits=[_limits(declared)])
        elsewhere = {row.quantity: row for row in result.rows if row.quantity in wanted}
    rows = [
        elsewhere.get(limited_quantity(name)) or limit_row(name, largest.get(name), declared.get(name))
        for name in names
    ]
    rows += [_film_row(each) for each in diagnostics if each.name.startswith(FILM)]
    rows += [_air_row(each) for each in diagnostics if each.name in AIR]
    if level is not None:
        assert person is not None
        rows.append(_felt_row(level, person.threshold_uncertainty))
    return tuple(rows)


def _limits(declared: Mapping[str, DeclaredLimit]) -> Limits:
    return Limits(**{name: each.value for name, each in declared.items()})


def _largest(diagnostics: Sequence[Diagnostic]) -> dict[str, float | None]:
    """Return the largest value of each limited quantity that was judged; infinite without a bound, None if unknown."""
    by_title = {name.replace("_", " "): name for name in WORDS}
    found: dict[str, float | None] = {}
    for each in diagnostics:
        name = by_title.get(each.name.removesuffix(SWITCH_ON))
        if name is None:
            continue
        value = each.value
        if value is None and each.state == "warning":
            value = math.inf
        held = found.get(name)
        if name not in found or held is None or (value is not None and value > held):
            found[name] = value
    return found


def _film_row(found: Diagnostic) -> CheckRow:
    """Return the row of a layer's strength; an unverified strength forbids too, and the row states its status."""
    state = {"ok": PASS, "warning": FAIL, "unknown": UNKNOWN}[found.state]
    return _of_diagnostic(found, state)


def _air_row(found: Diagnostic) -> CheckRow:
    """Return the row of Paschen's law or of field emission, as `electrovib.check` judges them.

    Field emission has a limit cited from memory, which decides nothing. That of Paschen's law depends on such a value only
    through the logarithm of a logarithm: above it the candidate is forbidden, within it is not known to pass.
    """
    forbidden = found.name == "Paschen" and found.state == "warning"
    return _of_diagnostic(found, FAIL if forbidden else UNKNOWN)


def _of_diagnostic(found: Diagnostic, state: str) -> CheckRow:
    return CheckRow(
        quantity=found.name,
        value=found.value,
        limit=found.limit,
        unit=found.unit,
        source=found.text.partition(": ")[2] or found.text,
        state=state,
        text=found.text,
    )


def _felt_row(level: float, uncertainty: float | None) -> CheckRow:
    """Return the row of perception: a change of friction below the detection threshold forbids the candidate."""
    found = verdict(sensation=None if math.isnan(level) else level, uncertainty=uncertainty)
    value = None if math.isnan(level) else float(10 ** (-level / 20))
    return CheckRow(
        quantity=PERCEIVED,
        value=value,
        limit=1.0,
        unit="1",
        source="perception.threshold of the scenario",
        state=_FELT_STATES.get(found, UNKNOWN),
        text=f"the change of friction is {level:.3g} dB above the detection threshold: {found}",
    )


def is_doubtful(row: CheckRow) -> bool:
    """Return whether a candidate within a limit of breakdown rests on a strength that is unverified or may not apply."""
    return row.quantity.startswith(FILM) and (row.state == UNKNOWN or UNVERIFIED in row.text)
