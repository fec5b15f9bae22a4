#!/usr/bin/env bash
# xarray 2026.9.0 with zarr 3.1.6: rows appended with consolidated=False to a consolidated store of format 2 are on
# disk, but the store opens with its old length, without a warning: the consolidated metadata are left as they were.
# Expected: 6 rows, a refusal, or a warning (a store of format 3 gives 6). Seen: 3, and 6 only with consolidated=False.
# Needs python3 with venv and pip. Exits with 1 if what is seen has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv environment
environment/bin/pip install --quiet "xarray==2026.9.0" "zarr==3.1.6" "numpy==2.4.6"
environment/bin/python - <<'PY'
import warnings

import numpy as np
import xarray
import zarr

halves = [xarray.Dataset({"force": ("time", np.arange(3.0) + at)}, {"time": np.arange(3) + at}) for at in (0, 3)]
lengths = {}
for version in (2, 3):
    name = f"store{version}.zarr"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that format 3 has no specification of consolidated metadata
        halves[0].to_zarr(name, zarr_format=version, consolidated=True)
    halves[1].to_zarr(name, append_dim="time", consolidated=False)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        lengths[version] = xarray.open_zarr(name).sizes["time"]
    assert version == 3 or not said, f"what is seen has changed: {said}"
whole = xarray.open_zarr("store2.zarr", consolidated=False).sizes["time"]
print(f"xarray {xarray.__version__}, zarr {zarr.__version__}; expected 6 rows")
print(f"seen: format 2 {lengths[2]}, format 3 {lengths[3]}; format 2 with consolidated=False {whole}")
assert (lengths[2], lengths[3], whole) == (3, 6, 6), "what is seen has changed"
PY
