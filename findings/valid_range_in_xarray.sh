#!/usr/bin/env bash
# xarray 2026.9.0: open_dataset applies scale_factor, add_offset and _FillValue, and leaves numbers outside valid_range, which
# the same convention declares to be no data; netCDF4 masks them. A saturated converter then reads as a force.
# Expected: 2 numbers of 4, as netCDF4 reads. Seen: 3 of 4, without a warning.
# Needs python3 with venv and pip. Exits with 1 if what is seen has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv environment
environment/bin/pip install --quiet "xarray==2026.9.0" "netCDF4==1.7.5.1.post1" "numpy==2.4.6"
environment/bin/python - <<'PY'
import warnings

import netCDF4
import numpy as np
import xarray

with netCDF4.Dataset("force.nc", "w") as file:
    file.createDimension("time", 4)
    force = file.createVariable("force", "i2", ("time",), fill_value=-1)
    force.valid_range = np.array([0, 100], "i2")
    force.scale_factor = 0.1
    force.set_auto_maskandscale(False)
    force[:] = [10, 20, 200, -1]
with netCDF4.Dataset("force.nc") as file:
    expected = file["force"][:].count()
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    with xarray.open_dataset("force.nc", engine="netcdf4") as file:
        seen = int(np.isfinite(file.force.values).sum())
assert not [each for each in said if "valid" in str(each.message)], "what is seen has changed"
print(f"xarray {xarray.__version__}, netCDF4 {netCDF4.__version__}; expected {expected} numbers; seen {seen}")
assert (expected, seen) == (2, 3), "what is seen has changed"
PY
