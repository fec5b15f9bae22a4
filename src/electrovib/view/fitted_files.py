"""The parameters of a fit as text: CSV, a scenario and a space of parameters as TOML."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING

from electrovib.data.marks import Form, unsigned
from electrovib.recordings.fit.as_space import space_tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.fit import ScenarioFit
    from electrovib.recordings.fit.table import EstimatedParameter


def parameters_csv(rows: Sequence[EstimatedParameter]) -> str:
    """Write the table of a fit as CSV, in SI units, with full precision."""
    text = io.StringIO()
    text.write(f"# {unsigned(Form.TABLE)}\n")
    writer = csv.writer(text, lineterminator="\n")
    names = ("name", "unit", "value", "deviation", "lower", "upper", "method", "state", "systematic", "note")
    writer.writerow(names)
    for row in rows:
        cells = [getattr(row, name) for name in names]
        writer.writerow([repr(cell) if isinstance(cell, float) else cell for cell in cells])
    return text.getvalue()


def scenario_toml(found: ScenarioFit) -> str:
    """Write the scenario with the estimated parameters as a TOML file, which `electrovib.load` reads."""
    from electrovib.scenario.toml import to_toml

    return f"# {unsigned(Form.SCENARIO)}\n{to_toml(found.scenario)}"


def space_toml(found: ScenarioFit, rows: Sequence[EstimatedParameter]) -> str:
    """Write the estimates as the table ``space`` of a TOML file: a distribution for each parameter, in SI."""
    import tomlkit

    means = {f"{path} (mean of {len(each.values)} sessions)": path for path, each in found.sessions.items()}
    paths = {each.name: each.path for each in found.unknowns if not each.is_offset and not each.session}
    between = {path: each.between for path, each in found.sessions.items()}
    tables = space_tables(rows, paths | means, between=between)
    text = tomlkit.dumps({"space": tables})
    return f"# {unsigned(Form.SPACE)}\n# Correlations of the estimates are not part of a space.\n{text}"
