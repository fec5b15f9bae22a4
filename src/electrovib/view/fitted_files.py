"""The parameters of a fit as text: CSV, a scenario and a space of parameters as TOML."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING

from electrovib.core.diagnostics import comment_lines
from electrovib.data.marks import Form, unsigned
from electrovib.recordings.fit.result import omitted_from_space, space_correlations, space_tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.diagnostics import Diagnostic
    from electrovib.recordings.fit import ScenarioFit
    from electrovib.recordings.interval import EstimatedParameter


def parameters_csv(rows: Sequence[EstimatedParameter], diagnostics: Sequence[Diagnostic], *said: str) -> str:
    """Write the table of a fit as CSV, in SI units, with full precision, below what is said about model and residuals."""
    text = io.StringIO()
    text.write("".join(f"# {line}\n" for line in (unsigned(Form.TABLE), *_remarks(*said))))
    text.write(comment_lines(diagnostics))
    writer = csv.writer(text, lineterminator="\n")
    names = ("name", "unit", "value", "deviation", "lower", "upper", "method", "state", "systematic", "note")
    writer.writerow(names)
    for row in rows:
        cells = [row.standard_error if name == "deviation" else getattr(row, name) for name in names]
        writer.writerow([repr(cell) if isinstance(cell, float) else cell for cell in cells])
    return text.getvalue()


def scenario_toml(found: ScenarioFit) -> str:
    """Write the scenario with the estimated parameters as a TOML file, which `electrovib.load` reads."""
    from electrovib.scenario.toml import to_toml

    lines = (unsigned(Form.SCENARIO), *_remarks(found.misfit.sentence, *found.prescribed))
    return "".join(f"# {line}\n" for line in lines) + to_toml(found.scenario)


def _remarks(*said: str) -> list[str]:
    """Return sentences as lines of a comment; those that say nothing are omitted."""
    return [" ".join(each.split()) for each in said if each]


def space_toml(found: ScenarioFit, rows: Sequence[EstimatedParameter]) -> str:
    """Write the estimates as the tables ``space`` and ``correlation`` of a TOML file, and why parameters are omitted."""
    import tomlkit

    means = {f"{path} (mean of {len(each.values)} sessions)": path for path, each in found.sessions.items()}
    paths = {each.name: each.path for each in found.unknowns if not each.is_offset and not each.session}
    between = {path: each.between for path, each in found.sessions.items()}
    tables = space_tables(rows, paths | means, between=between)
    pairs = space_correlations(found, tables)
    remarks = [
        f"{path} is omitted: {why}" for path, why in omitted_from_space(rows, paths | means, tables).items()
    ]
    remarks += [
        f"{path} varies between sessions: no correlation with the others is stated"
        for path in found.sessions
        if path in tables and len(tables) > 1
    ]
    content: dict[str, object] = {"space": tables}
    if pairs:
        content["correlation"] = {f"{first} ~ {second}": value for (first, second), value in pairs.items()}
    lines = [unsigned(Form.SPACE), *_remarks(found.misfit.sentence, *remarks)]
    return "".join(f"# {line}\n" for line in lines) + tomlkit.dumps(content)
