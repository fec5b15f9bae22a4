#!/usr/bin/env bash
# scipy 1.17.1: scipy.io.netcdf_file(maskandscale=True) applies scale_factor, but not the attribute _Unsigned that belongs
# to the same convention: classic netCDF has no unsigned bytes, so digitisers store counts of 8 bits this way.
# Expected: count 200 with a scale of 0.5 is 100, as netCDF4 and xarray read it. Seen: -28.
# Needs python3 with venv and pip. Exits with 1 if what is seen has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv environment
environment/bin/pip install --quiet "scipy==1.17.1" "netCDF4==1.7.5.1.post1" "xarray==2026.9.0" "numpy==2.4.6"
environment/bin/python - <<'PY'
import netCDF4
import numpy as np
import scipy
import scipy.io
import xarray

with netCDF4.Dataset("counts.nc", "w", format="NETCDF3_CLASSIC") as file:
    file.createDimension("time", 3)
    counts = file.createVariable("voltage", "i1", ("time",))
    counts.setncattr("_Unsigned", "true")
    counts.scale_factor = 0.5
    counts.set_auto_maskandscale(False)
    counts[:] = np.array([1, 127, 200], np.uint8).view(np.int8)
with netCDF4.Dataset("counts.nc") as file:
    expected = np.asarray(file["voltage"][:])
with xarray.open_dataset("counts.nc", engine="scipy") as file:
    assert np.array_equal(file.voltage.values, expected)
with scipy.io.netcdf_file("counts.nc", maskandscale=True, mmap=False) as file:
    seen = np.asarray(file.variables["voltage"][:])
print(f"scipy {scipy.__version__}; expected {expected}; seen {seen}")
assert expected[2] == 100 and seen[2] == -28, "what is seen has changed"
PY
