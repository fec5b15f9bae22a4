"""The bands of a study as CSV: one row for each sample."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.diagnostics import diagnostics_of, warning_lines
from electrovib.core.errors import InputError, printable
from electrovib.core.units import format_quantity
from electrovib.data.atomic import check_writable, write_text
from electrovib.data.marks import Form, unsigned
from electrovib.study.population.words import NOT_JUDGED, method_words

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real


def check_bands(path: Path, *, force: bool = False) -> None:
    """Check, before the study, that its bands can be written."""
    if path.suffix.lower() != ".csv":
        raise InputError(f"the bands of a study are a .csv file, not '{path.suffix}'", path=path)
    check_writable({path: Form.TABLE}, force=force)


def save_bands(found: xarray.Dataset, path: Path, *, force: bool = False) -> list[Path]:
    """Write the bands of a study as CSV."""
    check_bands(path, force=force)
    columns = _columns(found)
    text = io.StringIO()
    text.write(f"# {unsigned(Form.TABLE)}\n")
    remarks = [found.attrs["title"], *method_words(found), *found.attrs["space_remarks"], NOT_JUDGED]
    remarks += warning_lines(diagnostics_of(found))
    text.writelines(f"# {printable(line)}\n" for line in remarks if line)
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([repr(float(value)) for value in row] for row in zip(*columns.values(), strict=True))
    write_text(path, text.getvalue(), Form.TABLE, force=force)
    return [path]


def _columns(found: xarray.Dataset) -> dict[str, Real]:
    axis = str(found[f"{found.attrs['signals'][0]}_mean"].dims[0])
    columns = {f"{axis} [{found[axis].attrs['units']}]": np.asarray(found[axis].values)}
    for name in found.attrs["signals"]:
        unit = found[f"{name}_mean"].attrs["units"]
        columns[f"{name} mean [{unit}]"] = found[f"{name}_mean"].values
        columns[f"{name} variance [{found[f'{name}_variance'].attrs['units']}]"] = found[
            f"{name}_variance"
        ].values
        if f"{name}_percentile" in found:
            bands = found[f"{name}_percentile"]
            for share, row in zip(bands["percentile"].values, bands.values, strict=True):
                columns[f"{name} percentile {float(share):g} [{unit}]"] = row
        if f"{name}_exceedance" in found:
            shares = found[f"{name}_exceedance"]
            for level, row in zip(shares[shares.dims[0]].values, shares.values, strict=True):
                columns[f"{name} exceedance of {format_quantity(float(level), unit)} [1]"] = row
        if f"{name}_unknown" in found:
            columns[f"{name} unknown [1]"] = found[f"{name}_unknown"].values
    return columns
