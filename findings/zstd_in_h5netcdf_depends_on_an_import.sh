#!/usr/bin/env bash
# h5netcdf 1.8.2 with h5py 3.16.0: whether a netCDF file compressed with Zstandard can be read depends on whether another
# package was imported before. netCDF 4.9 and later write such files (compression="zstd").
# Expected: read, or refused with the name of the filter. Seen: an OSError that does not name it, and the numbers if netCDF4
# was imported first, because that names its own folder of filters in the environment of the process.
# Needs python3 with venv and pip. Exits with 1 if what is seen has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv environment
environment/bin/pip install --quiet "h5netcdf==1.8.2" "h5py==3.16.0" "netCDF4==1.7.5.1.post1" "numpy==2.4.6"
environment/bin/python - <<'PY'
import subprocess
import sys

import netCDF4
import numpy as np

with netCDF4.Dataset("force.nc", "w") as file:
    file.createDimension("time", 1000)
    force = file.createVariable("force", "f8", ("time",), compression="zstd")
    force[:] = np.arange(1000.0)
read = "import h5netcdf; file = h5netcdf.File('force.nc', 'r'); print(file['force'][:].sum())"
alone, after = (
    subprocess.run([sys.executable, "-c", first + read], capture_output=True, text=True, check=False, env={})
    for first in ("", "import netCDF4; ")
)
print("h5netcdf 1.8.2, h5py 3.16.0; expected 499500.0, or a refusal that names the filter, both times")
last = (alone.stderr.strip().splitlines() or [alone.stdout.strip()])[-1]
print(f"seen: alone '{last}'; after 'import netCDF4' {after.stdout.strip()}")
assert alone.returncode and "zstd" not in last.lower() and "32015" not in last, "what is seen has changed"
assert after.stdout.strip() == "499500.0", "what is seen has changed"
PY
