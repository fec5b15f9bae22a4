"""Points of a power law from tables of measured values, and the result as a table."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError, gathered
from electrovib.data.marks import Form, unsigned
from electrovib.data.registry import read_recorded
from electrovib.data.unit_words import kind_and_factor
from electrovib.recordings.importing.choice import column_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
    from electrovib.data.recorded import DataColumn
    from electrovib.recordings.fit.power_law import PowerLawFit


def read_points(
    files: Sequence[str | Path],
    *,
    x: str,
    y: str,
    session: str = "",
    reader: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
) -> tuple[Real, Real, list[str]]:
    """Read x, y, both in SI, and the session, by default the file, of each point of a power law from tables."""
    problems = [f"{path}: is given twice; omit one" for path in dict.fromkeys(files) if files.count(path) > 1]
    if x == y:
        problems.append(f"x, y: both are the column {x!r}; a power law relates two")
    rows: list[tuple[Real, Real]] = []
    names: list[str] = []
    for path in map(Path, files):
        with gathered(problems):
            recorded = read_recorded(path, reader=reader, delimiter=delimiter, decimal_comma=decimal_comma)
            along, values = (
                _in_si(column_of(recorded, stated, option=option)) for option, stated in (("x", x), ("y", y))
            )
            kept = np.isfinite(along) & np.isfinite(values)
            own = [path.name if len(files) == 1 or path.name not in names else str(path)] * int(kept.sum())
            if session:
                numbers = column_of(recorded, session, option="session").values
                kept &= np.isfinite(numbers)
                own = [f"{path.name}: {each:g}" if len(files) > 1 else f"{each:g}" for each in numbers[kept]]
            rows.append((along[kept], values[kept]))
            names += own
    if problems or not rows:
        raise InputError(problems or "files: name at least one table")
    first, second = (np.concatenate(part) for part in zip(*rows, strict=True))
    return first, second, names


def _in_si(column: DataColumn) -> Real:
    """Convert a column from its unit; one without a unit is taken as SI."""
    if not column.unit:
        return column.values
    known = kind_and_factor(column.unit)
    if known is None:
        raise InputError(f"column '{column.name}': the unit '{column.unit}' is not known")
    return np.asarray(column.values * known[1])


def power_law_csv(law: PowerLawFit) -> str:
    """Write a power law as CSV, in SI: a row for each session, then the mean over sessions with its interval."""
    text = io.StringIO()
    text.write(f"# {unsigned(Form.TABLE)}\n# {law.sentence}\n")
    writer = csv.writer(text, lineterminator="\n")
    columns = ("exponent", "standard_error", "factor", "scatter", "degrees_of_freedom")
    spread = ("between", "between_lower", "between_upper")
    writer.writerow(("session", *columns, "lower", "upper", *spread))
    for name, each in law.sessions.items():
        writer.writerow([name, *(repr(getattr(each, column)) for column in columns), *[""] * 5])
    found = law.between
    between = [""] * 3 if found is None else [repr(getattr(found, name)) for name in spread]
    mean = "the session" if found is None else "mean of the sessions"
    ends = (repr(law.lower), repr(law.upper))
    writer.writerow([mean, repr(law.exponent), repr(law.standard_error), *[""] * 3, *ends, *between])
    return text.getvalue()
