"""A Trace as one table of plain values, for spreadsheets and other programs: one column a signal and layer."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import InputError
from electrovib.data.atomic import writing
from electrovib.data.marks import Form, csv_head
from electrovib.data.traces import prepared

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    import xarray
    from numpy.typing import NDArray

_TABLES: Final = ("time", "frequency")
"""Dimensions over which a table may run; of a Trace with both it is the first."""


def save_csv(trace: xarray.Dataset, path: Path, *, force: bool = False) -> list[Path]:
    """Write a Trace as a table over time, or over frequency if it has no time; of a sweep, a row for each case.

    A layer has a column, a complex number two; a heading has the unit, and a number all its digits. Comments in
    the first lines, which begin with ``#``, state the diagnostics, and what is not in the table.
    """
    import pandas as pd

    stored = prepared(trace, path)
    rows = rows_of_table(stored.sizes, path)
    others = [name for name in _TABLES if name in stored.sizes and name not in rows]
    kept = stored.drop_dims(others)
    left = ", ".join(str(name) for name in stored.variables if name not in kept.variables)
    table = pd.DataFrame(dict(_columns(kept, {name: stored.sizes[name] for name in rows})))
    remarks = [stored.attrs.get("title", ""), left and f"not in this table, but in .nc and .mat: {left}"]
    with (
        writing({path: Form.TABLE}, force=force) as temporaries,
        temporaries[path].open("w", encoding="utf-8", newline="") as out,
    ):
        out.write(csv_head(remarks, diagnostics_of(stored)))
        table.to_csv(out, index=False, lineterminator="\n")
    return [path]


def rows_of_table(sizes: Mapping[Any, int], path: Path) -> list[str]:
    """Return the dimensions of a Trace of these sizes over which its table has rows; refuse records of a sweep."""
    tables = [name for name in _TABLES if name in sizes]
    sweeps = [str(name) for name in sizes if name not in (*_TABLES, "layer")]
    if not tables and not {"layer", "sample"} & set(sizes):
        return sweeps
    if sweeps or not tables:
        also = f"also runs over {', '.join(sweeps)}" if sweeps else "has neither time nor frequency"
        raise InputError(
            f"a CSV file holds one dimension, but this Trace {also}; save as .nc or .mat.", path=path
        )
    return tables[:1]


def _columns(trace: xarray.Dataset, rows: Mapping[str, int]) -> Iterator[tuple[str, NDArray[Any]]]:
    """Iterate over headings and columns, those of the rows first: ``field[gap] [V/m]``, ``impedance.real [ohm]``."""
    layers = (
        trace["layer"].to_numpy().tolist() if "layer" in trace.coords else range(trace.sizes.get("layer", 0))
    )
    for name in dict.fromkeys((*rows, *trace.coords, *trace.data_vars)):
        if name not in trace.variables or name == "layer":
            continue
        variable = trace[name].variable
        has_layers = "layer" in variable.dims
        whole = variable.set_dims(dict(rows) | ({"layer": len(layers)} if has_layers else {})).to_numpy()
        columns = whole.reshape(math.prod(rows.values()), len(layers) if has_layers else 1).T
        unit = f" [{variable.attrs['units']}]" if "units" in variable.attrs else ""
        for label, column in zip(
            [f"[{each}]" for each in layers] if has_layers else [""], columns, strict=True
        ):
            parts = {".real": column.real, ".imag": column.imag} if column.dtype.kind == "c" else {"": column}
            yield from ((f"{name}{label}{part}{unit}", values) for part, values in parts.items())
